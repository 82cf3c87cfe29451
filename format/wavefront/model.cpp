#include "format/wavefront/model.h"

#include <algorithm>
#include <numeric>

namespace cairn::wavefront {
namespace {

/// Neighbouring frequencies are alike: the last one tells how many bits the next one has.
unsigned rice_bits(unsigned last) {
  return last < 4 ? 0 : static_cast<unsigned>(std::bit_width(last)) - 2;
}

void write_context(const Context& context, BitWriter& out) {
  out.write(context.raw_bits, 3);
  unsigned left = kFrequencyTotal;
  unsigned last = kFrequencyTotal / 8;
  for (unsigned s = 0; s < kSymbols && left > 0; ++s) {
    out.write_rice(context.frequency[s], rice_bits(last));
    last = context.frequency[s];
    left -= last;
  }
}

bool read_context(BitReader& in, Context& context) {
  context = {};
  context.raw_bits = in.read(3);
  if (context.raw_bits > kMaxRawBits) return false;
  unsigned left = kFrequencyTotal;
  unsigned last = kFrequencyTotal / 8;
  for (unsigned s = 0; s < kSymbols && left > 0; ++s) {
    last = in.read_rice(rice_bits(last));
    if (!in.ok() || last > left || last == kFrequencyTotal) return false;
    context.frequency[s] = static_cast<std::uint16_t>(last);
    left -= last;
  }
  return left == 0;
}

}  // namespace

void write_model(const Model& model, BitWriter& out) {
  for (const std::int16_t weight : model.weights) out.write(static_cast<std::uint16_t>(weight), 16);
  for (const std::uint16_t limit : model.limits) out.write(limit, 15);
  for (const Context& context : model.contexts) {
    const bool used = context.frequency != decltype(context.frequency){};
    out.write(used, 1);
    if (used) write_context(context, out);
  }
}

bool read_model(BitReader& in, Model& model) {
  for (std::int16_t& weight : model.weights) {
    weight = static_cast<std::int16_t>(static_cast<std::uint16_t>(in.read(16)));
  }
  for (std::uint16_t& limit : model.limits) limit = static_cast<std::uint16_t>(in.read(15));
  if (!std::is_sorted(model.limits.begin(), model.limits.end())) return false;
  for (Context& context : model.contexts) {
    context = {};
    if (in.read(1) != 0 && !read_context(in, context)) return false;
  }
  return in.ok();
}

std::array<std::uint16_t, kSymbols> normalise(std::span<const std::uint32_t, kSymbols> counts) {
  const std::uint64_t total = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
  std::array<std::uint16_t, kSymbols> frequency{};
  std::uint32_t given = 0;
  for (unsigned s = 0; s < kSymbols; ++s) {
    if (counts[s] == 0) continue;
    const std::uint64_t share = (std::uint64_t{counts[s]} * kFrequencyTotal + total / 2) / total;
    frequency[s] = static_cast<std::uint16_t>(std::max<std::uint64_t>(share, 1));
    given += frequency[s];
  }
  // What rounding gave too much or too little comes from the largest, where it costs least.
  while (given != kFrequencyTotal) {
    auto& most = *std::max_element(frequency.begin(), frequency.end());
    const std::uint32_t step = given > kFrequencyTotal
                                   ? std::min<std::uint32_t>(given - kFrequencyTotal, most / 4u + 1u)
                                   : kFrequencyTotal - given;
    if (given > kFrequencyTotal) {
      most = static_cast<std::uint16_t>(most - step);
      given -= step;
    } else {
      most = static_cast<std::uint16_t>(most + step);
      given += step;
    }
  }
  for (std::uint16_t& f : frequency) {
    if (f < kFrequencyTotal) continue;
    --f;
    frequency[&f == &frequency[0] ? 1 : 0] = 1;
  }
  return frequency;
}

}  // namespace cairn::wavefront
