#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace cairn {

/// Heights in metres on a regular grid, row-major, rows from NORTH to south as in a picture; NaN is void.
struct HeightField {
  int columns = 0;
  int rows = 0;
  std::vector<float> metres;
};

/// How a relief is drawn.
struct ReliefStyle {
  double column_spacing_m = 0;  ///< ground between two columns
  double row_spacing_m = 0;     ///< ground between two rows
  double exaggeration = 1;      ///< factor on heights, for the light only
  double azimuth_deg = 315;     ///< where the light comes from, clockwise from north
  double altitude_deg = 45;     ///< of the light above the horizon; above 0, at most 90
  bool tinted = true;           ///< by height; else grey
  double highest_m = 4000;      ///< where the tint of land ends; above 0
  double deepest_m = -4000;     ///< where the tint of water ends; below 0
};

/// The slope's exaggeration that keeps relief visible as pixels grow: 1 up to 80 m, 9 at 10 km.
double relief_exaggeration(double pixel_m);

/// One row of a picture: tint by height (0 m and below as water) or grey, light on the slope after Horn
/// (1981), a void transparent. 4 bytes a pixel, R, G, B and alpha, not premultiplied. REQUIRES: 0 <= row <
/// field.rows; rgba.size() == 4 · field.columns.
void shade_row(const HeightField& field, int row, const ReliefStyle& style, std::span<std::uint8_t> rgba);

/// Averages 2×2 pixels into one, by their alpha. `upper` and `lower` are two rows of 2·n pixels, `out` has n.
void halve_rows(std::span<const std::uint8_t> upper, std::span<const std::uint8_t> lower,
                std::span<std::uint8_t> out);

}  // namespace cairn
