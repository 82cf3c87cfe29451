#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <nlohmann/json.hpp>

#include "cairn/geodesy.h"
#include "runtime/flight/camera_text.h"
#include "runtime/light/sun_position.h"
#include "runtime/viewer/scene.h"

namespace cairn::viewer {
namespace {

constexpr double kDeclination = 23.44;  // of the sun at the solstice, degrees
constexpr double kPitch = -50;

/// The metadata's bounds; the whole Earth where it has none.
GeoBounds bounds_of(const PackReader& pack) {
  const auto json = nlohmann::json::parse(pack.metadata_json(), nullptr, false);
  const auto bounds = json.is_object() ? json.find("bounds") : json.end();
  if (!json.is_object() || bounds == json.end() || !bounds->is_object()) return {-180, -90, 180, 90};
  return {bounds->value("west", -180.0), bounds->value("south", -90.0), bounds->value("east", 180.0),
          bounds->value("north", 90.0)};
}

}  // namespace

glm::dvec3 sun_direction(LonLat place, double hour) {
  const double lon = glm::radians(place.lon - (hour - 12) * 15);
  const double lat = glm::radians(std::clamp(place.lat, -kDeclination, kDeclination));
  return {std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon), std::sin(lat)};
}

glm::dvec3 sun_direction(LonLat place, const SunTime& time) {
  return time.utc_s ? sun_position(*time.utc_s) : sun_direction(place, time.hour);
}

Result<SunTime> sun_time_of(const Options& options, const PackReader& pack) {
  SunTime time{options.hour, std::nullopt};
  if (options.time.empty()) return time;
  if (!pack.header().body.is_earth()) {
    return usage_error("--time: expected a pack of the Earth, found one of " + pack.header().body.name);
  }
  const Result<double> utc_s = parse_time(options.time);
  if (!utc_s) return utc_s.error();
  time.utc_s = *utc_s;
  return time;
}

HeightRange height_range(const PackReader& pack) {
  const auto levels = pack.levels(Layer::heights);
  std::optional<HeightRange> range;
  for (std::size_t i = 0; levels && i < pack.entry_count(); ++i) {
    const IndexEntry entry = pack.entry(i);
    if (entry.layer != Layer::heights || entry.id.level != levels->coarsest) break;
    const double lowest_m = entry.min_quanta * pack.header().quantum_m,
                 highest_m = entry.max_quanta * pack.header().quantum_m;
    if (!range) range = HeightRange{lowest_m, highest_m};
    range->lowest_m = std::min(range->lowest_m, lowest_m);
    range->highest_m = std::max(range->highest_m, highest_m);
  }
  return range.value_or(HeightRange{});
}

ViewState start_view(const PackReader& pack, double fov_deg, Size size) {
  const GeoBounds bounds = bounds_of(pack);
  ViewState view;
  view.ellipsoid = pack.header().body.shape;
  view.fov_y_deg = fov_deg;
  view.viewport_width_px = size.width;
  view.viewport_height_px = size.height;
  const LonLat middle{(bounds.west + bounds.east) / 2, (bounds.south + bounds.north) / 2};
  const double degree = view.ellipsoid.equator_degree_m();
  const double wide = std::min(bounds.width(), 180.0) * degree * std::cos(glm::radians(middle.lat));
  const double high = std::min(bounds.height(), 180.0) * degree;
  const double half_fov = glm::radians(fov_deg) / 2;
  const double aspect = static_cast<double>(size.width) / size.height;
  const double distance = std::max(high, wide / aspect) / 2 / std::tan(half_fov);
  if (bounds.width() > 60 || bounds.height() > 60) {
    view.eye = middle;
    const double half_angle = std::atan(std::tan(half_fov) * std::min(aspect, 1.0));
    view.height_m = view.ellipsoid.semi_major_m * (1.08 / std::sin(half_angle) - 1);
    view.pitch_deg = -90;
    return view;
  }
  // South of the middle, looking north and down at it.
  const double back = distance * std::cos(glm::radians(-kPitch));
  view.eye = {middle.lon, std::max(middle.lat - back / degree, -90.0)};
  view.height_m = distance * std::sin(glm::radians(-kPitch));
  view.pitch_deg = kPitch;
  return view;
}

Result<ViewState> view_of(const Options& options, const PackReader& pack, Size size) {
  ViewState view = start_view(pack, options.fov_deg, size);
  if (!options.camera.empty()) {
    const Result<ViewState> asked = parse_camera(options.camera);
    if (!asked) return asked.error();
    view = *asked;
    view.ellipsoid = pack.header().body.shape;
  }
  view.fov_y_deg = options.fov_deg;
  view.viewport_width_px = size.width;
  view.viewport_height_px = size.height;
  return view;
}

}  // namespace cairn::viewer
