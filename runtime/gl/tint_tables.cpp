#include <algorithm>
#include <array>
#include <cassert>
#include <cstdint>

#include "cairn/tint.h"
#include "runtime/gl/srgb.h"

namespace cairn {
namespace {

TintStop stop(double height_m, std::uint32_t srgb) {
  return {height_m, gl::linear_of(srgb)};
}

std::array<NamedTint, 5> make_tints() {
  return {{
      // Water at 0 and below, as the sea is 0 in most sources, then lowland green to snow.
      {"relief",
       "sea blue, green lowland, brown hills, snow",
       false,
       {{-8000, {0.010f, 0.025f, 0.090f}},
        {-200, {0.035f, 0.110f, 0.240f}},
        {0, {0.075f, 0.190f, 0.330f}},
        {1, {0.105f, 0.205f, 0.075f}},
        {300, {0.200f, 0.290f, 0.105f}},
        {900, {0.400f, 0.370f, 0.180f}},
        {1800, {0.340f, 0.230f, 0.120f}},
        {3000, {0.420f, 0.360f, 0.310f}},
        {4500, {0.720f, 0.735f, 0.760f}}}},
      {"atlas",
       "the greens, yellows and browns of school atlases",
       false,
       {stop(-6000, 0x2A5C94), stop(-2000, 0x5B94C8), stop(-200, 0xA8D0EA), stop(0, 0xCDE7F5),
        stop(1, 0x5F9F5C), stop(200, 0x9CC47A), stop(500, 0xE6E3A4), stop(1000, 0xDDB96E),
        stop(2000, 0xB57A3C), stop(3500, 0x8A4F2A), stop(5000, 0xF4F1EE)}},
      {"desert",
       "dry ground: no height says that it is wet or green",
       false,
       {stop(-500, 0x8C7B62), stop(0, 0xC9B48C), stop(600, 0xD8BC84), stop(1400, 0xBF9361),
        stop(2400, 0x95694A), stop(3500, 0x857267), stop(5000, 0xD9D4CE)}},
      {"grey",
       "dark to light grey, spread over the pack's heights",
       true,
       {stop(0, 0x6E6E6E), stop(1, 0xD2D2D2)}},
      // Smith & van der Walt 2015, every eighth part.
      {"viridis",
       "equal steps of height as equal steps of colour, spread over the pack's heights",
       true,
       {stop(0, 0x440154), stop(0.125, 0x472D7B), stop(0.25, 0x3B528B), stop(0.375, 0x2C728E),
        stop(0.5, 0x21918C), stop(0.625, 0x28AE80), stop(0.75, 0x5EC962), stop(0.875, 0xADDC30),
        stop(1, 0xFDE725)}},
  }};
}

}  // namespace

std::span<const NamedTint> tints() {
  static const std::array<NamedTint, 5> all = make_tints();
  return all;
}

const NamedTint* tint_named(std::string_view name) {
  const auto all = tints();
  const auto found = std::find_if(all.begin(), all.end(), [&](const NamedTint& t) { return t.name == name; });
  return found == all.end() ? nullptr : &*found;
}

std::vector<TintStop> stops_of(const NamedTint& tint, double lowest_m, double highest_m) {
  assert(tint.stops.size() <= kMostTintStops);
  std::vector<TintStop> stops = tint.stops;
  if (!tint.spreads) return stops;
  const double range_m = std::max(highest_m - lowest_m, 1e-3);
  for (TintStop& each : stops) each.height_m = lowest_m + each.height_m * range_m;
  return stops;
}

}  // namespace cairn
