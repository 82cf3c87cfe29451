#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "format/wavefront/model.h"

namespace cairn::wavefront {

// Fine classes of activity + 1: four to an octave (the lowest octaves have fewer).
inline constexpr unsigned kFineClasses = 4 * 15;
constexpr unsigned fine_class(unsigned activity) {
  const auto octave = static_cast<unsigned>(std::bit_width(activity + 1)) - 1;
  return 4 * octave + (((activity + 1) << 2 >> octave) & 3);
}
static_assert(fine_class(kActivityLimit) < kFineClasses);

// Classes of values that any number of raw bits can be told from: the first 64 values one each, then 32 to an
// octave; last, all that every number of raw bits leaves to escapes.
inline constexpr unsigned kValueClasses = kSymbols + kSymbols / 2 * kMaxRawBits + 1;
constexpr unsigned value_class(unsigned value) {
  if (value < kSymbols) return value;
  const auto octave = static_cast<unsigned>(std::bit_width(value) - std::bit_width(kSymbols)) + 1;
  if (octave > kMaxRawBits) return kValueClasses - 1;
  return kSymbols / 2 * octave + (value >> octave);
}

/// How often which values occur at which activities.
struct Histogram {
  static constexpr unsigned place(unsigned fine_class, unsigned value_class) {
    return fine_class * kValueClasses + value_class;
  }
  std::array<std::uint32_t, kFineClasses * kValueClasses> counts{};
};

/// The limits of the contexts, their raw bits and their frequencies, for these residuals. Fine classes of
/// activity are merged, cheapest merger first, until kContexts are left. REQUIRES: some count is not 0.
void choose_contexts(const Histogram& histogram, Model& model);

}  // namespace cairn::wavefront
