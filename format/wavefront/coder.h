#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "format/wavefront/contexts.h"
#include "format/wavefront/plane.h"

namespace cairn::wavefront {

// Every lane has a range coder of its own (rANS: Duda 2013, arXiv:1311.2540; interleaved as in Giesen 2014,
// arXiv:1402.3392). A state lies in [2^15, 2^31). Reading a sample of a context with r raw bits takes
//   raw = state mod 2^r, state /= 2^r, slot = state mod 2^10, state = frequency·(state / 2^10) + slot - start
// and then, if the state is below 2^15, state = state·2^16 + the next word. Words are taken in order of
// steps; in a step the even lanes come first. Escapes are taken in order of steps and lanes.

inline constexpr unsigned kStateBits = 31;
inline constexpr std::uint32_t kStateFloor = 1u << (kStateBits - 16);

/// The i-th lane to take its word in a step: of each sixteen first the even ones, then the odd ones.
constexpr int lane_at(int i) {
  return i / 16 * 16 + i % 8 * 2 + i % 16 / 8;
}

/// What the coders of a tile write: all that is needed beside the model and row 0.
struct Streams {
  std::array<std::uint32_t, kLanes> states{};  ///< where decoding starts, by lane
  std::vector<std::uint16_t> words;
  std::vector<std::uint16_t> escapes;  ///< zigzagged residuals, in the order of words
};

/// The zigzagged residuals and the activities of a tile, in planes, of which only the coded places are
/// filled.
struct Residuals {
  explicit Residuals(const Geometry& g)
      : zigzagged(std::make_unique_for_overwrite<std::uint16_t[]>(g.plane_area())),
        activities(std::make_unique_for_overwrite<std::uint16_t[]>(g.plane_area())) {}

  std::unique_ptr<std::uint16_t[]> zigzagged;
  std::unique_ptr<std::uint16_t[]> activities;
};

/// What the weights leave of a plane. `histogram` counts them all.
Residuals find_residuals(const Geometry& g, const Plane& plane, const Weights& weights, Histogram& histogram);

Streams encode_samples(const Geometry& g, const Model& model, const Residuals& residuals);

/// The two without wide instructions; they themselves take the best that the CPU has.
Residuals find_residuals_portable(const Geometry& g, const Plane& plane, const Weights& weights,
                                  Histogram& histogram);
Streams encode_samples_portable(const Geometry& g, const Model& model, const Residuals& residuals);

/// What a decoder is given: nothing of it is trusted.
struct CodedSamples {
  std::array<std::uint32_t, kLanes> states{};
  /// Little-endian; at least kReadableAfterWords bytes behind them are readable.
  const std::byte* words = nullptr;
  std::size_t word_count = 0;
  const std::byte* escapes = nullptr;
  std::size_t escape_count = 0;
};
inline constexpr std::size_t kReadableAfterWords = 64;

/// One word for every slot of every context. From bit 0 on: the value less its raw bits, or kEscapeValue;
/// from bit 12 on slot - start; from bit 22 on the frequency.
inline constexpr unsigned kSlotOffsetShift = 12;
inline constexpr unsigned kSlotFrequencyShift = 22;
inline constexpr std::uint32_t kSlotValueMask = 0xfff;
inline constexpr std::uint32_t kSlotOffsetMask = 0x3ff;
inline constexpr std::uint32_t kEscapeValue = 0xfff;
using SlotTable = std::array<std::uint32_t, kContexts * kFrequencyTotal>;
void fill_slots(const Model& model, SlotTable& table);

/// Fills rows 1 … size-1 of `samples`, whose row 0 is there, from south to north; `base` is what the coded
/// samples are less by. False where the coders don't end where they began or words or escapes are too few or
/// too many.
bool decode_samples(const Geometry& g, const Model& model, const CodedSamples& coded, std::int32_t base,
                    std::span<std::int32_t> samples);

/// The same without wide instructions; decode_samples takes the best that the CPU has.
bool decode_samples_portable(const Geometry& g, const Model& model, const CodedSamples& coded,
                             std::int32_t base, std::span<std::int32_t> samples);

}  // namespace cairn::wavefront
