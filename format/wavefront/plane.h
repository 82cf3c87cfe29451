#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "format/wavefront/geometry.h"
#include "format/wavefront/model.h"

namespace cairn::wavefront {

struct Range {
  std::int32_t low;
  std::int32_t high;
};
Range range_of(std::span<const std::int32_t> samples);

/// The samples of a tile, less its base, with virtual rows and columns around so that every neighbour exists.
/// Both sides fill them by the rules below; Geometry says where things lie.
using Plane = std::vector<std::int16_t>;

/// A whole tile's plane.
Plane make_plane(const Geometry& g, std::span<const std::int32_t> samples, std::int32_t base);

/// Row -1 is a copy of row 0; both have their first and last samples repeated.
void pad_first_rows(const Geometry& g, Plane& plane);

/// Before a row: the starts of the two rows below, as a lane can know them (its neighbours are 3 columns
/// ahead).
inline std::int16_t before_row(const std::int16_t* row_start, std::size_t width, int column) {
  const std::int16_t* below = row_start - width + kLeft;
  return column == -kLeft ? *(below - width) : *below;
}

/// Adds the virtual columns of a row from 1 on.
inline void pad_row(const Geometry& g, Plane& plane, int row) {
  std::int16_t* start = plane.data() + g.row_start(row);
  for (int c = -kLeft; c < 0; ++c) start[c + kLeft] = before_row(start, static_cast<std::size_t>(g.width), c);
  const int end = kLeft + g.size;
  for (int i = end; i < g.width; ++i) start[i] = start[end - 1];
}

/// How far from a sample its taps lie in a plane.
inline std::array<std::ptrdiff_t, kTaps> tap_offsets(const Geometry& g) {
  std::array<std::ptrdiff_t, kTaps> offsets{};
  for (std::size_t i = 0; i < kTaps; ++i) {
    offsets[i] = std::ptrdiff_t{kTapPlaces[i].row} * g.width + kTapPlaces[i].column;
  }
  return offsets;
}

/// What the taps foretell of a sample. Sums wrap, which only damaged or extreme data can make them do.
inline std::int32_t predict(const std::int16_t* sample, const std::array<std::ptrdiff_t, kTaps>& offsets,
                            const Weights& weights) {
  std::uint32_t sum = 1u << (kWeightBits - 1);
  for (std::size_t i = 0; i < kTaps; ++i) {
    sum += static_cast<std::uint32_t>(std::int32_t{weights[i]} * std::int32_t{sample[offsets[i]]});
  }
  return static_cast<std::int32_t>(sum) >> kWeightBits;
}

inline std::uint16_t zigzag(std::int16_t value) {
  return static_cast<std::uint16_t>(static_cast<std::uint16_t>(value) << 1 ^
                                    static_cast<std::uint16_t>(value >> 15));
}
inline std::int16_t unzigzag(std::uint32_t value) {
  return static_cast<std::int16_t>((value >> 1) ^ (0u - (value & 1)));
}

/// What a zigzagged residual counts as in activities.
inline std::uint16_t magnitude(std::uint32_t zigzagged) {
  const std::uint32_t size = (zigzagged + 1) / 2;
  return static_cast<std::uint16_t>(size < kMagnitudeLimit ? size : kMagnitudeLimit);
}

/// A plane's sample as the tile's, and back; both wrap.
inline std::int32_t from_base(std::int16_t sample, std::int32_t base) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(base) + static_cast<std::uint32_t>(sample));
}
inline std::int16_t to_base(std::int32_t sample, std::int32_t base) {
  return static_cast<std::int16_t>(static_cast<std::uint32_t>(sample) - static_cast<std::uint32_t>(base));
}

/// The activity at a sample, from the magnitudes (a plane like that of the samples) around it.
inline std::uint32_t activity(const std::uint16_t* m, std::ptrdiff_t width) {
  const auto at = [&](std::ptrdiff_t column, std::ptrdiff_t row) {
    return std::uint32_t{m[row * width + column]};
  };
  return 4 * at(-1, 0) + 2 * at(-2, 0) + 4 * at(0, -1) + 3 * at(1, -1) + 3 * at(-1, -1) + at(2, -1) +
         at(-2, -1) + 2 * at(0, -2) + at(1, -2) + at(-1, -2);
}

}  // namespace cairn::wavefront
