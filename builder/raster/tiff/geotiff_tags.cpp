#include "builder/raster/tiff/geotiff_tags.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "builder/raster/crs.h"
#include "builder/raster/io/printable.h"
#include "builder/raster/tiff/gdal_metadata.h"
#include "cairn/body.h"

namespace cairn {
namespace {

// Tags.
constexpr std::uint32_t kPixelScale = 33550, kTiepoint = 33922, kTransformation = 34264,
                        kKeyDirectory = 34735, kDoubleParams = 34736, kAsciiParams = 34737,
                        kGdalNodata = 42113;
// Keys.
constexpr int kModelType = 1024, kRasterType = 1025, kCitation = 1026, kGeographicType = 2048,
              kGeogCitation = 2049, kGeodeticDatum = 2050, kPrimeMeridian = 2051, kAngularUnits = 2054,
              kEllipsoid = 2056, kSemiMajor = 2057, kSemiMinor = 2058, kInverseFlattening = 2059,
              kPrimeMeridianLon = 2061, kProjectedType = 3072, kProjectedCitation = 3073, kProjection = 3074,
              kProjMethod = 3075, kLinearUnits = 3076, kNaturalOriginLon = 3080, kNaturalOriginLat = 3081,
              kFalseEasting = 3082, kFalseNorthing = 3083, kScaleAtOrigin = 3092, kVerticalType = 4096,
              kVerticalCitation = 4097, kVerticalUnits = 4099;
// Values.
constexpr int kProjected = 1, kGeographic = 2, kPixelIsPoint = 2, kUserDefined = 32767, kDegree = 9102,
              kMetre = 9001, kTransverseMercator = 1;

int key(const GeoTiffTags& tags, int id) {
  const auto found = tags.short_keys.find(id);
  return found == tags.short_keys.end() ? 0 : found->second;
}

double number(const GeoTiffTags& tags, int id, double otherwise) {
  const auto found = tags.double_keys.find(id);
  return found == tags.double_keys.end() ? otherwise : found->second;
}

std::string text(const GeoTiffTags& tags, int id) {
  const auto found = tags.ascii_keys.find(id);
  return found == tags.ascii_keys.end() ? "" : found->second;
}

/// What the file calls its CRS, for a message.
std::string crs_name(const GeoTiffTags& tags) {
  const int projected = key(tags, kProjectedType), geographic = key(tags, kGeographicType);
  std::string name;
  for (const int id : {kProjectedCitation, kCitation, kGeogCitation})
    if (name.empty()) name = text(tags, id);
  const bool is_projected = key(tags, kModelType) == kProjected || projected != 0;
  const int code = is_projected ? projected : geographic;
  const std::string epsg =
      code == 0 || code == kUserDefined ? "a user-defined CRS" : fmt::format("EPSG:{}", code);
  return name.empty() ? epsg : fmt::format("{} ({})", epsg, printable(name));
}

Error unknown_crs(const GeoTiffTags& tags, const std::filesystem::path& path) {
  return bad_data(fmt::format("{}: CRS: expected an EPSG code, found {}", path.string(), crs_name(tags)));
}

/// Whether the datum, in whatever way it is written, is one that cairn takes for WGS84.
bool has_known_datum(const GeoTiffTags& tags) {
  constexpr int kWgs84Ellipsoid = 7030, kGreenwich = 8901;
  const int code = key(tags, kGeographicType), datum = key(tags, kGeodeticDatum);
  const int meridian = key(tags, kPrimeMeridian);
  Georeference ignored;
  if ((meridian != 0 && meridian != kGreenwich) || number(tags, kPrimeMeridianLon, 0) != 0) return false;
  if (code != 0 && code != kUserDefined)
    return set_crs(ignored, code) && ignored.crs == Georeference::Crs::geographic;
  if (datum != 0 && datum != kUserDefined) return is_near_wgs84(datum);
  const int ellipsoid = key(tags, kEllipsoid);
  return ellipsoid == 0 || ellipsoid == kWgs84Ellipsoid;
}

/// UTM spelt out: by the projection's code (16001…16060 north, 16101…16160 south) or by its parameters.
bool set_user_defined_utm(const GeoTiffTags& tags, Georeference& g) {
  const int projection = key(tags, kProjection);
  if (projection > 16000 && projection <= 16060) return set_utm(g, projection - 16000, true);
  if (projection > 16100 && projection <= 16160) return set_utm(g, projection - 16100, false);
  if (key(tags, kProjMethod) != kTransverseMercator) return false;
  const double zone = (number(tags, kNaturalOriginLon, -1) + 183) / 6;
  const double north = number(tags, kFalseNorthing, 0);
  const bool is_utm = number(tags, kNaturalOriginLat, 0) == 0 && number(tags, kScaleAtOrigin, 1) == 0.9996 &&
                      number(tags, kFalseEasting, 0) == 500000 && (north == 0 || north == 10000000);
  return is_utm && zone == std::floor(zone) && zone >= 1 && zone <= 60 &&
         set_utm(g, static_cast<int>(zone), north == 0);
}

/// The ellipsoid that is spelt out, where it is.
std::optional<Ellipsoid> ellipsoid_of(const GeoTiffTags& tags) {
  const double a = number(tags, kSemiMajor, 0), inverse = number(tags, kInverseFlattening, 0);
  const double b = number(tags, kSemiMinor, inverse == 0 ? a : a * (1 - 1 / inverse));
  if (!std::isfinite(a) || !(b > 0 && b <= a)) return std::nullopt;
  return Ellipsoid{a, b};
}

/// A part of a citation as GDAL writes it, "GCS Name = …|Datum = …|Ellipsoid = …|", or all of another one.
std::string name_in(const std::string& citation, std::string_view part) {
  const std::size_t at = citation.find(part);
  const std::size_t begin = at == std::string::npos ? 0 : at + part.size();
  std::string name = citation.substr(begin, citation.find('|', begin) - begin);
  std::replace(name.begin(), name.end(), '"', '\'');
  return printable(name);
}

/// WKT of degrees on another body's ellipsoid; empty where the keys spell out none.
std::string degrees_on_other_body(const GeoTiffTags& tags) {
  const auto shape = ellipsoid_of(tags);
  if (!shape || body_of(*shape, "").is_earth() || number(tags, kPrimeMeridianLon, 0) != 0) return "";
  const std::string geographic = text(tags, kGeogCitation);
  const std::string citation = geographic.empty() ? text(tags, kCitation) : geographic;
  const std::string name = name_in(citation, "GCS Name = ");
  const double flattening = shape->flattening();
  return fmt::format(
      "GEOGCS[\"{}\",DATUM[\"{}\",SPHEROID[\"{}\",{},{}]],PRIMEM[\"Reference meridian\",0],UNIT[\"degree\","
      "0.0174532925199433]]",
      name.empty() ? "unnamed" : name, name, name_in(citation, "Ellipsoid = "), shape->semi_major_m,
      flattening == 0 ? 0 : 1 / flattening);
}

Status check_units(const GeoTiffTags& tags, const std::filesystem::path& path, bool projected) {
  const int angular = key(tags, kAngularUnits), linear = key(tags, kLinearUnits);
  if (projected && linear != 0 && linear != kMetre)
    return bad_data(
        fmt::format("{}: CRS: expected metres, found the linear unit EPSG:{}", path.string(), linear));
  if (!projected && angular != 0 && angular != kDegree)
    return bad_data(
        fmt::format("{}: CRS: expected degrees, found the angular unit EPSG:{}", path.string(), angular));
  return {};
}

/// Raster coordinates (i, j) to the CRS: x = a·i + b·j + c, y = d·i + e·j + f.
struct Affine {
  double a = 0, b = 0, c = 0, d = 0, e = 0, f = 0;
};

Result<Affine> affine_of(const GeoTiffTags& tags, const std::filesystem::path& path) {
  const auto bad = [&](const std::string& what) {
    return bad_data(path.string() + ": georeference: " + what);
  };
  if (tags.transformation.size() >= 8) {
    const auto& m = tags.transformation;
    return Affine{m[0], m[1], m[3], m[4], m[5], m[7]};
  }
  if (tags.tiepoints.size() < 6) return bad("expected tie points or a transformation, found none");
  if (tags.pixel_scale.size() < 2)
    return bad(
        fmt::format("expected a pixel scale, found none beside {} tie points", tags.tiepoints.size() / 6));
  const auto& t = tags.tiepoints;
  const double sx = tags.pixel_scale[0], sy = tags.pixel_scale[1];
  return Affine{sx, 0, t[3] - t[0] * sx, 0, -sy, t[4] + t[1] * sy};
}

std::optional<double> parse_number(std::string_view s) {
  while (!s.empty() && (s.front() == ' ' || s.front() == '+' || s.front() == '\n')) s.remove_prefix(1);
  while (!s.empty() && (s.back() == ' ' || s.back() == '\n')) s.remove_suffix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(s.data(), s.data() + s.size(), value);
  return error == std::errc() && end == s.data() + s.size() ? std::optional(value) : std::nullopt;
}

/// Metres of the vertical CRS's unit; 0 where it counts downwards. A code that is no vertical CRS's (of a
/// datum, of an ellipsoid) says nothing of the unit, which then is the metre.
double metres_of_vertical_keys(const GeoTiffTags& tags) {
  const int unit = key(tags, kVerticalUnits);
  if (unit != 0 && unit != kUserDefined) return metres_of_unit(unit);
  const int crs = key(tags, kVerticalType);
  constexpr std::array kMetreCodes = {0,    kUserDefined, 3855,
                                      5701, 5703,         5773};  // the commonest, known without PROJ
  if (std::find(kMetreCodes.begin(), kMetreCodes.end(), crs) != kMetreCodes.end()) return 1;
  const auto found = find_vertical_crs(fmt::format("EPSG:{}", crs));
  return found ? found->metres : 1;
}

}  // namespace

void parse_geo_keys(std::span<const std::uint16_t> directory, std::span<const double> doubles,
                    std::string_view ascii, GeoTiffTags& tags) {
  for (std::size_t i = 4; i + 4 <= directory.size(); i += 4) {
    const int id = directory[i];
    const std::size_t count = directory[i + 2], value = directory[i + 3];
    switch (directory[i + 1]) {
      case 0:
        tags.short_keys[id] = static_cast<int>(value);
        break;
      case kDoubleParams:
        if (value < doubles.size()) tags.double_keys[id] = doubles[value];
        break;
      case kAsciiParams: {
        if (value >= ascii.size()) break;
        std::string_view words = ascii.substr(value, count);
        while (!words.empty() && (words.back() == '|' || words.back() == '\0')) words.remove_suffix(1);
        tags.ascii_keys[id] = std::string(words);
        break;
      }
      default:
        break;
    }
  }
}

GeoTiffTags read_geotiff_tags(const TiffHandle& handle) {
  GeoTiffTags tags;
  tags.pixel_scale = handle.doubles(kPixelScale);
  tags.tiepoints = handle.doubles(kTiepoint);
  tags.transformation = handle.doubles(kTransformation);
  tags.gdal_metadata = handle.ascii(kGdalMetadataTag);
  tags.gdal_nodata = handle.ascii(kGdalNodata);
  parse_geo_keys(handle.shorts(kKeyDirectory), handle.doubles(kDoubleParams), handle.ascii(kAsciiParams),
                 tags);
  return tags;
}

Status read_crs(const GeoTiffTags& tags, const std::filesystem::path& path, Georeference& g) {
  const int model = key(tags, kModelType), projected = key(tags, kProjectedType),
            geographic = key(tags, kGeographicType);
  const auto has_code = [](int code) { return code != 0 && code != kUserDefined; };
  if (model == kProjected || (model == 0 && projected != 0)) {
    const bool known = has_code(projected) ? set_crs(g, projected) && g.crs != Georeference::Crs::geographic
                                           : has_known_datum(tags) && set_user_defined_utm(tags, g);
    if (known) return check_units(tags, path, true);
    if (!has_code(projected)) return unknown_crs(tags, path);
    set_other_crs(g, fmt::format("EPSG:{}", projected));
    return {};
  }
  if (model != 0 && model != kGeographic) return unknown_crs(tags, path);
  if (std::string degrees = has_code(geographic) ? "" : degrees_on_other_body(tags); !degrees.empty()) {
    set_other_crs(g, std::move(degrees));
    return check_units(tags, path, false);
  }
  if (has_known_datum(tags)) {
    g.crs = Georeference::Crs::geographic;
    return check_units(tags, path, false);
  }
  if (!has_code(geographic)) return unknown_crs(tags, path);
  set_other_crs(g, fmt::format("EPSG:{}", geographic));
  return {};
}

Result<Georeference> georeference_of(const GeoTiffTags& tags, const std::filesystem::path& path) {
  Georeference g;
  if (auto crs = read_crs(tags, path, g); !crs) return crs.error();
  const auto affine = affine_of(tags, path);
  if (!affine) return affine.error();
  const double centre = key(tags, kRasterType) == kPixelIsPoint ? 0 : 0.5;
  g.x0 = (affine->a + affine->b) * centre + affine->c;
  g.y0 = (affine->d + affine->e) * centre + affine->f;
  g.dx = affine->a;
  g.dy = affine->e;
  g.x_per_row = affine->b;
  g.y_per_column = affine->d;
  return g;
}

HeightTags height_tags_of(const GeoTiffTags& tags, int band) {
  HeightTags height;
  const auto item = [&](const char* role) { return gdal_metadata_item(tags.gdal_metadata, role, band - 1); };
  if (const auto scale = item("scale")) height.scale = parse_number(*scale).value_or(1);
  if (const auto offset = item("offset")) height.offset = parse_number(*offset).value_or(0);
  height.nodata = parse_number(tags.gdal_nodata);
  height.unit = item("unittype").value_or("");
  height.metres = height.unit.empty() ? metres_of_vertical_keys(tags) : metres_of_unit(height.unit);
  if (height.unit.empty() && height.metres == 0)
    height.unit = fmt::format("the vertical CRS EPSG:{}, unit EPSG:{}", key(tags, kVerticalType),
                              key(tags, kVerticalUnits));
  return height;
}

std::optional<VerticalReference> vertical_reference_of(const GeoTiffTags& tags) {
  constexpr int kWgs84InThreeDimensions = 4979;
  const int code = key(tags, kVerticalType);
  if (code != 0 && code != kUserDefined) return vertical_reference(code);
  if (const std::string name = text(tags, kVerticalCitation); code == kUserDefined && !name.empty())
    return vertical_reference_named(name);
  const int geographic = key(tags, kGeographicType);
  if (geographic == kWgs84InThreeDimensions) return vertical_reference(geographic);
  Georeference known;
  const bool in_two_dimensions = geographic == 0 || geographic == kUserDefined || set_crs(known, geographic);
  if (in_two_dimensions || key(tags, kModelType) == kProjected) return std::nullopt;
  const auto crs = find_vertical_crs(fmt::format("EPSG:{}", geographic));
  if (!crs || !crs->is_ellipsoidal) return std::nullopt;
  return VerticalReference{crs->name, VerticalDatum::ellipsoid};
}

void drop_crs(GeoTiffTags& tags) {
  constexpr int kWgs84 = 4326;
  std::erase_if(tags.short_keys, [](const auto& key) {
    return key.first != kRasterType && key.first != kVerticalType && key.first != kVerticalUnits;
  });
  tags.short_keys[kModelType] = kGeographic;
  tags.short_keys[kGeographicType] = kWgs84;
}

}  // namespace cairn
