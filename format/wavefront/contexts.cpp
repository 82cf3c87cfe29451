#include "format/wavefront/contexts.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <limits>
#include <vector>

namespace cairn::wavefront {
namespace {

/// The least activity of a class: the inverse.
unsigned class_start(unsigned fine) {
  return (((4 + fine % 4) << fine / 4) + 3) / 4 - 1;
}

/// The least value of a class.
unsigned value_start(unsigned value_class_index) {
  if (value_class_index < kSymbols) return value_class_index;
  const unsigned octave = value_class_index / (kSymbols / 2) - 1;
  return (value_class_index - kSymbols / 2 * octave) << octave;
}

using Counts = std::array<std::uint32_t, kValueClasses>;
using SymbolCounts = std::array<std::uint32_t, kSymbols>;

SymbolCounts symbol_counts(const Counts& counts, unsigned raw_bits) {
  SymbolCounts symbols{};
  for (unsigned c = 0; c < kValueClasses; ++c) {
    symbols[std::min(value_start(c) >> raw_bits, kEscape)] += counts[c];
  }
  return symbols;
}

/// 2^16 · log2(value), to about 2^-12 of a bit, in integers, so that every machine chooses alike.
std::uint64_t log2_fixed(std::uint32_t value) {
  const auto octave = static_cast<unsigned>(std::bit_width(value)) - 1;
  const std::uint64_t f = (std::uint64_t{value} << 16 >> octave) - 65536;
  // log2(1 + x) = x + x(1 - x)(0.3463 + 0.0797 (1 - 2x) …), least squares over 0…1.
  const std::uint64_t bend = (f * (65536 - f) >> 16) * (27900 - (f * 10400 >> 16)) >> 16;
  return (std::uint64_t{octave} << 16) + f + bend;
}

/// A run of fine classes that one context takes, and what its samples cost there.
struct Run {
  unsigned first_class = 0;
  Counts counts{};
  std::uint32_t total = 0;
  std::uint64_t value_sum = 0;
  unsigned raw_bits = 0;
  std::uint64_t cost = 0;  ///< in 2^-16 bits
};

std::uint64_t cost_with(const Run& run, unsigned raw_bits) {
  constexpr std::uint64_t kBitsPerSymbolInTable = 6;
  constexpr std::uint64_t kBitsPerEscape = 20;  // 16 and the time that it takes
  const SymbolCounts symbols = symbol_counts(run.counts, raw_bits);
  std::uint64_t cost = (std::uint64_t{run.total} * (raw_bits << 16)) + run.total * log2_fixed(run.total);
  for (const std::uint32_t count : symbols) {
    if (count != 0) cost += (kBitsPerSymbolInTable << 16) - count * log2_fixed(count);
  }
  return cost + symbols[kEscape] * (kBitsPerEscape << 16);
}

void settle(Run& run) {
  // Symbols of a quarter of the mean value lose little to their raw bits.
  const auto mean = static_cast<std::uint32_t>(run.value_sum / run.total);
  const auto guess = std::min(static_cast<unsigned>(std::bit_width(mean / 8)), kMaxRawBits);
  run.raw_bits = guess;
  run.cost = cost_with(run, guess);
}

Run merged(const Run& a, const Run& b) {
  Run run = a;
  for (unsigned c = 0; c < kValueClasses; ++c) run.counts[c] += b.counts[c];
  run.total += b.total;
  run.value_sum += b.value_sum;
  settle(run);
  return run;
}

std::vector<Run> runs_of(const Histogram& histogram) {
  std::vector<Run> runs;
  for (unsigned c = 0; c < kFineClasses; ++c) {
    Run run;
    run.first_class = c;
    std::copy_n(histogram.counts.begin() + Histogram::place(c, 0), kValueClasses, run.counts.begin());
    for (unsigned v = 0; v < kValueClasses; ++v) {
      run.total += run.counts[v];
      run.value_sum += std::uint64_t{run.counts[v]} * value_start(v);
    }
    if (run.total == 0) continue;
    settle(run);
    runs.push_back(run);
  }
  return runs;
}

/// Merges the neighbours whose union costs least more than the two, until `most` runs are left.
void merge_runs(std::vector<Run>& runs, std::size_t most) {
  std::vector<Run> unions;  // unions[i]: of runs i and i + 1
  for (std::size_t i = 0; i + 1 < runs.size(); ++i) unions.push_back(merged(runs[i], runs[i + 1]));
  const auto loss = [&](std::size_t i) {
    return static_cast<std::int64_t>(unions[i].cost - runs[i].cost - runs[i + 1].cost);
  };
  while (!unions.empty()) {
    std::size_t best = 0;
    for (std::size_t i = 1; i < unions.size(); ++i) {
      if (loss(i) < loss(best)) best = i;
    }
    if (runs.size() <= most && loss(best) > 0) return;
    runs[best] = unions[best];
    runs.erase(runs.begin() + static_cast<std::ptrdiff_t>(best) + 1);
    unions.erase(unions.begin() + static_cast<std::ptrdiff_t>(best));
    if (best < unions.size()) unions[best] = merged(runs[best], runs[best + 1]);
    if (best > 0) unions[best - 1] = merged(runs[best - 1], runs[best]);
  }
}

}  // namespace

void choose_contexts(const Histogram& histogram, Model& model) {
  std::vector<Run> runs = runs_of(histogram);
  merge_runs(runs, kContexts);
  model.limits.fill(kActivityLimit + 1);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (i > 0) model.limits[i - 1] = static_cast<std::uint16_t>(class_start(runs[i].first_class));
    model.contexts[i].raw_bits = runs[i].raw_bits;
    const SymbolCounts symbols = symbol_counts(runs[i].counts, runs[i].raw_bits);
    model.contexts[i].frequency = normalise(symbols);
  }
}

}  // namespace cairn::wavefront
