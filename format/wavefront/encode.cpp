#include <algorithm>
#include <cassert>

#include "format/wavefront/coder.h"
#include "format/wavefront/encode_avx2.h"
#include "format/wavefront/escapes.h"

namespace cairn::wavefront {
namespace {

/// Division by a frequency f as a multiplication: states are below f·2^21, so 41 bits are exact.
constexpr unsigned kInverseBits = kStateBits + kFrequencyBits;

struct SymbolCode {
  std::uint64_t inverse = 0;
  std::uint32_t renorm_at = 0;  ///< states from here on give a word away first
  std::uint16_t frequency = 0;
  std::uint16_t start = 0;
};

using SymbolCodes = std::array<SymbolCode, kContexts * kSymbols>;

SymbolCodes symbol_codes(const Model& model) {
  SymbolCodes codes{};
  for (std::size_t c = 0; c < kContexts; ++c) {
    const Context& context = model.contexts[c];
    std::uint32_t start = 0;
    for (std::size_t s = 0; s < kSymbols; ++s) {
      const std::uint32_t f = context.frequency[s];
      if (f == 0) continue;
      SymbolCode& code = codes[c * kSymbols + s];
      code.inverse = ((std::uint64_t{1} << kInverseBits) + f - 1) / f;
      code.renorm_at = f << (kStateBits - kFrequencyBits - context.raw_bits);
      code.frequency = static_cast<std::uint16_t>(f);
      code.start = static_cast<std::uint16_t>(start);
      start += f;
    }
  }
  return codes;
}

class SampleEncoder {
 public:
  SampleEncoder(const Model& model, std::size_t samples)
      : model_(model), codes_(symbol_codes(model)), words_(samples) {
    states_.fill(kStateFloor);
    end_ = words_.data() + words_.size();
    next_ = end_;
  }

  /// Samples come last first.
  void put(int lane, std::uint32_t zigzagged, std::uint32_t context) {
    const unsigned raw_bits = model_.contexts[context].raw_bits;
    const std::uint32_t symbol = std::min(zigzagged >> raw_bits, kEscape);
    const SymbolCode& code = codes_[context * kSymbols + symbol];
    std::uint32_t state = states_[static_cast<std::size_t>(lane)];
    if (state >= code.renorm_at) {
      *--next_ = static_cast<std::uint16_t>(state);
      state >>= 16;
    }
    const auto quotient = static_cast<std::uint32_t>((state * code.inverse) >> kInverseBits);
    state = (quotient << kFrequencyBits) + (state - quotient * code.frequency) + code.start;
    state = state << raw_bits | (zigzagged & ((1u << raw_bits) - 1));
    states_[static_cast<std::size_t>(lane)] = state;
  }

  Streams finish() { return {states_, {next_, end_}, {}}; }

 private:
  const Model& model_;
  SymbolCodes codes_;
  std::array<std::uint32_t, kLanes> states_{};
  std::vector<std::uint16_t> words_;  ///< filled from the end; a sample gives at most one
  std::uint16_t* next_ = nullptr;
  std::uint16_t* end_ = nullptr;
};

unsigned context_of(const Model& model, unsigned activity) {
  return static_cast<unsigned>(std::upper_bound(model.limits.begin(), model.limits.end(), activity) -
                               model.limits.begin());
}

}  // namespace

Residuals find_residuals_portable(const Geometry& g, const Plane& plane, const Weights& weights,
                                  Histogram& histogram) {
  const auto offsets = tap_offsets(g);
  Residuals result(g);
  std::vector<std::uint16_t> magnitudes(g.plane_area());
  for (int row = 1; row < g.size; ++row) {
    const std::size_t start = g.row_start(row) + kLeft;
    for (std::size_t i = start; i < start + static_cast<std::size_t>(g.size); ++i) {
      const std::int32_t residual = plane[i] - predict(plane.data() + i, offsets, weights);
      result.zigzagged[i] = zigzag(static_cast<std::int16_t>(residual));
      magnitudes[i] = magnitude(result.zigzagged[i]);
    }
    for (std::size_t i = start; i < start + static_cast<std::size_t>(g.size); ++i) {
      result.activities[i] = static_cast<std::uint16_t>(activity(magnitudes.data() + i, g.width));
      ++histogram
            .counts[Histogram::place(fine_class(result.activities[i]), value_class(result.zigzagged[i]))];
    }
  }
  return result;
}

Streams encode_samples_portable(const Geometry& g, const Model& model, const Residuals& residuals) {
  const auto size = static_cast<std::size_t>(g.size);
  SampleEncoder encoder(model, size * (size - 1));
  for (int step = g.steps - 1; step >= 0; --step) {
    for (int i = kLanes; i-- > 0;) {
      const int lane = lane_at(i);
      const Place place(g, step, lane);
      if (!place.coded) continue;
      const std::size_t at = g.row_start(place.row) + static_cast<std::size_t>(kLeft + place.column);
      encoder.put(lane, residuals.zigzagged[at], context_of(model, residuals.activities[at]));
    }
  }
  Streams streams = encoder.finish();
  std::vector<Escape> escapes;
  for (int row = 1; row < g.size; ++row) {
    for (int column = 0; column < g.size; ++column) {
      const std::size_t at = g.row_start(row) + static_cast<std::size_t>(kLeft + column);
      const std::uint32_t value = residuals.zigzagged[at];
      const unsigned raw_bits = model.contexts[context_of(model, residuals.activities[at])].raw_bits;
      if (value >> raw_bits >= kEscape) escapes.push_back(escape_at(g, row, column, residuals.zigzagged[at]));
    }
  }
  streams.escapes = in_order(escapes);
  return streams;
}

Residuals find_residuals(const Geometry& g, const Plane& plane, const Weights& weights,
                         Histogram& histogram) {
#if defined(__x86_64__)
  if (cpu_has_avx2()) return find_residuals_avx2(g, plane, weights, histogram);
#endif
  return find_residuals_portable(g, plane, weights, histogram);
}

Streams encode_samples(const Geometry& g, const Model& model, const Residuals& residuals) {
#if defined(__x86_64__)
  if (cpu_has_avx2()) return encode_samples_avx2(g, model, residuals);
#endif
  return encode_samples_portable(g, model, residuals);
}

}  // namespace cairn::wavefront
