#include "tests/support/gdal_oracle.h"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

#include <catch2/catch.hpp>

#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

bool has_gdal() {
  static const bool found = std::system("command -v gdallocationinfo >/dev/null 2>&1") == 0;
  if (!found) WARN("SKIPPED, nothing was compared: gdallocationinfo (Debian's gdal-bin) is not installed");
  return found;
}

std::string output_of(const std::string& command) {
  std::string text;
  FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return text;
  char buffer[4096];
  while (const std::size_t got = std::fread(buffer, 1, sizeof buffer, pipe)) text.append(buffer, got);
  ::pclose(pipe);
  return text;
}

}  // namespace

std::optional<std::vector<double>> gdal_values(const std::filesystem::path& raster,
                                               const std::vector<Post>& posts, int band) {
  if (!has_gdal()) return std::nullopt;
  const TempDir folder;
  const auto list = folder.path() / "posts";
  {
    std::ofstream out(list);
    for (const Post& p : posts) out << p.column << ' ' << p.row << '\n';
  }
  std::istringstream lines(output_of("gdallocationinfo -b " + std::to_string(band) + " -valonly '" +
                                     raster.string() + "' < '" + list.string() + "' 2>/dev/null"));
  std::vector<double> values;
  for (std::string line; std::getline(lines, line);)
    values.push_back(line.empty() ? std::numeric_limits<double>::quiet_NaN()
                                  : std::strtod(line.c_str(), nullptr));
  return values;
}

bool run_gdal(const std::string& command) {
  return has_gdal() && std::system((command + " >/dev/null 2>&1").c_str()) == 0;
}

std::optional<std::vector<double>> proj_transform(const std::string& from, const std::string& to,
                                                  const std::vector<double>& xy) {
  if (!has_gdal()) return std::nullopt;
  const TempDir folder;
  const auto list = folder.path() / "places";
  {
    std::ofstream out(list);
    out.precision(17);
    for (std::size_t i = 0; i < xy.size(); i += 2) out << xy[i] << ' ' << xy[i + 1] << '\n';
  }
  std::istringstream in(
      output_of("gdaltransform -output_xy -s_srs " + from + " -t_srs " + to + " < '" + list.string() + "'"));
  std::vector<double> out;
  for (double v = 0; in >> v;) out.push_back(v);
  return out;
}

std::optional<std::vector<double>> gdal_georeference(const std::filesystem::path& raster) {
  if (!has_gdal()) return std::nullopt;
  const std::string text = output_of("gdalinfo -norat -nomd '" + raster.string() + "' 2>/dev/null");
  const auto origin = text.find("Origin = ("), pixel = text.find("Pixel Size = (");
  double x = 0, y = 0, dx = 0, dy = 0;
  if (origin == std::string::npos || pixel == std::string::npos) return std::nullopt;
  if (std::sscanf(text.c_str() + origin, "Origin = (%lf,%lf)", &x, &y) != 2) return std::nullopt;
  if (std::sscanf(text.c_str() + pixel, "Pixel Size = (%lf,%lf)", &dx, &dy) != 2) return std::nullopt;
  return std::vector{x + dx / 2, y + dy / 2, dx, dy};
}

}  // namespace cairn::test
