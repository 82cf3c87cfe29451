#pragma once

#include <cstdint>

namespace cairn::CAIRN_ISA {

/// For each 8-bit value, the pair of ends whose blend comes nearest to it, as a | b << 8. Of equally near
/// pairs the one closest together is taken, for GPUs blend with errors that grow with the distance.
struct OneColourTable {
  std::int32_t ends[256];
};

constexpr int widened(int value, int bits) {
  return value << (8 - bits) | value >> (2 * bits - 8);
}
constexpr int distance(int a, int b) {
  return a < b ? b - a : a - b;
}

/// The blends of BC1's index 2, and of index 1 of BC7's two-bit indices.
constexpr int third_of_the_way(int a, int b) {
  return (2 * a + b + 1) / 3;
}
constexpr int share_21_of_64(int a, int b) {
  return (43 * a + 21 * b + 32) >> 6;
}

template <class Blend>
constexpr OneColourTable one_colour_table(int bits, Blend blend) {
  OneColourTable table{};
  int apart[256] = {};  // of the ends of the pair that blends to this value; 256: none does
  for (int& each : apart) each = 256;
  for (int a = 0; a < 1 << bits; ++a) {
    for (int b = 0; b < 1 << bits; ++b) {
      const int wide_a = widened(a, bits), wide_b = widened(b, bits), blended = blend(wide_a, wide_b);
      if (distance(wide_a, wide_b) >= apart[blended]) continue;
      apart[blended] = distance(wide_a, wide_b);
      table.ends[blended] = a | b << 8;
    }
  }
  for (int value = 0; value < 256; ++value) {
    if (apart[value] < 256) continue;
    int nearest = 0;
    for (int other = 0; other < 256; ++other) {
      if (apart[other] < 256 && distance(other, value) < distance(nearest, value)) nearest = other;
    }
    table.ends[value] = table.ends[nearest];
  }
  return table;
}

}  // namespace cairn::CAIRN_ISA
