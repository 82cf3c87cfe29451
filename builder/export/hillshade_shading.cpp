#include "builder/export/hillshade_shading.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

namespace cairn {
namespace {

using Colour = std::array<double, 3>;

/// A tint at a share (0 to 1) of the way from the shore to the highest or deepest place.
struct TintStop {
  double share;
  Colour colour;
};

constexpr TintStop kLand[] = {
    {0.00, {120, 164, 112}}, {0.06, {146, 181, 121}}, {0.16, {190, 203, 143}},
    {0.30, {226, 217, 166}}, {0.46, {212, 186, 132}}, {0.62, {182, 148, 108}},
    {0.78, {164, 142, 126}}, {0.90, {205, 200, 196}}, {1.00, {248, 248, 250}},
};
constexpr TintStop kWater[] = {
    {0.00, {168, 208, 230}}, {0.10, {136, 187, 220}}, {0.35, {96, 153, 200}},
    {0.70, {62, 116, 172}},  {1.00, {38, 80, 136}},
};

Colour tint_at(std::span<const TintStop> stops, double share) {
  const auto above = std::find_if(stops.begin() + 1, stops.end() - 1,
                                  [share](const TintStop& s) { return s.share >= share; });
  const TintStop& low = *(above - 1);
  const double t = std::clamp((share - low.share) / (above->share - low.share), 0.0, 1.0);
  Colour colour;
  for (std::size_t i = 0; i < 3; ++i) colour[i] = low.colour[i] + t * (above->colour[i] - low.colour[i]);
  return colour;
}

Colour tint_of(double metres, const ReliefStyle& style) {
  return metres > 0 ? tint_at(kLand, metres / style.highest_m) : tint_at(kWater, metres / style.deepest_m);
}

struct Gradient {
  double east, north;  // metres a metre
};

/// Horn, "Hill shading and the reflectance map", 1981: weights 1, 2, 1 across the direction. A neighbour that
/// is void or past the grid counts as level ground.
Gradient gradient_at(const HeightField& field, int column, int row, const ReliefStyle& style) {
  const auto at = [&](int c, int r) {
    return static_cast<double>(
        field.metres[static_cast<std::size_t>(r) * static_cast<std::size_t>(field.columns) +
                     static_cast<std::size_t>(c)]);
  };
  const double centre = at(column, row);
  const auto height = [&](int dc, int dr) {
    const int c = std::clamp(column + dc, 0, field.columns - 1), r = std::clamp(row + dr, 0, field.rows - 1);
    const double value = at(c, r);
    return std::isnan(value) ? centre : value;
  };
  const double east = height(1, -1) + 2 * height(1, 0) + height(1, 1);
  const double west = height(-1, -1) + 2 * height(-1, 0) + height(-1, 1);
  const double north = height(-1, -1) + 2 * height(0, -1) + height(1, -1);
  const double south = height(-1, 1) + 2 * height(0, 1) + height(1, 1);
  const double factor = style.exaggeration / 8;
  return {(east - west) * factor / style.column_spacing_m, (north - south) * factor / style.row_spacing_m};
}

/// Unit vector towards the light.
struct Light {
  double east, north, up;
};

Light light_of(const ReliefStyle& style) {
  const double azimuth = style.azimuth_deg * std::numbers::pi / 180;
  const double altitude = style.altitude_deg * std::numbers::pi / 180;
  return {std::sin(azimuth) * std::cos(altitude), std::cos(azimuth) * std::cos(altitude), std::sin(altitude)};
}

/// The cosine between the surface's normal and the light; 0 in shade.
double cosine_on(const Gradient& g, const Light& light) {
  const double towards = -g.east * light.east - g.north * light.north + light.up;
  return std::max(0.0, towards / std::sqrt(1 + g.east * g.east + g.north * g.north));
}

std::uint8_t byte_of(double value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

/// Shade takes colour away, less of blue as the sky still lights it; light adds white.
double lit(double colour, double light, double shade_floor) {
  if (light <= 1) return colour * (shade_floor + (1 - shade_floor) * light);
  return colour + (255 - colour) * 0.6 * (light - 1);
}

}  // namespace

double relief_exaggeration(double pixel_m) {
  return std::max(1.0, std::pow(pixel_m / 80, 0.45));
}

void shade_row(const HeightField& field, int row, const ReliefStyle& style, std::span<std::uint8_t> rgba) {
  assert(row >= 0 && row < field.rows && rgba.size() == 4 * static_cast<std::size_t>(field.columns));
  constexpr std::array<double, 3> kShadeFloor{0.18, 0.21, 0.30};
  const Light light = light_of(style);
  for (int column = 0; column < field.columns; ++column) {
    std::uint8_t* pixel = rgba.data() + 4 * static_cast<std::size_t>(column);
    const double metres = static_cast<double>(
        field.metres[static_cast<std::size_t>(row) * static_cast<std::size_t>(field.columns) +
                     static_cast<std::size_t>(column)]);
    if (std::isnan(metres)) {
      std::fill(pixel, pixel + 4, std::uint8_t{0});
      continue;
    }
    pixel[3] = 255;
    const double cosine = cosine_on(gradient_at(field, column, row, style), light);
    if (!style.tinted) {
      std::fill(pixel, pixel + 3, byte_of(1 + 254 * cosine));  // as gdaldem has it, whose 0 is nodata
      continue;
    }
    // A multiple of what level ground gets.
    const double share = cosine / light.up;
    const Colour tint = tint_of(metres, style);
    for (std::size_t i = 0; i < 3; ++i) pixel[i] = byte_of(lit(tint[i], share, kShadeFloor[i]));
  }
}

void halve_rows(std::span<const std::uint8_t> upper, std::span<const std::uint8_t> lower,
                std::span<std::uint8_t> out) {
  assert(upper.size() == lower.size() && upper.size() == 2 * out.size());
  for (std::size_t to = 0; to < out.size(); to += 4) {
    const std::uint8_t* four[] = {&upper[2 * to], &upper[2 * to + 4], &lower[2 * to], &lower[2 * to + 4]};
    unsigned alpha = 0;
    for (const std::uint8_t* pixel : four) alpha += pixel[3];
    for (std::size_t i = 0; i < 3; ++i) {
      unsigned sum = 0;
      for (const std::uint8_t* pixel : four) sum += unsigned{pixel[i]} * pixel[3];
      out[to + i] = static_cast<std::uint8_t>(alpha == 0 ? 0 : (sum + alpha / 2) / alpha);
    }
    out[to + 3] = static_cast<std::uint8_t>((alpha + 2) / 4);
  }
}

}  // namespace cairn
