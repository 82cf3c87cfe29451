#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <span>
#include <vector>

#include <catch2/catch.hpp>

#include "format/wavefront/bit_stream.h"
#include "format/wavefront/decode_avx2.h"
#include "format/wavefront/encode_avx2.h"
#include "format/wavefront/fit.h"

namespace {

using namespace cairn::wavefront;

using Samples = std::vector<std::int32_t>;

std::size_t area(int size) {
  return static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
}

/// Hills with noise, of which some is too large for any symbol.
Samples rough(int size, std::int32_t noise) {
  std::mt19937 random(static_cast<unsigned>(size + noise));
  Samples samples;
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const double hill = 3000 * std::sin(x * 0.021) * std::cos(y * 0.017) + 4 * x;
      const auto shake = static_cast<std::int32_t>(random() % static_cast<unsigned>(2 * noise + 1)) - noise;
      samples.push_back(static_cast<std::int32_t>(hill) + (random() % 50 == 0 ? 7 * shake : shake / 3));
    }
  }
  return samples;
}

/// All that lies between the samples and the coders.
struct Case {
  Case(int size, std::int32_t noise)
      : g(size), samples(rough(size, noise)), plane(make_plane(g, samples, 100)) {
    model.weights = fit_weights(g, plane);
  }
  Geometry g;
  Samples samples;
  Plane plane;
  Model model;
};

bool same_residuals(const Geometry& g, const Residuals& a, const Residuals& b) {
  for (int row = 1; row < g.size; ++row) {
    const std::size_t start = g.row_start(row) + kLeft;
    for (std::size_t i = start; i < start + static_cast<std::size_t>(g.size); ++i) {
      if (a.zigzagged[i] != b.zigzagged[i] || a.activities[i] != b.activities[i]) return false;
    }
  }
  return true;
}

CodedSamples coded(const Streams& streams, std::vector<std::byte>& words) {
  words.resize(2 * streams.words.size() + kReadableAfterWords);
  const auto bytes = std::as_bytes(std::span(streams.words));
  std::copy(bytes.begin(), bytes.end(), words.begin());
  return {streams.states, words.data(), streams.words.size(),
          reinterpret_cast<const std::byte*>(streams.escapes.data()), streams.escapes.size()};
}

}  // namespace

TEST_CASE("The wide encoder and decoder give what the portable ones give") {
#if defined(__x86_64__)
  if (!cpu_has_avx2()) {
    WARN("SKIPPED: this CPU has no AVX2");
    return;
  }
  for (const int size : {2, 3, 16, 17, 33, 34, 64, 65, 93, 94, 97, 128, 129, 257, 300, 513}) {
    for (const std::int32_t noise : {0, 3, 40, 900}) {
      INFO("size " << size << ", noise " << noise);
      Case c(size, noise);
      REQUIRE(c.model.weights == fit_weights_portable(c.g, c.plane));
      Histogram portable_histogram, wide_histogram;
      const Residuals residuals = find_residuals_portable(c.g, c.plane, c.model.weights, portable_histogram);
      const Residuals wide = find_residuals_avx2(c.g, c.plane, c.model.weights, wide_histogram);
      REQUIRE(same_residuals(c.g, residuals, wide));
      REQUIRE(portable_histogram.counts == wide_histogram.counts);

      choose_contexts(wide_histogram, c.model);
      const Streams streams = encode_samples_portable(c.g, c.model, residuals);
      const Streams wide_streams = encode_samples_avx2(c.g, c.model, wide);
      REQUIRE(streams.states == wide_streams.states);
      REQUIRE(streams.words == wide_streams.words);
      REQUIRE(streams.escapes == wide_streams.escapes);

      std::vector<std::byte> words;
      const CodedSamples code = coded(streams, words);
      Samples decoded(area(size)), wide_decoded(area(size));
      std::copy_n(c.samples.begin(), size, decoded.begin());
      std::copy_n(c.samples.begin(), size, wide_decoded.begin());
      REQUIRE(decode_samples_portable(c.g, c.model, code, 100, decoded));
      REQUIRE(decode_samples_avx2(c.g, c.model, code, 100, wide_decoded));
      CHECK(decoded == c.samples);
      CHECK(wide_decoded == c.samples);
    }
  }
#else
  WARN("SKIPPED: no wide code for this CPU");
#endif
}

TEST_CASE("Frequencies add up, keep every value that occurs, and are in proportion") {
  std::mt19937 random(5);
  for (int trial = 0; trial < 2000; ++trial) {
    std::array<std::uint32_t, kSymbols> counts{};
    const unsigned used = 1 + static_cast<unsigned>(random()) % kSymbols;
    for (unsigned i = 0; i < used; ++i) {
      counts[random() % kSymbols] += 1 + static_cast<unsigned>(random() % (trial % 3 == 0 ? 3 : 100000));
    }
    const auto frequency = normalise(counts);
    std::uint32_t sum = 0;
    for (unsigned s = 0; s < kSymbols; ++s) {
      REQUIRE((counts[s] == 0 || frequency[s] > 0));
      REQUIRE(frequency[s] < kFrequencyTotal);
      sum += frequency[s];
    }
    REQUIRE(sum == kFrequencyTotal);
  }
}

TEST_CASE("A model is read back as it was written, and no other is accepted") {
  Case c(129, 40);
  Histogram histogram;
  (void)find_residuals(c.g, c.plane, c.model.weights, histogram);
  choose_contexts(histogram, c.model);
  std::vector<std::byte> bytes;
  cairn::BitWriter out(bytes);
  write_model(c.model, out);
  out.finish();
  cairn::BitReader in(bytes);
  Model read;
  REQUIRE(read_model(in, read));
  CHECK(in.finished());
  CHECK(read.weights == c.model.weights);
  CHECK(read.limits == c.model.limits);
  for (std::size_t i = 0; i < kContexts; ++i) {
    CHECK(read.contexts[i].frequency == c.model.contexts[i].frequency);
    CHECK(read.contexts[i].raw_bits == c.model.contexts[i].raw_bits);
  }
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    cairn::BitReader cut({bytes.data(), length});
    CHECK_FALSE((read_model(cut, read) && cut.finished()));
  }
}

TEST_CASE("Rice codes give back every value, whatever their parameter") {
  for (unsigned low_bits = 0; low_bits < 16; ++low_bits) {
    std::vector<std::byte> bytes;
    cairn::BitWriter out(bytes);
    for (std::uint32_t v = 0; v < 70000; v += 1 + v / 7) out.write_rice(v, low_bits);
    out.finish();
    cairn::BitReader in(bytes);
    for (std::uint32_t v = 0; v < 70000; v += 1 + v / 7) REQUIRE(in.read_rice(low_bits) == v);
    CHECK(in.finished());
  }
}

TEST_CASE("Classes of activities and values rise, and none straddles a symbol") {
  for (unsigned a = 0; a < kActivityLimit; ++a) REQUIRE(fine_class(a) <= fine_class(a + 1));
  for (unsigned v = 0; v < 5000; ++v) {
    REQUIRE(value_class(v) <= value_class(v + 1));
    REQUIRE(value_class(v) < kValueClasses);
    // No class straddles a symbol of any number of raw bits.
    for (unsigned raw_bits = 0; raw_bits <= kMaxRawBits; ++raw_bits) {
      const unsigned symbol = std::min(v >> raw_bits, kEscape);
      const unsigned next = std::min((v + 1) >> raw_bits, kEscape);
      if (symbol != next) REQUIRE(value_class(v) != value_class(v + 1));
    }
  }
}
