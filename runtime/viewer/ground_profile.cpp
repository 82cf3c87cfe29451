#include "runtime/viewer/ground_profile.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>

#include <glm/geometric.hpp>

#include "cairn/geodesy.h"

namespace cairn::viewer {
namespace {

/// The places of a line, and how far along it each is.
std::vector<ProfileRow> places_along(const Ellipsoid& ellipsoid, const std::vector<LonLat>& line, int steps) {
  std::vector<ProfileRow> rows;
  if (!line.empty()) rows.push_back({0, line.front(), std::nullopt});
  for (std::size_t leg = 0; leg + 1 < line.size(); ++leg) {
    const LonLat from = line[leg];
    const double lon = std::remainder(line[leg + 1].lon - from.lon, 360.0),
                 lat = line[leg + 1].lat - from.lat;
    for (int step = 1; step <= steps; ++step) {
      const double part = static_cast<double>(step) / steps;
      const ProfileRow& last = rows.back();
      const LonLat place{from.lon + lon * part, from.lat + lat * part};
      const double chord_m =
          glm::distance(to_geocentric(last.place, 0, ellipsoid), to_geocentric(place, 0, ellipsoid));
      rows.push_back({last.distance_m + chord_m, place, std::nullopt});
    }
  }
  return rows;
}

}  // namespace

Result<std::vector<ProfileRow>> ground_profile(const PackReader& pack, const std::vector<LonLat>& line,
                                               int steps) {
  std::vector<ProfileRow> rows = places_along(pack.header().body.shape, line, steps);
  PackSampler sampler(pack);
  for (ProfileRow& row : rows) {
    const auto height = sampler.height_at(row.place);
    if (!height) return height.error();
    row.height = *height;
  }
  return rows;
}

double length_m(const PackReader& pack, const std::vector<LonLat>& line) {
  const std::vector<ProfileRow> rows = places_along(pack.header().body.shape, line, 500);
  return rows.empty() ? 0 : rows.back().distance_m;
}

std::string to_csv(const std::vector<ProfileRow>& rows) {
  std::string csv = "distance_m,lon,lat,height_m,error_m,level\n";
  std::array<char, 160> text{};
  for (const ProfileRow& row : rows) {
    std::snprintf(text.data(), text.size(), "%.3f,%.9f,%.9f,", row.distance_m, row.place.lon, row.place.lat);
    csv += text.data();
    if (row.height) {
      std::snprintf(text.data(), text.size(), "%.3f,%.3f,%d\n", row.height->metres,
                    static_cast<double>(row.height->error_m), row.height->level);
      csv += text.data();
    } else {
      csv += ",,\n";
    }
  }
  return csv;
}

}  // namespace cairn::viewer
