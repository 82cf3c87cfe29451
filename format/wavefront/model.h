#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "format/wavefront/bit_stream.h"

namespace cairn::wavefront {

/// A sample's prediction is a weighted sum of twelve neighbours, named by where they are (row -1 is the row
/// below, which is coded before). The order is that of the pairs which the decoder keeps.
struct Tap {
  int column;
  int row;
};
inline constexpr std::size_t kTaps = 12;
inline constexpr std::array<Tap, kTaps> kTapPlaces = {{{-2, 0},
                                                       {-1, 0},
                                                       {1, -1},
                                                       {2, -1},
                                                       {-1, -1},
                                                       {0, -1},
                                                       {-3, -1},
                                                       {-2, -1},
                                                       {0, -2},
                                                       {1, -2},
                                                       {-2, -2},
                                                       {-1, -2}}};
inline constexpr std::size_t kWestTap = 1;

/// Weights are in 1/4096.
inline constexpr int kWeightBits = 12;
using Weights = std::array<std::int16_t, kTaps>;

/// Residuals are coded in up to eight contexts, told apart by the activity: a weighted sum of the magnitudes
/// of the residuals around.
inline constexpr std::size_t kContexts = 8;
inline constexpr std::uint32_t kMagnitudeLimit =
    1023;  ///< magnitudes count as no more, so that activities fit 15 bits
inline constexpr std::uint32_t kActivityLimit = 22 * kMagnitudeLimit;

/// A residual e is zigzagged (0, -1, 1, -2, … become 0, 1, 2, 3, …); in a context, `raw_bits` low bits of
/// that are stored as they are, and the rest is a symbol. Symbol 63 says that the value follows elsewhere,
/// whole.
inline constexpr unsigned kSymbols = 64;
inline constexpr unsigned kEscape = kSymbols - 1;

/// Frequencies of a context's symbols add up to 2^10; none is more than 2^10 - 1.
inline constexpr unsigned kFrequencyBits = 10;
inline constexpr std::uint32_t kFrequencyTotal = 1u << kFrequencyBits;
/// A step takes at most 15 bits from a coder's state, so that one 16-bit word refills it.
inline constexpr unsigned kMaxRawBits = 15 - kFrequencyBits;

struct Context {
  unsigned raw_bits = 0;
  std::array<std::uint16_t, kSymbols> frequency{};
};

/// What the encoder chose for one tile.
struct Model {
  Weights weights{};
  /// Context i has the activities from limits[i-1] (0 for the first) to limits[i] - 1.
  std::array<std::uint16_t, kContexts - 1> limits{};
  std::array<Context, kContexts> contexts{};
};

void write_model(const Model& model, BitWriter& out);

/// False where the bits are no model that write_model would write.
bool read_model(BitReader& in, Model& model);

/// Frequencies in proportion to `counts`, at least 1 where the count is not 0, adding up to kFrequencyTotal,
/// none of them that much.
/// REQUIRES: some count is not 0, and all add up to less than 2^32.
std::array<std::uint16_t, kSymbols> normalise(std::span<const std::uint32_t, kSymbols> counts);

}  // namespace cairn::wavefront
