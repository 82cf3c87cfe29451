#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "format/wavefront/coder.h"
#include "format/wavefront/decode_avx2.h"

namespace cairn::wavefront {

void fill_slots(const Model& model, SlotTable& table) {
  table.fill(0);
  for (std::size_t c = 0; c < kContexts; ++c) {
    const Context& context = model.contexts[c];
    std::uint32_t* slot = table.data() + c * kFrequencyTotal;
    for (std::uint32_t symbol = 0; symbol < kSymbols; ++symbol) {
      const std::uint32_t value = symbol == kEscape ? kEscapeValue : symbol << context.raw_bits;
      const std::uint32_t f = context.frequency[symbol];
      for (std::uint32_t i = 0; i < f; ++i)
        *slot++ = f << kSlotFrequencyShift | i << kSlotOffsetShift | value;
    }
  }
}

namespace {

class PortableDecoder {
 public:
  PortableDecoder(const Geometry& g, const Model& model, const CodedSamples& coded)
      : g_(g),
        model_(model),
        coded_(coded),
        offsets_(tap_offsets(g)),
        plane_(g.plane_area()),
        magnitudes_(g.plane_area()),
        states_(coded.states) {
    fill_slots(model, slots_);
  }

  bool run(std::int32_t base, std::span<std::int32_t> samples) {
    fill_first_row(base, samples);
    for (int step = 0; step < g_.steps && ok_; ++step) {
      for (int i = 0; i < kLanes; ++i) visit(Place(g_, step, lane_at(i)), lane_at(i));
      for (int lane = 0; lane < kLanes; ++lane) fill(Place(g_, step, lane), lane);
    }
    if (!ok_ || word_ != coded_.word_count || escape_ != coded_.escape_count) return false;
    copy_rows(base, samples);
    return std::all_of(states_.begin(), states_.end(), [](std::uint32_t s) { return s == kStateFloor; });
  }

 private:
  void fill_first_row(std::int32_t base, std::span<const std::int32_t> samples) {
    std::int16_t* row = plane_.data() + g_.row_start(0) + kLeft;
    for (int i = 0; i < g_.size; ++i) {
      row[i] = static_cast<std::int16_t>(static_cast<std::uint32_t>(samples[static_cast<std::size_t>(i)]) -
                                         static_cast<std::uint32_t>(base));
    }
    pad_first_rows(g_, plane_);
  }

  std::size_t index(const Place& place) const {
    return g_.row_start(place.row) + static_cast<std::size_t>(kLeft + place.column);
  }

  /// Takes a lane's value from its coder.
  void visit(const Place& place, int lane) {
    if (!place.coded) return;
    const std::uint32_t a = activity(magnitudes_.data() + index(place), g_.width);
    const auto context = static_cast<std::size_t>(
        std::upper_bound(model_.limits.begin(), model_.limits.end(), a) - model_.limits.begin());
    const unsigned raw_bits = model_.contexts[context].raw_bits;
    std::uint32_t& state = states_[static_cast<std::size_t>(lane)];
    const std::uint32_t raw = state & ((1u << raw_bits) - 1);
    state >>= raw_bits;
    const std::uint32_t slot = slots_[context * kFrequencyTotal + state % kFrequencyTotal];
    state = (slot >> kSlotFrequencyShift) * (state >> kFrequencyBits) +
            ((slot >> kSlotOffsetShift) & kSlotOffsetMask);
    if (state < kStateFloor) state = state << 16 | next(coded_.words, word_, coded_.word_count);
    values_[static_cast<std::size_t>(lane)] = (slot & kSlotValueMask) | raw;
  }

  /// Makes a lane's sample from its value.
  void fill(const Place& place, int lane) {
    if (!place.exists) return;
    const std::size_t at = index(place);
    std::int16_t* sample = plane_.data() + at;
    if (!place.coded) {
      *sample = place.column < 0 ? before_row(sample - kLeft - place.column, place.column) : sample[-1];
      return;
    }
    std::uint32_t value = values_[static_cast<std::size_t>(lane)];
    if (value == kEscapeValue) value = next(coded_.escapes, escape_, coded_.escape_count);
    *sample = static_cast<std::int16_t>(predict(sample, offsets_, model_.weights) + unzigzag(value));
    magnitudes_[at] = magnitude(value);
  }

  std::int16_t before_row(const std::int16_t* row_start, int column) const {
    return wavefront::before_row(row_start, static_cast<std::size_t>(g_.width), column);
  }

  std::uint16_t next(const std::byte* values, std::size_t& at, std::size_t count) {
    std::uint16_t value = 0;
    if (at == count) {
      ok_ = false;
    } else {
      std::memcpy(&value, values + 2 * at++, sizeof value);
    }
    return value;
  }

  void copy_rows(std::int32_t base, std::span<std::int32_t> samples) const {
    const auto size = static_cast<std::size_t>(g_.size);
    for (std::size_t row = 1; row < size; ++row) {
      const std::int16_t* from = plane_.data() + g_.row_start(static_cast<int>(row)) + kLeft;
      std::transform(from, from + size, samples.begin() + static_cast<std::ptrdiff_t>(row * size),
                     [&](std::int16_t s) { return from_base(s, base); });
    }
  }

  const Geometry& g_;
  const Model& model_;
  const CodedSamples& coded_;
  std::array<std::ptrdiff_t, kTaps> offsets_;
  Plane plane_;
  std::vector<std::uint16_t> magnitudes_;
  SlotTable slots_;
  std::array<std::uint32_t, kLanes> states_;
  std::array<std::uint32_t, kLanes> values_{};
  std::size_t word_ = 0;
  std::size_t escape_ = 0;
  bool ok_ = true;
};

}  // namespace

bool decode_samples_portable(const Geometry& g, const Model& model, const CodedSamples& coded,
                             std::int32_t base, std::span<std::int32_t> samples) {
  return PortableDecoder(g, model, coded).run(base, samples);
}

bool decode_samples(const Geometry& g, const Model& model, const CodedSamples& coded, std::int32_t base,
                    std::span<std::int32_t> samples) {
#if defined(CAIRN_AVX2_DECODER)
  if (cpu_has_avx2()) return decode_samples_avx2(g, model, coded, base, samples);
#endif
  return decode_samples_portable(g, model, coded, base, samples);
}

}  // namespace cairn::wavefront
