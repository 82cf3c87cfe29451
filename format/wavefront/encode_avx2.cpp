// The encoder with AVX2. Residuals are found row by row; the coders then run backwards through the steps,
// their lanes in the same vectors as in the decoder.

#include "format/wavefront/encode_avx2.h"

#if defined(__x86_64__)

#include <bit>
#include <cstring>

#include "format/wavefront/escapes.h"

namespace cairn::wavefront {
namespace {

using Vec = __m256i;

constexpr int kGroup = 16;  // 16-bit lanes of a vector
constexpr int kGroups = kLanes / kGroup;

CAIRN_AVX2_INLINE Vec load(const void* p) {
  return _mm256_loadu_si256(static_cast<const __m256i*>(p));
}
CAIRN_AVX2_INLINE void store(void* p, Vec v) {
  _mm256_storeu_si256(static_cast<__m256i*>(p), v);
}

// --- Residuals ---

/// Predictions of sixteen samples, mod 2^16.
CAIRN_AVX2_INLINE Vec predict16(const std::int16_t* sample, const std::array<std::ptrdiff_t, kTaps>& offsets,
                                const Vec* weights) {
  Vec low = _mm256_set1_epi32(1 << (kWeightBits - 1));
  Vec high = low;
  for (std::size_t i = 0; i < kTaps / 2; ++i) {
    const Vec a = load(sample + offsets[2 * i]);
    const Vec b = load(sample + offsets[2 * i + 1]);
    low = _mm256_add_epi32(low, _mm256_madd_epi16(_mm256_unpacklo_epi16(a, b), weights[i]));
    high = _mm256_add_epi32(high, _mm256_madd_epi16(_mm256_unpackhi_epi16(a, b), weights[i]));
  }
  // Only the lower 16 bits count, so the packing must not saturate.
  const Vec mask = _mm256_set1_epi32(0xffff);
  return _mm256_packus_epi32(_mm256_and_si256(_mm256_srli_epi32(low, kWeightBits), mask),
                             _mm256_and_si256(_mm256_srli_epi32(high, kWeightBits), mask));
}

CAIRN_AVX2_INLINE Vec zigzag16(Vec v) {
  return _mm256_xor_si256(_mm256_add_epi16(v, v), _mm256_srai_epi16(v, 15));
}

struct RowWork {
  const std::int16_t* samples;
  std::uint16_t* zigzagged;
  std::uint16_t* activities;
  std::uint16_t* magnitudes;  ///< of this row and, a row apart, those below
};

CAIRN_AVX2 void find_row(const Geometry& g, const Weights& weights, const Vec* pairs,
                         const std::array<std::ptrdiff_t, kTaps>& offsets, const RowWork& work) {
  int i = 0;
  for (; i + kGroup <= g.size; i += kGroup) {
    const Vec residuals =
        _mm256_sub_epi16(load(work.samples + i), predict16(work.samples + i, offsets, pairs));
    const Vec values = zigzag16(residuals);
    store(work.zigzagged + i, values);
    store(work.magnitudes + i, _mm256_min_epu16(_mm256_avg_epu16(values, _mm256_setzero_si256()),
                                                _mm256_set1_epi16(kMagnitudeLimit)));
  }
  for (; i < g.size; ++i) {
    const std::int32_t residual = work.samples[i] - predict(work.samples + i, offsets, weights);
    work.zigzagged[i] = zigzag(static_cast<std::int16_t>(residual));
    work.magnitudes[i] = magnitude(work.zigzagged[i]);
  }
}

CAIRN_AVX2_INLINE Vec activity16(const std::uint16_t* m, std::ptrdiff_t row) {
  const auto at = [&](std::ptrdiff_t column, std::ptrdiff_t rows_below)
      __attribute__((target("avx2,bmi,bmi2,lzcnt,popcnt"), always_inline)) {
    return load(m - rows_below * row + column);
  };
  const Vec near = _mm256_add_epi16(at(0, 1), at(-1, 0));                             // 4
  const Vec beside = _mm256_add_epi16(at(1, 1), at(-1, 1));                           // 3
  const Vec twice = _mm256_add_epi16(_mm256_add_epi16(at(-2, 0), at(0, 2)), beside);  // 2
  const Vec once = _mm256_add_epi16(_mm256_add_epi16(at(2, 1), at(-2, 1)),
                                    _mm256_add_epi16(_mm256_add_epi16(at(1, 2), at(-1, 2)), beside));
  return _mm256_add_epi16(_mm256_add_epi16(_mm256_slli_epi16(near, 2), _mm256_add_epi16(twice, twice)), once);
}

CAIRN_AVX2 void find_activities(const Geometry& g, const RowWork& work, std::ptrdiff_t magnitude_row) {
  int i = 0;
  for (; i + kGroup <= g.size; i += kGroup) {
    store(work.activities + i, activity16(work.magnitudes + i, magnitude_row));
  }
  for (; i < g.size; ++i) {
    work.activities[i] = static_cast<std::uint16_t>(activity(work.magnitudes + i, magnitude_row));
  }
}

/// Of eight 32-bit values from 1 on: the bits of a float from this many of its mantissa's on. The conversion
/// is exact.
template <int kMantissaBits>
CAIRN_AVX2_INLINE Vec logarithm(Vec v) {
  return _mm256_srli_epi32(_mm256_castps_si256(_mm256_cvtepi32_ps(v)), 23 - kMantissaBits);
}

/// fine_class and value_class at once, as a place in the histogram.
CAIRN_AVX2_INLINE Vec places8(Vec activities, Vec values) {
  constexpr int kBias = 127;
  const Vec fine = _mm256_sub_epi32(logarithm<2>(_mm256_add_epi32(activities, _mm256_set1_epi32(1))),
                                    _mm256_set1_epi32(4 * kBias));
  // From 32 on both formulas agree, below the first one gives more, above the second.
  const Vec low = _mm256_min_epi32(values, _mm256_set1_epi32(kSymbols - 1));
  const Vec high = _mm256_sub_epi32(logarithm<5>(values), _mm256_set1_epi32(32 * (kBias + 4)));
  const Vec value = _mm256_min_epi32(_mm256_max_epi32(low, high), _mm256_set1_epi32(kValueClasses - 1));
  return _mm256_add_epi32(_mm256_mullo_epi32(fine, _mm256_set1_epi32(kValueClasses)), value);
}

CAIRN_AVX2_INLINE Vec widened(const std::uint16_t* p) {
  return _mm256_cvtepu16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p)));
}

CAIRN_AVX2 void count_row(const Geometry& g, const RowWork& work, Histogram& histogram) {
  int i = 0;
  for (; i + 8 <= g.size; i += 8) {
    alignas(32) std::array<std::uint32_t, 8> places;
    store(places.data(), places8(widened(work.activities + i), widened(work.zigzagged + i)));
    for (const std::uint32_t place : places) ++histogram.counts[place];
  }
  for (; i < g.size; ++i) {
    ++histogram.counts[Histogram::place(fine_class(work.activities[i]), value_class(work.zigzagged[i]))];
  }
}

// --- Coders ---

// A token: context, symbol, raw bits of a value. Places that are not coded have kNoToken.
constexpr unsigned kTokenSymbolShift = kMaxRawBits;
constexpr unsigned kTokenContextShift = kTokenSymbolShift + 6;
constexpr std::uint16_t kNoToken = 0xffff;
static_assert(kSymbols == 1u << 6);

/// What coding a symbol of a context takes, two words each, indexed by token >> kTokenSymbolShift.
struct SymbolCodes {
  explicit SymbolCodes(const Model& model) {
    for (std::size_t c = 0; c < kContexts; ++c) {
      std::uint32_t start = 0;
      for (std::size_t s = 0; s < kSymbols; ++s) {
        const std::uint32_t f = model.contexts[c].frequency[s];
        if (f == 0) continue;
        const auto shift = static_cast<unsigned>(std::bit_width(f - 1));
        inverse[c * kSymbols + s] =
            static_cast<std::uint32_t>(((std::uint64_t{1} << (kStateBits + shift)) + f - 1) / f);
        rest[c * kSymbols + s] = f | start << 10 | shift << 20 | model.contexts[c].raw_bits << 24;
        start += f;
      }
    }
  }
  /// ceil(2^(31 + shift) / frequency), where 2^shift is the first power of two that is not below the
  /// frequency: with it a division of 31 bits is exact.
  alignas(64) std::array<std::uint32_t, kContexts * kSymbols> inverse{};
  /// Frequency, start, shift, raw bits from bits 0, 10, 20, 24 on.
  alignas(64) std::array<std::uint32_t, kContexts * kSymbols> rest{};
};

/// For every 8-bit mask of 16-bit lanes: the byte shuffle that moves these lanes to the top.
struct Gathering {
  Gathering() {
    std::memset(shuffles, 0x80, sizeof shuffles);
    for (unsigned mask = 0; mask < 256; ++mask) {
      unsigned to = 8;
      for (unsigned lane = 8; lane-- > 0;) {
        if ((mask >> lane & 1) == 0) continue;
        --to;
        shuffles[mask][2 * to] = static_cast<std::uint8_t>(2 * lane);
        shuffles[mask][2 * to + 1] = static_cast<std::uint8_t>(2 * lane + 1);
      }
    }
  }
  alignas(64) std::uint8_t shuffles[256][16];
};

const Gathering& gathering() {
  static const Gathering table;
  return table;
}

struct Codes {
  Vec inverse;
  Vec rest;
};
CAIRN_AVX2_INLINE Codes look_up(const SymbolCodes& codes, Vec tokens) {
  const Vec index = _mm256_and_si256(_mm256_srli_epi32(tokens, kTokenSymbolShift), _mm256_set1_epi32(511));
  return {_mm256_i32gather_epi32(reinterpret_cast<const int*>(codes.inverse.data()), index, 4),
          _mm256_i32gather_epi32(reinterpret_cast<const int*>(codes.rest.data()), index, 4)};
}

/// Codes a symbol in each of eight lanes; `coded` tells in which, unless kAll.
template <bool kAll>
CAIRN_AVX2_INLINE Vec put(const Codes& code, const std::uint8_t (*shuffles)[16], Vec state, Vec token,
                          Vec coded, std::uint16_t*& next) {
  const Vec inverse = code.inverse;
  const Vec rest = code.rest;
  const Vec frequency = _mm256_and_si256(rest, _mm256_set1_epi32(0x3ff));
  const Vec start = _mm256_and_si256(_mm256_srli_epi32(rest, 10), _mm256_set1_epi32(0x3ff));
  const Vec shift = _mm256_and_si256(_mm256_srli_epi32(rest, 20), _mm256_set1_epi32(0xf));
  const Vec raw_bits = _mm256_srli_epi32(rest, 24);

  const Vec limit = _mm256_sllv_epi32(
      frequency, _mm256_sub_epi32(_mm256_set1_epi32(kStateBits - kFrequencyBits), raw_bits));
  Vec full = _mm256_andnot_si256(_mm256_cmpgt_epi32(limit, state), _mm256_set1_epi32(-1));
  if constexpr (!kAll) full = _mm256_and_si256(full, coded);
  const auto mask = static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(full)));
  const Vec low = _mm256_and_si256(state, _mm256_set1_epi32(0xffff));
  const __m128i words = _mm_packus_epi32(_mm256_castsi256_si128(low), _mm256_extracti128_si256(low, 1));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(next - 8),
                   _mm_shuffle_epi8(words, _mm_load_si128(reinterpret_cast<const __m128i*>(shuffles[mask]))));
  next -= std::popcount(mask);
  const Vec kept = _mm256_srlv_epi32(state, _mm256_and_si256(full, _mm256_set1_epi32(16)));

  const Vec long_shift = _mm256_add_epi32(shift, _mm256_set1_epi32(kStateBits));
  const Vec even = _mm256_srlv_epi64(_mm256_mul_epu32(kept, inverse),
                                     _mm256_and_si256(long_shift, _mm256_set1_epi64x(0xff)));
  const Vec odd =
      _mm256_srlv_epi64(_mm256_mul_epu32(_mm256_srli_epi64(kept, 32), _mm256_srli_epi64(inverse, 32)),
                        _mm256_srli_epi64(long_shift, 32));
  const Vec quotient = _mm256_blend_epi32(even, _mm256_slli_epi64(odd, 32), 0xAA);
  const Vec gap = _mm256_sub_epi32(_mm256_set1_epi32(kFrequencyTotal), frequency);
  const Vec coded_state = _mm256_add_epi32(_mm256_add_epi32(kept, start), _mm256_mullo_epi32(quotient, gap));
  const Vec raw = _mm256_and_si256(token, _mm256_set1_epi32((1 << kMaxRawBits) - 1));
  const Vec result = _mm256_or_si256(_mm256_sllv_epi32(coded_state, raw_bits), raw);
  return kAll ? result : _mm256_blendv_epi8(state, result, coded);
}

/// The values of eight contexts of 16 bits each, by 16-bit lanes of context.
CAIRN_AVX2_INLINE Vec look_up(Vec table, Vec contexts) {
  const Vec places =
      _mm256_add_epi16(_mm256_mullo_epi16(contexts, _mm256_set1_epi16(0x0202)), _mm256_set1_epi16(0x0100));
  return _mm256_shuffle_epi8(table, places);
}

class Avx2Encoder {
 public:
  Avx2Encoder(const Geometry& g, const Model& model, const Residuals& residuals)
      : g_(g),
        model_(model),
        residuals_(residuals),
        codes_(model),
        lane_stride_(static_cast<std::size_t>(g.steps + kLag + 2 * kBlock)),
        tokens_(std::make_unique_for_overwrite<std::uint16_t[]>(lane_stride_ * kLanes)) {}

  CAIRN_AVX2 Streams run();

 private:
  static constexpr int kBlock = 8;

  CAIRN_AVX2 void make_tokens();
  CAIRN_AVX2 void make_row(int row);
  void note_escapes(int row, int column, int count);
  CAIRN_AVX2 void load_block(int first_step);
  CAIRN_AVX2 void step_back(int step);
  template <bool kAll>
  CAIRN_AVX2 void put_all(const Vec* groups);
  std::uint16_t* lane_start(int lane) {
    return tokens_.get() + static_cast<std::size_t>(lane) * lane_stride_ + kLag;
  }

  const Geometry& g_;
  const Model& model_;
  const Residuals& residuals_;
  SymbolCodes codes_;
  std::size_t lane_stride_;
  std::unique_ptr<std::uint16_t[]> tokens_;  ///< each lane's rows one behind the other
  std::vector<Escape> escapes_;
  Vec limits_[kContexts - 1];
  Vec multipliers_, unshifted_, raw_masks_;  // by context: 2^(16 - raw bits) or 0; all ones where no raw bits
  Vec block_[kBlock][kGroups];
  Vec states_[2 * kGroups];
  const std::uint8_t (*shuffles_)[16] = gathering().shuffles;
  std::uint16_t* next_ = nullptr;
};

CAIRN_AVX2 void Avx2Encoder::make_tokens() {
  for (std::size_t i = 0; i < kContexts - 1; ++i) {
    limits_[i] = _mm256_set1_epi16(static_cast<std::int16_t>(model_.limits[i] - 1));
  }
  alignas(16) std::array<std::uint16_t, kContexts> multipliers, unshifted, masks;
  for (std::size_t i = 0; i < kContexts; ++i) {
    const unsigned raw_bits = model_.contexts[i].raw_bits;
    multipliers[i] = static_cast<std::uint16_t>(1u << (16 - raw_bits));
    unshifted[i] = raw_bits == 0 ? 0xffff : 0;
    masks[i] = static_cast<std::uint16_t>((1u << raw_bits) - 1);
  }
  const auto both = [](const auto& a) __attribute__((target("avx2,bmi,bmi2,lzcnt,popcnt"))) {
    return _mm256_broadcastsi128_si256(_mm_load_si128(reinterpret_cast<const __m128i*>(a.data())));
  };
  multipliers_ = both(multipliers);
  unshifted_ = both(unshifted);
  raw_masks_ = both(masks);
  for (int lane = 0; lane < kLanes; ++lane) {
    std::fill(lane_start(lane) - kLag, lane_start(lane), kNoToken);
    std::fill(lane_start(lane) + g_.bands * g_.width, lane_start(lane) + g_.steps + 2 * kBlock, kNoToken);
  }
  for (int row = 1; row <= g_.bands * kLanes; ++row) make_row(row);
}

void Avx2Encoder::note_escapes(int row, int column, int count) {
  const std::size_t start = g_.row_start(row) + static_cast<std::size_t>(kLeft + column);
  const std::uint16_t* token =
      lane_start((row - 1) % kLanes) + (row - 1) / kLanes * g_.width + kLeft + column;
  for (int i = 0; i < count; ++i) {
    if ((token[i] >> kTokenSymbolShift) % kSymbols != kEscape) continue;
    escapes_.push_back(
        escape_at(g_, row, column + i, residuals_.zigzagged[start + static_cast<std::size_t>(i)]));
  }
}

CAIRN_AVX2 void Avx2Encoder::make_row(int row) {
  std::uint16_t* to = lane_start((row - 1) % kLanes) + (row - 1) / kLanes * g_.width;
  if (row >= g_.size) {
    std::fill(to, to + g_.width, kNoToken);
    return;
  }
  const std::uint16_t* values = residuals_.zigzagged.get() + g_.row_start(row) + kLeft;
  const std::uint16_t* activities = residuals_.activities.get() + g_.row_start(row) + kLeft;
  std::fill(to, to + kLeft, kNoToken);
  // The last sixteen may lie over the virtual columns, which are filled after them.
  const int ends = g_.size - g_.size % kGroup;
  for (int i = 0; i < g_.size; i += kGroup) {
    alignas(32) std::uint16_t last[2][kGroup] = {};
    Vec value, activity;
    if (i < ends) {
      value = load(values + i);
      activity = load(activities + i);
    } else {
      std::copy(values + i, values + g_.size, last[0]);
      std::copy(activities + i, activities + g_.size, last[1]);
      value = load(last[0]);
      activity = load(last[1]);
    }
    Vec context = _mm256_setzero_si256();
    for (const Vec& limit : limits_) context = _mm256_sub_epi16(context, _mm256_cmpgt_epi16(activity, limit));
    const Vec shifted = _mm256_mulhi_epu16(value, look_up(multipliers_, context));
    const Vec whole = _mm256_and_si256(value, look_up(unshifted_, context));
    const Vec symbol = _mm256_min_epu16(_mm256_or_si256(shifted, whole), _mm256_set1_epi16(kEscape));
    const Vec raw = _mm256_and_si256(value, look_up(raw_masks_, context));
    const Vec token = _mm256_or_si256(_mm256_or_si256(raw, _mm256_slli_epi16(symbol, kTokenSymbolShift)),
                                      _mm256_slli_epi16(context, kTokenContextShift));
    if (i < ends) {
      store(to + kLeft + i, token);
    } else {
      store(last[0], token);
      std::copy(last[0], last[0] + (g_.size - i), to + kLeft + i);
    }
    if (_mm256_movemask_epi8(_mm256_cmpeq_epi16(symbol, _mm256_set1_epi16(kEscape))) != 0) {
      note_escapes(row, i, std::min(kGroup, g_.size - i));
    }
  }
  std::fill(to + kLeft + g_.size, to + g_.width, kNoToken);
}

/// The tokens of eight steps from this one on.
CAIRN_AVX2 void Avx2Encoder::load_block(int first_step) {
  for (int half = 0; half < kLanes / 8; ++half) {
    __m128i rows[8], steps[8];
    for (int i = 0; i < 8; ++i) {
      const int lane = 8 * half + i;
      rows[i] =
          _mm_loadu_si128(reinterpret_cast<const __m128i*>(lane_start(lane) + first_step - kSkew * lane));
    }
    transpose8(rows, steps);
    for (int i = 0; i < kBlock; ++i) {
      _mm_store_si128(reinterpret_cast<__m128i*>(&block_[i][half / 2]) + half % 2, steps[i]);
    }
  }
}

CAIRN_AVX2 void Avx2Encoder::step_back(int step) {
  const Vec* const groups = block_[step % kBlock];
  Vec missing = _mm256_setzero_si256();
  for (int g = 0; g < kGroups; ++g) {
    missing = _mm256_or_si256(missing, _mm256_cmpeq_epi16(groups[g], _mm256_set1_epi16(-1)));
  }
  if (_mm256_testz_si256(missing, missing)) {
    put_all<true>(groups);
  } else {
    put_all<false>(groups);
  }
}

template <bool kAll>
CAIRN_AVX2 void Avx2Encoder::put_all(const Vec* groups) {
  constexpr std::size_t kVectors = 2 * kGroups;
  Vec tokens[kVectors], coded[kVectors];
  Codes codes[kVectors];
#pragma GCC unroll 2
  for (std::size_t g = 0; g < kGroups; ++g) {
    tokens[2 * g] = _mm256_and_si256(groups[g], _mm256_set1_epi32(0xffff));
    tokens[2 * g + 1] = _mm256_srli_epi32(groups[g], 16);
  }
#pragma GCC unroll 4
  for (std::size_t v = 0; v < kVectors; ++v) {
    codes[v] = look_up(codes_, tokens[v]);
    coded[v] = _mm256_cmpgt_epi32(_mm256_set1_epi32(kNoToken), tokens[v]);
  }
  const std::uint8_t(*shuffles)[16] = shuffles_;
  std::uint16_t* next = next_;
#pragma GCC unroll 4
  for (std::size_t i = 0; i < kVectors; ++i) {
    const std::size_t v = kVectors - 1 - i;
    states_[v] = put<kAll>(codes[v], shuffles, states_[v], tokens[v], coded[v], next);
  }
  next_ = next;
}

CAIRN_AVX2 Streams Avx2Encoder::run() {
  make_tokens();
  const std::size_t most = static_cast<std::size_t>(g_.size) * static_cast<std::size_t>(g_.size);
  // Storing eight words at a time may touch seven before the first.
  const auto words = std::make_unique_for_overwrite<std::uint16_t[]>(most + 8);
  std::uint16_t* const end = words.get() + most + 8;
  next_ = end;
  for (Vec& states : states_) states = _mm256_set1_epi32(kStateFloor);
  for (int step = g_.steps - 1; step >= 0; --step) {
    if (step % kBlock == kBlock - 1 || step == g_.steps - 1) load_block(step - step % kBlock);
    step_back(step);
  }
  Streams streams;
  streams.words.assign(next_, end);
  alignas(32) std::array<std::uint32_t, kLanes> states;
  std::memcpy(states.data(), states_, sizeof states);
  for (int i = 0; i < kLanes; ++i) {
    streams.states[static_cast<std::size_t>(lane_at(i))] = states[static_cast<std::size_t>(i)];
  }
  streams.escapes = in_order(escapes_);
  return streams;
}

}  // namespace

CAIRN_AVX2 Residuals find_residuals_avx2(const Geometry& g, const Plane& plane, const Weights& weights,
                                         Histogram& histogram) {
  Vec pairs[kTaps / 2];
  for (std::size_t i = 0; i < kTaps / 2; ++i) {
    const auto low = static_cast<std::uint16_t>(weights[2 * i]);
    const auto high = static_cast<std::uint16_t>(weights[2 * i + 1]);
    pairs[i] = _mm256_set1_epi32(static_cast<int>(low | static_cast<std::uint32_t>(high) << 16));
  }
  const auto offsets = tap_offsets(g);
  Residuals result(g);
  // Three rows of magnitudes, of which the lowest is dropped each time.
  const auto width = static_cast<std::size_t>(g.width);
  std::vector<std::uint16_t> magnitudes(3 * width);
  for (int row = 1; row < g.size; ++row) {
    const std::size_t start = g.row_start(row) + kLeft;
    const RowWork work{plane.data() + start, result.zigzagged.get() + start, result.activities.get() + start,
                       magnitudes.data() + 2 * width + kLeft};
    find_row(g, weights, pairs, offsets, work);
    find_activities(g, work, g.width);
    count_row(g, work, histogram);
    std::memmove(magnitudes.data(), magnitudes.data() + width, 2 * width * sizeof(std::uint16_t));
  }
  return result;
}

Streams encode_samples_avx2(const Geometry& g, const Model& model, const Residuals& residuals) {
  return std::make_unique<Avx2Encoder>(g, model, residuals)->run();
}

}  // namespace cairn::wavefront

#endif
