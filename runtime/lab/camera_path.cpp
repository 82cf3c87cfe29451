#include "runtime/lab/camera_path.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>

#include <glm/trigonometric.hpp>

#include "cairn/geodesy.h"
#include "runtime/flight/flight.h"

namespace cairn {
namespace {

/// What a built-in flight needs to know.
struct Course {
  LabTerrain& terrain;
  LonLat start;   ///< the middle of the roughest tile
  LonLat corner;  ///< its south-west corner
  std::size_t frames;

  /// Above the ellipsoid, where the ground is missing or void above 0.
  Result<double> above_ground(LonLat place, double metres) const {
    const auto ground = terrain.ground_m(place);
    if (!ground) return ground.error();
    return std::max(ground->value_or(0), 0.0) + metres;
  }
  double part(std::size_t frame) const {
    return static_cast<double>(frame) / static_cast<double>(frames - 1);
  }
};

LonLat moved(const Course& course, LonLat from, double heading_deg, double metres) {
  const double degree_m = course.terrain.pack().header().body.shape.equator_degree_m();
  const double heading = glm::radians(heading_deg), cosine = std::max(std::cos(glm::radians(from.lat)), 0.01);
  return {from.lon + std::sin(heading) * metres / (degree_m * cosine),
          from.lat + std::cos(heading) * metres / degree_m};
}

ViewState looking(LonLat eye, double height_m, double heading_deg, double pitch_deg) {
  ViewState view;
  view.eye = eye;
  view.height_m = height_m;
  view.heading_deg = heading_deg;
  view.pitch_deg = pitch_deg;
  return view;
}

using Views = Result<std::vector<ViewState>>;

Views hover(const Course& course) {
  std::vector<ViewState> views;
  std::mt19937 random(1);
  const auto shake = [&] { return static_cast<double>(random() % 1000) / 100 - 5; };
  const auto height = course.above_ground(course.corner, 300);
  if (!height) return height.error();
  for (std::size_t i = 0; i < course.frames; ++i) {
    const LonLat eye = moved(course, moved(course, course.corner, 90, shake()), 0, shake());
    views.push_back(looking(eye, *height + shake(), 45, -10));
  }
  return views;
}

/// Above the ground at a height, along a line, at a speed.
Views follow(const Course& course, double metres, double above_m, double heading_deg, double pitch_deg) {
  std::vector<ViewState> views;
  for (std::size_t i = 0; i < course.frames; ++i) {
    const LonLat eye = moved(course, course.start, heading_deg, metres * (course.part(i) - 0.5));
    const auto height = course.above_ground(eye, above_m);
    if (!height) return height.error();
    views.push_back(looking(eye, *height, heading_deg, pitch_deg));
  }
  return views;
}

Views orbit_to_ground(const Course& course) {
  const auto ground = course.above_ground(course.start, 0);
  if (!ground) return ground.error();
  std::vector<ViewState> views;
  for (std::size_t i = 0; i < course.frames; ++i) {
    const double part = course.part(i);
    const double above_m = std::exp(std::lerp(std::log(20e6), std::log(200.0), part));
    views.push_back(
        looking(course.start, *ground + above_m, 30, part < 0.7 ? -90 : -90 + (part - 0.7) * 250));
  }
  return views;
}

Views turn(const Course& course, double above_m, double turn_deg, double first_pitch, double last_pitch) {
  const auto height = course.above_ground(course.start, above_m);
  if (!height) return height.error();
  std::vector<ViewState> views;
  for (std::size_t i = 0; i < course.frames; ++i) {
    views.push_back(looking(course.start, *height, turn_deg * static_cast<double>(i),
                            std::lerp(first_pitch, last_pitch, course.part(i))));
  }
  return views;
}

Views antimeridian(const Course& course) {
  std::vector<ViewState> views;
  for (std::size_t i = 0; i < course.frames; ++i) {
    const double lon = 178 + 4 * course.part(i);
    views.push_back(looking({lon > 180 ? lon - 360 : lon, -16.5}, 60e3, 90, -20));
  }
  return views;
}

Views pole(const Course& course) {
  std::vector<ViewState> views;
  for (std::size_t i = 0; i < course.frames; ++i) {
    const double along = 3 * course.part(i) - 1.5;
    views.push_back(
        looking({along < 0 ? 20.0 : -160.0, 90 - std::abs(along)}, 60e3, along < 0 ? 0 : 180, -30));
  }
  return views;
}

struct BuiltIn {
  std::string_view name;
  Views (*views)(const Course&);
};
constexpr BuiltIn kBuiltIn[] = {
    {"hover", hover},
    {"low", [](const Course& c) { return follow(c, 20e3, 100, 60, -5); }},
    {"orbit-to-ground", orbit_to_ground},
    {"spin", [](const Course& c) { return turn(c, 1000, 15, -10, -10); }},
    {"mach3",
     [](const Course& c) { return follow(c, 102.9 * static_cast<double>(c.frames - 1), 3000, 20, -10); }},
    {"antimeridian", antimeridian},
    {"pole", pole},
    {"pitch", [](const Course& c) { return turn(c, 2000, 0, 0, -90); }},
};

Result<Course> course_over(LabTerrain& terrain, std::size_t frames) {
  const FinestArea* roughest = nullptr;
  const auto relief = [](const FinestArea& a) {
    return std::int64_t{a.source.max_quanta} - a.source.min_quanta;
  };
  const auto range = terrain.pack().levels(Layer::heights);
  for (const FinestArea& area : terrain.finest()) {
    if (area.source.id.level != range->finest) continue;
    if (!roughest || relief(area) > relief(*roughest)) roughest = &area;
  }
  if (!roughest) return bad_data(terrain.pack().path().string() + ": expected tiles of heights, found none");
  const GeoBounds bounds = tile_bounds(roughest->area);
  return Course{terrain,
                {bounds.west + bounds.width() / 2, bounds.south + bounds.height() / 2},
                {bounds.west, bounds.south},
                frames};
}

}  // namespace

const std::vector<std::string_view>& built_in_flights() {
  static const std::vector<std::string_view> names = [] {
    std::vector<std::string_view> all;
    for (const BuiltIn& flight : kBuiltIn) all.push_back(flight.name);
    return all;
  }();
  return names;
}

Result<CameraPath> camera_path(const std::string& name_or_file, LabTerrain& terrain, std::size_t frames) {
  for (const BuiltIn& flight : kBuiltIn) {
    if (flight.name != name_or_file) continue;
    const auto course = course_over(terrain, frames);
    if (!course) return course.error();
    Views views = flight.views(*course);
    if (!views) return views.error();
    return CameraPath{name_or_file, std::move(*views)};
  }
  if (!std::filesystem::exists(name_or_file)) {
    return usage_error("--flight: expected a file or the name of a built-in flight, found \"" + name_or_file +
                       "\"");
  }
  const Result<viewer::Flight> flight = viewer::read_flight(name_or_file);
  if (!flight) return flight.error();
  CameraPath path{std::filesystem::path(name_or_file).stem().string(), {}};
  for (std::size_t i = 0; i < frames; ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(frames - 1);
    path.views.push_back(flight->at(part * flight->keys.back().time_s));
  }
  return path;
}

}  // namespace cairn
