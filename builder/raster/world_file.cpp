#include "builder/raster/world_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fstream>
#include <numbers>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "builder/raster/crs.h"
#include "builder/raster/io/printable.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr double kDegree = std::numbers::pi / 180;

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

/// The file beside the image with one of these extensions, in lower or upper case.
std::optional<fs::path> find_beside(const fs::path& image, const std::vector<std::string>& extensions) {
  std::error_code ignored;
  for (const std::string& extension : extensions)
    for (const std::string& spelt : {extension, upper(extension)}) {
      const fs::path file = fs::path(image).replace_extension(spelt);
      if (fs::is_regular_file(file, ignored)) return file;
    }
  return std::nullopt;
}

/// .png has .pgw (first and last letter and w), .pngw and .wld.
std::vector<std::string> world_extensions(const fs::path& image) {
  std::string extension = image.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  std::vector<std::string> names;
  if (extension.size() >= 3) names.push_back(fmt::format(".{}{}w", extension[1], extension.back()));
  if (extension.size() >= 2) names.push_back(extension + "w");
  names.push_back(".wld");
  return names;
}

/// Small text files only: a world file has six lines, a .prj a few kilobytes.
std::string read_text(const fs::path& path) {
  constexpr std::streamsize kMost = 64 * 1024;
  std::string text(static_cast<std::size_t>(kMost), '\0');
  std::ifstream in(path, std::ios::binary);
  in.read(text.data(), kMost);
  text.resize(static_cast<std::size_t>(std::max<std::streamsize>(in.gcount(), 0)));
  return text;
}

/// Six numbers: x over column, y over column, x over row, y over row, then the first pixel's centre.
Status read_world_file(const fs::path& path, Georeference& g) {
  std::istringstream in(read_text(path));
  in.imbue(std::locale::classic());
  std::array<double, 6> n{};
  for (std::size_t i = 0; i < n.size(); ++i)
    if (!(in >> n[i]))
      return bad_data(fmt::format("{}: line {}: expected a number, found none", path.string(), i + 1));
  g.dx = n[0];
  g.y_per_column = n[1];
  g.x_per_row = n[2];
  g.dy = n[3];
  g.x0 = n[4];
  g.y0 = n[5];
  return {};
}

void place_in_bounds(const GeoBounds& bounds, std::int64_t columns, std::int64_t rows, Georeference& g) {
  g.dx = bounds.width() / static_cast<double>(columns);
  g.dy = -bounds.height() / static_cast<double>(rows);
  g.x0 = bounds.west + g.dx / 2;
  g.y0 = bounds.north + g.dy / 2;
}

/// Calls `use` with the place of each bracket of a WKT that is in no quotes and with the depth inside it, or,
/// at a closing one, outside it, until it returns true.
template <class Use>
void walk_brackets(std::string_view wkt, Use use) {
  int depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < wkt.size(); ++i) {
    if (wkt[i] == '"') quoted = !quoted;
    if (quoted) continue;
    const bool opens = wkt[i] == '[' || wkt[i] == '(', closes = wkt[i] == ']' || wkt[i] == ')';
    if (!opens && !closes) continue;
    depth += opens ? 1 : -1;
    if (use(i, opens, depth)) return;
  }
}

/// The number that begins in the first ten characters; 0 where there is none.
int leading_code(std::string_view text) {
  const std::size_t digits = text.find_first_of("0123456789");
  if (digits == std::string_view::npos || digits > 10) return 0;
  int code = 0;
  for (const char c : text.substr(digits, 6)) {
    if (c < '0' || c > '9') break;
    code = code * 10 + (c - '0');
  }
  return code;
}

/// The EPSG code of the CRS itself, not of its parts: AUTHORITY["EPSG","4326"] or ID["EPSG",4326] directly
/// inside the outermost brackets. 0 where there is none.
int outermost_epsg(std::string_view wkt) {
  int code = 0;
  walk_brackets(wkt, [&](std::size_t at, bool opens, int depth) {
    if (!opens || depth != 2) return false;
    const std::string_view before = wkt.substr(0, at), after = wkt.substr(at + 1);
    const bool is_epsg =
        (before.ends_with("AUTHORITY") || before.ends_with("ID")) && after.starts_with("\"EPSG\"");
    if (is_epsg) code = leading_code(after);
    return is_epsg;
  });
  return code;
}

/// "WGS_1984_UTM_Zone_33N", "WGS 84 / UTM zone 33N", "NAD83 / UTM zone 10N" …
bool set_utm_by_name(Georeference& g, const std::string& name) {
  const auto at = name.find("UTM ZONE ");
  const bool datum = name.starts_with("WGS 84") || name.starts_with("WGS 1984") ||
                     name.starts_with("NAD83") || name.starts_with("NAD 1983") || name.starts_with("ETRS");
  if (at == std::string::npos || !datum) return false;
  int zone = 0;
  std::size_t i = at + 9;
  for (; i < name.size() && std::isdigit(static_cast<unsigned char>(name[i])) && zone < 100; ++i)
    zone = zone * 10 + (name[i] - '0');
  return i + 1 == name.size() && (name[i] == 'N' || name[i] == 'S') && set_utm(g, zone, name[i] == 'N');
}

/// The number behind the name in the last element that ends in `element`: PRIMEM["Paris",2.33],
/// UNIT["metre",1]. nullopt where there is none.
std::optional<double> last_number(std::string_view wkt, std::string_view element) {
  const std::size_t at = wkt.rfind(std::string(element) + "[\"");
  if (at == std::string_view::npos) return std::nullopt;
  const std::size_t name_end = wkt.find('"', at + element.size() + 2);
  if (name_end == std::string_view::npos) return std::nullopt;
  const std::size_t digits = wkt.find_first_of("0123456789+-.", name_end);
  if (digits == std::string_view::npos) return std::nullopt;
  double value = 0;
  const auto parsed = std::from_chars(wkt.data() + digits, wkt.data() + wkt.size(), value);
  return parsed.ec == std::errc() ? std::optional(value) : std::nullopt;
}

/// Without what follows the outermost brackets: ESRI puts a vertical CRS there.
std::string_view first_element(std::string_view wkt) {
  std::string_view first = wkt;
  walk_brackets(wkt, [&](std::size_t at, bool opens, int depth) {
    const bool ends = !opens && depth == 0;
    if (ends) first = wkt.substr(0, at + 1);
    return ends;
  });
  return first;
}

/// Whether a CRS counts from Greenwich, and in this unit: what its name alone does not say.
bool counts_in(std::string_view wkt, double unit) {
  constexpr double kRounding = 1e-9;
  return std::abs(last_number(wkt, "PRIMEM").value_or(0)) < kRounding &&
         std::abs(last_number(wkt, "UNIT").value_or(unit) - unit) < kRounding;
}

/// Whether the WKT is of a CRS that cairn computes itself, and then sets it.
bool set_known_crs_of_wkt(Georeference& g, std::string_view whole) {
  const std::string_view wkt = first_element(whole);
  if (const int epsg = outermost_epsg(wkt); epsg != 0) return set_crs(g, epsg);
  std::string name = upper(std::string(name_of_wkt(wkt)));
  std::replace(name.begin(), name.end(), '_', ' ');
  if (wkt.starts_with("GEOG")) {
    constexpr std::array kNames = {
        "WGS 84", "WGS84", "GCS WGS 1984", "NAD83", "GCS NORTH AMERICAN 1983", "ETRS89", "GCS ETRS 1989"};
    g.crs = Georeference::Crs::geographic;
    return counts_in(wkt, kDegree) && std::find(kNames.begin(), kNames.end(), name) != kNames.end();
  }
  if (!counts_in(wkt, 1)) return false;
  if (name == "WGS 1984 WEB MERCATOR AUXILIARY SPHERE" || name == "WGS 84 / PSEUDO-MERCATOR")
    return set_crs(g, 3857);
  return set_utm_by_name(g, name);
}

}  // namespace

std::string_view name_of_wkt(std::string_view wkt) {
  const std::size_t open = wkt.find('"');
  if (open == std::string_view::npos) return "text that is no WKT";
  return wkt.substr(open + 1, wkt.find('"', open + 1) - open - 1);
}

bool set_crs_of_wkt(Georeference& g, std::string_view wkt) {
  if (set_known_crs_of_wkt(g, wkt)) return true;
  if (wkt.find('[') == std::string_view::npos) return false;
  set_other_crs(g, std::string(wkt));
  return true;
}

// ESRI appends the vertical CRS to the horizontal one, behind a comma.
std::optional<VerticalCrs> vertical_crs_beside(const fs::path& image) {
  const auto prj = find_beside(image, {".prj"});
  if (!prj) return std::nullopt;
  const std::string wkt = read_text(*prj);
  if (upper(wkt).find("VERT") == std::string::npos) return std::nullopt;
  const std::string_view first = first_element(wkt);
  const std::size_t appended = wkt.find_first_not_of(", \t\r\n", first.size());
  return find_vertical_crs(appended == std::string::npos ? wkt : wkt.substr(appended));
}

Status read_prj_beside(const fs::path& image, Georeference& g) {
  const auto prj = find_beside(image, {".prj"});
  if (!prj) return {};
  const std::string wkt = read_text(*prj);
  if (set_crs_of_wkt(g, wkt)) return {};
  return bad_data(fmt::format("{}: CRS: expected WKT, found {}", prj->string(), printable(name_of_wkt(wkt))));
}

Result<Georeference> place_beside(const fs::path& image, std::int64_t columns, std::int64_t rows,
                                  const OpenOptions& options, Georeference g) {
  if (const auto world = find_beside(image, world_extensions(image))) {
    if (auto read = read_world_file(*world, g); !read) return read.error();
    return g;
  }
  if (!options.bounds) {
    std::string names;
    for (const std::string& extension : world_extensions(image))
      names += (names.empty() ? "" : ", ") + extension;
    return bad_data(fmt::format(
        "{}: georeference: expected GeoTIFF tags, a world file beside it ({}) or bounds, found none",
        image.string(), names));
  }
  if (g.crs != Georeference::Crs::geographic)
    return bad_data(image.string() +
                    ": georeference: expected a geographic CRS for bounds in degrees, found a projected one");
  place_in_bounds(*options.bounds, columns, rows, g);
  return g;
}

Result<Georeference> georeference_beside(const fs::path& image, std::int64_t columns, std::int64_t rows,
                                         const OpenOptions& options) {
  Georeference g;
  if (auto prj = read_prj_beside(image, g); !prj) return prj.error();
  return place_beside(image, columns, rows, options, g);
}

}  // namespace cairn
