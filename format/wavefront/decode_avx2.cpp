// The decoder with AVX2: two groups of sixteen rows side by side, which hide each other's waiting. A group is
// two vectors of eight 32-bit lanes, the even rows of a band in one and the odd rows in the other, so that
// the row below an odd row is the same lane of the even vector. What is 16 bits wide lies in one vector, row
// r in lane r: seen as 32-bit lanes, even rows are low, odd rows high.

#include "format/wavefront/decode_avx2.h"

#if defined(CAIRN_AVX2_DECODER)

#include <bit>
#include <cstring>
#include <memory>
#include <utility>

#include "format/wavefront/avx2.h"

namespace cairn::wavefront {
namespace {

using Vec = __m256i;

constexpr int kHistory = 8;  // steps that a prediction looks back at most, rounded up to a block
constexpr int kBlock = 8;    // steps between two transpositions
constexpr int kRun = 4 * kBlock;
constexpr int kGroup = 16;  // lanes
constexpr int kGroups = kLanes / kGroup;

/// What a group's upper half leaves for the first lane of the next, at one step: the last lane's value is on
/// top.
struct alignas(64) Handover {
  __m128i even_pairs;
  __m128i odd_pairs;
  __m128i around;
  __m128i below;
};

/// Which lanes do not decode at a step, and what they take instead; 16-bit lanes of 0 or -1.
struct alignas(32) Masks {
  std::int16_t coded[kGroup];
  std::int16_t third_before[kGroup];
  std::int16_t second_before[kGroup];
  std::int16_t just_before[kGroup];
};

/// For every 8-bit mask of lanes: the byte shuffle that puts the next words into these lanes, zero into
/// others.
struct Spread {
  Spread() {
    for (unsigned mask = 0; mask < 256; ++mask) {
      unsigned next = 0;
      for (unsigned lane = 0; lane < 8; ++lane) {
        std::uint8_t* bytes = shuffles[mask] + 4 * lane;
        std::memset(bytes, 0x80, 4);
        if ((mask >> lane & 1) == 0) continue;
        bytes[0] = static_cast<std::uint8_t>(next++);
        bytes[1] = static_cast<std::uint8_t>(next++);
      }
    }
  }
  alignas(64) std::uint8_t shuffles[256][32];
};

const Spread& spread() {
  static const Spread table;
  return table;
}

/// Kept in memory: vectors that are made of immediates each time take longer than loads.
struct Constants {
  Vec weights[kTaps / 2];
  Vec limits[kContexts - 1];  // less one: activity > limit - 1
  Vec raw_bits;               // by context
  Vec raw_masks;
  Vec slot_mask, value_mask, offset_mask, floor, sixteen, half, low_half;  // 32-bit lanes
  Vec escape, one, magnitude_limit;                                        // 16-bit lanes
  const std::uint8_t (*spread)[32];
  const std::uint32_t* slots;
};

/// A group of lanes: what changes from step to step, and the neighbours of the last steps.
struct Group {
  Vec even_states, odd_states;
  Vec odd_pairs;
  Vec m1, pair1;                      // the last step's magnitudes; and with those before
  Vec below1, below2;                 // weighted 1 2 1
  Vec far1, far2, far3, far4;         // that of the row below
  Vec above;                          // what the rows below add to this step's activity
  Vec even[kHistory + kRun];          // pairs (sample before, sample) of the even rows
  Vec even_shifted[kHistory + kRun];  // of the rows two below the even rows
  Vec odd_shifted[kHistory + kRun];   // of the rows below the even rows, and two below the odd rows
  Vec block[kBlock];                  // the samples of the last steps
};

/// How far the streams have been read.
struct Cursor {
  const std::byte* words;
  const std::byte* escapes;
  const std::byte* escapes_end;
};

/// Lane i gets lane i - 1; the first gets the top of `handed`.
CAIRN_AVX2_INLINE Vec shift32(Vec v, __m128i handed) {
  return _mm256_alignr_epi8(
      v, _mm256_inserti128_si256(_mm256_castsi128_si256(handed), _mm256_castsi256_si128(v), 1), 12);
}
CAIRN_AVX2_INLINE Vec shift16(Vec v, __m128i handed) {
  return _mm256_alignr_epi8(
      v, _mm256_inserti128_si256(_mm256_castsi128_si256(handed), _mm256_castsi256_si128(v), 1), 14);
}

/// Puts the even rows' values (low halves of `even`) and the odd rows' into one vector of 16-bit lanes.
CAIRN_AVX2_INLINE Vec weave(Vec even, Vec odd) {
  return _mm256_blend_epi16(even, _mm256_slli_epi32(odd, 16), 0xAA);
}

CAIRN_AVX2_INLINE Vec weave_high(Vec even, Vec odd) {
  return _mm256_blend_epi16(_mm256_srli_epi32(even, 16), odd, 0xAA);
}

struct Taken {
  Vec values;
  Vec states;
};

CAIRN_AVX2_INLINE Taken take(const Constants& k, Vec states, Vec contexts) {
  const Vec raw_bits = _mm256_permutevar8x32_epi32(k.raw_bits, contexts);
  const Vec raw = _mm256_and_si256(states, _mm256_permutevar8x32_epi32(k.raw_masks, contexts));
  const Vec rest = _mm256_srlv_epi32(states, raw_bits);
  const Vec index =
      _mm256_or_si256(_mm256_slli_epi32(contexts, kFrequencyBits), _mm256_and_si256(rest, k.slot_mask));
  const Vec slot = _mm256_i32gather_epi32(reinterpret_cast<const int*>(k.slots), index, 4);
  const Vec value = _mm256_and_si256(slot, k.value_mask);
  const Vec offset = _mm256_and_si256(_mm256_srli_epi32(slot, kSlotOffsetShift), k.offset_mask);
  const Vec frequency = _mm256_srli_epi32(slot, kSlotFrequencyShift);
  return {_mm256_or_si256(value, raw),
          _mm256_add_epi32(_mm256_mullo_epi32(frequency, _mm256_srli_epi32(rest, kFrequencyBits)), offset)};
}

/// Refills the states of `short_ones` with the next words.
CAIRN_AVX2_INLINE Vec refill(const Constants& k, Vec states, Vec short_ones, const std::byte*& words) {
  const auto mask = static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(short_ones)));
  const Vec next = _mm256_broadcastsi128_si256(_mm_loadu_si128(reinterpret_cast<const __m128i*>(words)));
  const Vec low = _mm256_shuffle_epi8(next, _mm256_load_si256(reinterpret_cast<const Vec*>(k.spread[mask])));
  words += 2 * std::popcount(mask);
  return _mm256_or_si256(_mm256_sllv_epi32(states, _mm256_and_si256(short_ones, k.sixteen)), low);
}

/// Replaces the lanes that say so by the next escapes. Rare, so not inline.
CAIRN_AVX2 __attribute__((noinline)) Vec escaped(const Constants& k, Vec values, Cursor& cursor) {
  auto mask = static_cast<unsigned>(_mm256_movemask_epi8(_mm256_cmpeq_epi16(values, k.escape)));
  alignas(32) std::uint16_t lanes[kGroup];
  _mm256_store_si256(reinterpret_cast<Vec*>(lanes), values);
  for (mask &= 0x55555555; mask != 0; mask &= mask - 1) {
    std::uint16_t value = 0;
    if (cursor.escapes < cursor.escapes_end) std::memcpy(&value, cursor.escapes, sizeof value);
    cursor.escapes += sizeof value;
    lanes[std::countr_zero(mask) / 2] = value;
  }
  return _mm256_load_si256(reinterpret_cast<const Vec*>(lanes));
}

/// The weighted sum of the pairs: own row, row below (three pairs), two rows below (two pairs), times 4096.
CAIRN_AVX2_INLINE Vec predict(const Constants& k, Vec own, const Vec* below, const Vec* two_below) {
  const Vec far = _mm256_add_epi32(_mm256_madd_epi16(two_below[-5], k.weights[4]),
                                   _mm256_madd_epi16(two_below[-7], k.weights[5]));
  const Vec old = _mm256_add_epi32(_mm256_madd_epi16(below[-5], k.weights[3]),
                                   _mm256_madd_epi16(below[-3], k.weights[2]));
  const Vec near = _mm256_add_epi32(_mm256_madd_epi16(below[-1], k.weights[1]), k.half);
  const Vec known = _mm256_add_epi32(_mm256_add_epi32(far, old), near);
  return _mm256_add_epi32(known, _mm256_madd_epi16(own, k.weights[0]));
}

CAIRN_AVX2_INLINE Vec mask_of(const std::int16_t* lanes) {
  return _mm256_load_si256(reinterpret_cast<const Vec*>(lanes));
}

/// What lanes that do not decode take: the start of one of the rows below, or their last sample again.
CAIRN_AVX2_INLINE Vec virtual_samples(const Masks& masks, const Group& h, int at) {
  const Vec last = weave_high(h.even[at - 1], h.odd_pairs);
  const Vec third = weave_high(h.even_shifted[at - 3], h.odd_shifted[at - 3]);
  const Vec second = weave_high(h.odd_shifted[at - 1], h.even[at - 1]);
  const Vec just = weave(h.odd_shifted[at - 1], h.even[at - 1]);
  Vec v = _mm256_blendv_epi8(last, third, mask_of(masks.third_before));
  v = _mm256_blendv_epi8(v, second, mask_of(masks.second_before));
  return _mm256_blendv_epi8(v, just, mask_of(masks.just_before));
}

/// The neighbours' sums for a group's samples: all that is not in the values.
CAIRN_AVX2_INLINE Vec predictions_of(const Constants& k, const Group& h, int at) {
  const Vec even_sum = predict(k, h.even[at - 1], h.odd_shifted + at, h.even_shifted + at);
  const Vec odd_sum = predict(k, h.odd_pairs, h.even + at, h.odd_shifted + at);
  return _mm256_blend_epi16(_mm256_srli_epi32(even_sum, kWeightBits),
                            _mm256_slli_epi32(odd_sum, 16 - kWeightBits), 0xAA);
}

/// Contexts, from the magnitudes around.
CAIRN_AVX2_INLINE Vec contexts_of(const Constants& k, const Group& h) {
  const Vec west = _mm256_add_epi16(h.pair1, h.m1);
  const Vec activity = _mm256_add_epi16(_mm256_add_epi16(h.above, west), west);
  Vec over[kContexts - 1];
  for (std::size_t i = 0; i < kContexts - 1; ++i) over[i] = _mm256_cmpgt_epi16(activity, k.limits[i]);
  return _mm256_abs_epi16(_mm256_add_epi16(
      _mm256_add_epi16(_mm256_add_epi16(over[0], over[1]), _mm256_add_epi16(over[2], over[3])),
      _mm256_add_epi16(_mm256_add_epi16(over[4], over[5]), over[6])));
}

/// Notes what the next steps look back at, and returns what the next group needs.
CAIRN_AVX2_INLINE Handover remember(const Constants& k, Group& h, int at, Vec values, Vec samples,
                                    const Handover& in) {
  h.block[at % kBlock] = samples;
  const Vec even_pairs = weave(_mm256_srli_epi32(h.even[at - 1], 16), samples);
  h.even[at] = even_pairs;
  h.odd_pairs = _mm256_blend_epi16(_mm256_srli_epi32(h.odd_pairs, 16), samples, 0xAA);
  h.even_shifted[at] = shift32(even_pairs, in.even_pairs);
  h.odd_shifted[at] = shift32(h.odd_pairs, in.odd_pairs);

  const Vec m0 = _mm256_min_epu16(_mm256_avg_epu16(values, _mm256_setzero_si256()), k.magnitude_limit);
  const Vec pair0 = _mm256_add_epi16(m0, h.m1);
  const Vec below0 = _mm256_add_epi16(pair0, h.pair1);
  const Vec around = _mm256_add_epi16(_mm256_add_epi16(below0, h.below1), _mm256_add_epi16(h.below2, h.far4));
  h.above = shift16(around, in.around);
  h.far4 = h.far3;
  h.far3 = h.far2;
  h.far2 = h.far1;
  h.far1 = shift16(below0, in.below);
  h.below2 = h.below1;
  h.below1 = below0;
  h.pair1 = pair0;
  h.m1 = m0;
  return {_mm256_extracti128_si256(even_pairs, 1), _mm256_extracti128_si256(h.odd_pairs, 1),
          _mm256_extracti128_si256(around, 1), _mm256_extracti128_si256(below0, 1)};
}

/// One step of all groups, `at` in their histories; `masks` only where not all lanes decode. Each stage is
/// done for all groups before the next one, so that a CPU finds work for while it waits for the table.
template <bool kAll>
CAIRN_AVX2_INLINE Handover advance(const Constants& k, std::array<Group, kGroups>& groups, Cursor& cursor,
                                   int at, const Handover& in, const Masks* masks) {
  Handover handover = in;
  Vec predictions[kGroups];
  Vec values[kGroups];
  Taken even[kGroups];
  Taken odd[kGroups];
#pragma GCC unroll 2
  for (std::size_t g = 0; g < kGroups; ++g) predictions[g] = predictions_of(k, groups[g], at);
#pragma GCC unroll 2
  for (std::size_t g = 0; g < kGroups; ++g) {
    const Vec contexts = contexts_of(k, groups[g]);
    even[g] = take(k, groups[g].even_states, _mm256_and_si256(contexts, k.low_half));
    odd[g] = take(k, groups[g].odd_states, _mm256_srli_epi32(contexts, 16));
  }
  const std::byte* words = cursor.words;
  Vec escapes = _mm256_setzero_si256();
#pragma GCC unroll 2
  for (std::size_t g = 0; g < kGroups; ++g) {
    Group& h = groups[g];
    values[g] = weave(even[g].values, odd[g].values);
    Vec even_short = _mm256_cmpgt_epi32(k.floor, even[g].states);
    Vec odd_short = _mm256_cmpgt_epi32(k.floor, odd[g].states);
    if constexpr (!kAll) {
      const Vec coded = mask_of(masks[g].coded);
      const Vec even_coded = _mm256_srai_epi32(_mm256_slli_epi32(coded, 16), 16);
      const Vec odd_coded = _mm256_srai_epi32(coded, 16);
      even[g].states = _mm256_blendv_epi8(h.even_states, even[g].states, even_coded);
      odd[g].states = _mm256_blendv_epi8(h.odd_states, odd[g].states, odd_coded);
      even_short = _mm256_and_si256(even_short, even_coded);
      odd_short = _mm256_and_si256(odd_short, odd_coded);
      values[g] = _mm256_and_si256(values[g], coded);
    }
    h.even_states = refill(k, even[g].states, even_short, words);
    h.odd_states = refill(k, odd[g].states, odd_short, words);
    escapes = _mm256_or_si256(escapes, _mm256_cmpeq_epi16(values[g], k.escape));
  }
  cursor.words = words;
  if (__builtin_expect(_mm256_movemask_epi8(escapes) != 0, 0)) {
    for (Vec& v : values) v = escaped(k, v, cursor);
  }
#pragma GCC unroll 2
  for (std::size_t g = 0; g < kGroups; ++g) {
    Group& h = groups[g];
    const Vec sign = _mm256_sub_epi16(_mm256_setzero_si256(), _mm256_and_si256(values[g], k.one));
    Vec samples = _mm256_add_epi16(predictions[g], _mm256_xor_si256(_mm256_srli_epi16(values[g], 1), sign));
    if constexpr (!kAll)
      samples = _mm256_blendv_epi8(virtual_samples(masks[g], h, at), samples, mask_of(masks[g].coded));
    handover = remember(k, h, at, values[g], samples, handover);
  }
  return handover;
}

/// Turns eight steps of eight lanes into eight columns of eight rows.
CAIRN_AVX2_INLINE void store_block(const __m128i* steps, std::int16_t* const* rows) {
  __m128i in[8], out[8];
  for (int i = 0; i < 8; ++i) in[i] = _mm_load_si128(steps + 2 * i);
  transpose8(in, out);
  for (int i = 0; i < 8; ++i) _mm_storeu_si128(reinterpret_cast<__m128i*>(rows[i]), out[i]);
}

/// For one step of all groups.
using StepMasks = std::array<Masks, kGroups>;

class Avx2Decoder {
 public:
  Avx2Decoder(const Geometry& g, const CodedSamples& coded, std::int32_t base,
              std::span<std::int32_t> samples)
      : g_(g),
        coded_(coded),
        base_(base),
        samples_(samples),
        delay_(g.width - kLag - kSkew),
        ring_mask_(static_cast<int>(std::bit_ceil(static_cast<unsigned>(delay_) + kBlock)) - 1),
        ring_(std::make_unique<Handover[]>(static_cast<std::size_t>(ring_mask_) + 1)),
        lane_stride_(static_cast<std::size_t>(g.steps + kLag + 2 * kBlock)),
        lanes_(std::make_unique_for_overwrite<std::int16_t[]>(lane_stride_ * kLanes)),
        full_steps_((g.size - 1) / kLanes * g.width) {
    for (int step = 0; step < g.width; ++step) {
      if (!all_decode(step)) steady_.push_back(masks_at(g.width + step, true));
    }
  }

  CAIRN_AVX2 bool run(const Model& model);

 private:
  /// In all bands but the first and an incomplete last, whether every lane decodes at this step of the band.
  bool all_decode(int band_step) const { return band_step >= kLag + kLeft && band_step < kLeft + g_.size; }

  StepMasks masks_at(int step, bool assume_rows) const;
  void hand_over_first_row(int step, Handover& handover) const;
  Handover& ring_at(int step) { return ring_[static_cast<std::size_t>(step & ring_mask_)]; }
  CAIRN_AVX2 void start(const Model& model);
  CAIRN_AVX2 void set_constants(const Model& model);
  CAIRN_AVX2 void step_with_masks(int step, int band_step, int at);
  CAIRN_AVX2 void end_block(int first_step, int at);
  CAIRN_AVX2 bool ended() const;
  CAIRN_AVX2 void copy_rows();
  std::int16_t* lane_start(int lane) {
    return lanes_.get() + static_cast<std::size_t>(lane) * lane_stride_ + kLag;
  }

  const Geometry& g_;
  const CodedSamples& coded_;
  std::int32_t base_;
  std::span<std::int32_t> samples_;
  int delay_;  ///< steps from when the last lane has a sample to when the first lane needs it
  int ring_mask_;
  std::unique_ptr<Handover[]> ring_;  ///< what the last group handed over in the last steps
  std::size_t lane_stride_;
  std::unique_ptr<std::int16_t[]> lanes_;  ///< each lane's rows one behind the other
  int full_steps_;                         ///< before these are over, no lane is past the last row
  std::vector<StepMasks> steady_;          ///< of the steps of a band at which not all lanes decode
  Constants k_;
  std::array<Group, kGroups> groups_{};
  Cursor cursor_{};
  alignas(64) SlotTable slots_;
};

StepMasks Avx2Decoder::masks_at(int step, bool assume_rows) const {
  StepMasks result{};
  for (int lane = 0; lane < kLanes; ++lane) {
    Masks& masks = result[static_cast<std::size_t>(lane / kGroup)];
    const int i = lane % kGroup;
    const Place place(g_, step, lane);
    const bool coded = (place.exists || assume_rows) && place.column >= 0 && place.column < g_.size;
    masks.coded[i] = coded ? -1 : 0;
    masks.third_before[i] = place.column == -3 ? -1 : 0;
    masks.second_before[i] = place.column == -2 ? -1 : 0;
    masks.just_before[i] = place.column == -1 ? -1 : 0;
  }
  return result;
}

/// What row 0 hands to the first band, as if a band had been before it.
void Avx2Decoder::hand_over_first_row(int step, Handover& handover) const {
  const auto sample = [&](int place) {
    const int column = std::clamp(place - kLeft, 0, g_.size - 1);
    return static_cast<std::uint32_t>(
        static_cast<std::uint16_t>(to_base(samples_[static_cast<std::size_t>(column)], base_)));
  };
  const auto pair = [&](int place) { return static_cast<int>(sample(place - 1) | sample(place) << 16); };
  handover.odd_pairs = _mm_set_epi32(pair(step + kSkew), 0, 0, 0);
  // The last even lane begins a skew before the last lane.
  if (step + 2 * kSkew < g_.width) handover.even_pairs = _mm_set_epi32(pair(step + 2 * kSkew), 0, 0, 0);
}

CAIRN_AVX2 __attribute__((noinline)) void Avx2Decoder::set_constants(const Model& model) {
  for (std::size_t i = 0; i < kTaps / 2; ++i) {
    const auto low = static_cast<std::uint16_t>(model.weights[2 * i]);
    const auto high = static_cast<std::uint16_t>(model.weights[2 * i + 1]);
    k_.weights[i] = _mm256_set1_epi32(static_cast<int>(low | static_cast<std::uint32_t>(high) << 16));
  }
  for (std::size_t i = 0; i < kContexts - 1; ++i) {
    k_.limits[i] = _mm256_set1_epi16(static_cast<std::int16_t>(model.limits[i] - 1));
  }
  alignas(32) std::array<std::uint32_t, kContexts> bits;
  alignas(32) std::array<std::uint32_t, kContexts> masks;
  for (std::size_t i = 0; i < kContexts; ++i) {
    bits[i] = model.contexts[i].raw_bits;
    masks[i] = (1u << bits[i]) - 1;
  }
  k_.raw_bits = _mm256_load_si256(reinterpret_cast<const Vec*>(bits.data()));
  k_.raw_masks = _mm256_load_si256(reinterpret_cast<const Vec*>(masks.data()));
  k_.slot_mask = _mm256_set1_epi32(kFrequencyTotal - 1);
  k_.value_mask = _mm256_set1_epi32(kSlotValueMask);
  k_.offset_mask = _mm256_set1_epi32(kSlotOffsetMask);
  k_.floor = _mm256_set1_epi32(kStateFloor);
  k_.sixteen = _mm256_set1_epi32(16);
  k_.half = _mm256_set1_epi32(1 << (kWeightBits - 1));
  k_.low_half = _mm256_set1_epi32(0xffff);
  k_.escape = _mm256_set1_epi16(kEscapeValue);
  k_.one = _mm256_set1_epi16(1);
  k_.magnitude_limit = _mm256_set1_epi16(kMagnitudeLimit);
  k_.spread = spread().shuffles;
  fill_slots(model, slots_);
  k_.slots = slots_.data();
}

CAIRN_AVX2 void Avx2Decoder::start(const Model& model) {
  set_constants(model);
  alignas(32) std::array<std::uint32_t, kLanes> states;
  for (int i = 0; i < kLanes; ++i) {
    states[static_cast<std::size_t>(i)] = coded_.states[static_cast<std::size_t>(lane_at(i))];
  }
  for (std::size_t i = 0; i < kGroups; ++i) {
    groups_[i].even_states = _mm256_load_si256(reinterpret_cast<const Vec*>(states.data() + kGroup * i));
    groups_[i].odd_states = _mm256_load_si256(reinterpret_cast<const Vec*>(states.data() + kGroup * i + 8));
  }
  cursor_ = {coded_.words, coded_.escapes, coded_.escapes + 2 * coded_.escape_count};
  for (int step = 0; step < delay_; ++step) hand_over_first_row(step, ring_at(step));
  for (int step = -kHistory; step < 0; ++step) {
    Handover handover{};
    hand_over_first_row(step, handover);
    groups_[0].even_shifted[kHistory + step] = shift32(_mm256_setzero_si256(), handover.even_pairs);
    groups_[0].odd_shifted[kHistory + step] = shift32(_mm256_setzero_si256(), handover.odd_pairs);
  }
}

CAIRN_AVX2 __attribute__((noinline)) void Avx2Decoder::step_with_masks(int step, int band_step, int at) {
  StepMasks own;
  const StepMasks* masks = &own;
  if (!all_decode(band_step) && step >= kLag && step < full_steps_) {
    const int skipped = band_step < kLag + kLeft ? 0 : std::max(0, g_.size - kLag);
    masks = &steady_[static_cast<std::size_t>(band_step - skipped)];
  } else {
    own = masks_at(step, false);
  }
  Handover handover = advance<false>(k_, groups_, cursor_, at, ring_at(step), masks->data());
  if (step < kLag) hand_over_first_row(step + delay_, handover);
  ring_at(step + delay_) = handover;
}

/// Writes the samples of the last steps to the lanes' rows, and makes room in the histories.
CAIRN_AVX2 void Avx2Decoder::end_block(int first_step, int at) {
  for (int i = 0; i < kGroups; ++i) {
    Group& group = groups_[static_cast<std::size_t>(i)];
    std::int16_t* rows[kGroup];
    for (int j = 0; j < kGroup; ++j) {
      const int lane = kGroup * i + j;
      rows[j] = lane_start(lane) + first_step - kSkew * lane;
    }
    store_block(reinterpret_cast<const __m128i*>(group.block), rows);
    store_block(reinterpret_cast<const __m128i*>(group.block) + 1, rows + 8);
    if (at < kHistory + kRun) continue;
    for (Vec* v : {group.even, group.even_shifted, group.odd_shifted}) {
      std::memcpy(v, v + kRun, kHistory * sizeof(Vec));
    }
  }
}

CAIRN_AVX2 bool Avx2Decoder::run(const Model& model) {
  start(model);
  const std::byte* const words_end = coded_.words + 2 * coded_.word_count;
  int band_step = 0;
  int at = kHistory;
  for (int step = 0; step < g_.steps; ++step) {
    if (all_decode(band_step) && step < full_steps_) {
      ring_at(step + delay_) = advance<true>(k_, groups_, cursor_, at, ring_at(step), nullptr);
    } else {
      step_with_masks(step, band_step, at);
    }
    if (cursor_.words > words_end) return false;
    if (++band_step == g_.width) band_step = 0;
    ++at;
    if (at % kBlock == 0 || step == g_.steps - 1) {
      end_block(step - (at - 1) % kBlock, at);
      if (at == kHistory + kRun) at = kHistory;
    }
  }
  if (!ended()) return false;
  copy_rows();
  return true;
}

CAIRN_AVX2 bool Avx2Decoder::ended() const {
  Vec all = _mm256_set1_epi32(-1);
  for (const Group& group : groups_) {
    all = _mm256_and_si256(all, _mm256_cmpeq_epi32(group.even_states, k_.floor));
    all = _mm256_and_si256(all, _mm256_cmpeq_epi32(group.odd_states, k_.floor));
  }
  return _mm256_movemask_epi8(all) == -1 && cursor_.words == coded_.words + 2 * coded_.word_count &&
         cursor_.escapes == cursor_.escapes_end;
}

CAIRN_AVX2 void Avx2Decoder::copy_rows() {
  const Vec base = _mm256_set1_epi32(base_);
  for (int row = 1; row < g_.size; ++row) {
    const std::int16_t* from = lane_start((row - 1) % kLanes) + (row - 1) / kLanes * g_.width + kLeft;
    std::int32_t* to = samples_.data() + static_cast<std::size_t>(row) * static_cast<std::size_t>(g_.size);
    int i = 0;
    for (; i + 8 <= g_.size; i += 8) {
      const Vec wide = _mm256_cvtepi16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(from + i)));
      _mm256_storeu_si256(reinterpret_cast<Vec*>(to + i), _mm256_add_epi32(wide, base));
    }
    for (; i < g_.size; ++i) to[i] = from_base(from[i], base_);
  }
}

}  // namespace

bool decode_samples_avx2(const Geometry& g, const Model& model, const CodedSamples& coded, std::int32_t base,
                         std::span<std::int32_t> samples) {
  return std::make_unique<Avx2Decoder>(g, coded, base, samples)->run(model);
}

}  // namespace cairn::wavefront

#endif
