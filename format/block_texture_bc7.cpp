#include <array>
#include <cstdint>
#include <utility>

#include "format/block_texture.h"
#include "format/bptc.h"
#include "format/bytes.h"

namespace cairn {

namespace {

// The 128 bits of a block, taken from the lowest up.
class BitReader {
 public:
  explicit BitReader(std::span<const std::byte, 16> block) {
    ByteReader reader(block);
    low_ = reader.read<std::uint64_t>();
    high_ = reader.read<std::uint64_t>();
  }
  unsigned take(unsigned count) {
    const auto value = static_cast<unsigned>(low_ & ((1U << count) - 1));
    if (count > 0) {
      low_ = low_ >> count | high_ << (64 - count);
      high_ >>= count;
    }
    return value;
  }

 private:
  std::uint64_t low_, high_;
};

// [subset][which end][channel]
using Ends = std::array<std::array<std::array<unsigned, 4>, 2>, 3>;
using Indices = std::array<unsigned, 16>;

Ends read_ends(BitReader& bits, const bptc::Mode& mode) {
  Ends ends{};
  for (std::size_t channel = 0; channel < 4; ++channel) {
    const unsigned width = channel < 3 ? mode.colour_bits : mode.alpha_bits;
    for (unsigned subset = 0; subset < mode.subsets; ++subset) {
      for (auto& end : ends[subset]) end[channel] = bits.take(width);
    }
  }
  return ends;
}

void append_p_bits(BitReader& bits, const bptc::Mode& mode, Ends& ends) {
  for (unsigned subset = 0; subset < mode.subsets; ++subset) {
    unsigned p = mode.subset_p_bits ? bits.take(1) : 0;
    for (auto& end : ends[subset]) {
      if (mode.end_p_bits) p = bits.take(1);
      for (unsigned& value : end) value = value << 1 | p;
    }
  }
}

// Widens every value to 8 bits by repeating its top bits.
void widen(const bptc::Mode& mode, Ends& ends) {
  const unsigned p_bits = mode.end_p_bits | mode.subset_p_bits;
  for (auto& subset : ends) {
    for (auto& end : subset) {
      for (std::size_t channel = 0; channel < 4; ++channel) {
        const unsigned stored = channel < 3 ? mode.colour_bits : mode.alpha_bits;
        if (stored == 0) {
          end[channel] = 255;
          continue;
        }
        const unsigned width = stored + p_bits;
        end[channel] = end[channel] << (8 - width) | end[channel] >> (2 * width - 8);
      }
    }
  }
}

Indices read_indices(BitReader& bits, unsigned width, unsigned subsets, unsigned partition) {
  Indices indices{};
  for (unsigned texel = 0; texel < 16; ++texel) {
    const unsigned subset = bptc::subset_of(subsets, partition, texel);
    const bool anchor = texel == bptc::anchor_of(subsets, partition, subset);
    indices[texel] = bits.take(anchor ? width - 1 : width);
  }
  return indices;
}

std::uint8_t blend(unsigned a, unsigned b, unsigned weight) {
  return static_cast<std::uint8_t>((a * (64 - weight) + b * weight + 32) >> 6);
}

}  // namespace

BlockTexels decode_bc7_block(std::span<const std::byte, 16> block) {
  BlockTexels texels{};
  BitReader bits(block);
  unsigned number = 0;
  while (number < 8 && bits.take(1) == 0) ++number;
  if (number == 8) return texels;

  const bptc::Mode& mode = bptc::kModes[number];
  const unsigned partition = bits.take(mode.partition_bits);
  const unsigned rotation = bits.take(mode.rotation_bits);
  const unsigned selector = bits.take(mode.selector_bits);
  Ends ends = read_ends(bits, mode);
  if (mode.end_p_bits | mode.subset_p_bits) append_p_bits(bits, mode, ends);
  widen(mode, ends);

  unsigned colour_bits = mode.index_bits, alpha_bits = mode.index_bits;
  Indices colour = read_indices(bits, colour_bits, mode.subsets, partition);
  Indices alpha = colour;
  if (mode.second_index_bits) {
    alpha_bits = mode.second_index_bits;
    alpha = read_indices(bits, alpha_bits, 1, 0);
  }
  if (selector) {
    std::swap(colour, alpha);
    std::swap(colour_bits, alpha_bits);
  }
  for (unsigned texel = 0; texel < 16; ++texel) {
    const auto& [a, b] = ends[bptc::subset_of(mode.subsets, partition, texel)];
    std::uint8_t* out = &texels[4 * texel];
    const unsigned weight = bptc::kWeights[colour_bits][colour[texel]];
    for (std::size_t channel = 0; channel < 3; ++channel)
      out[channel] = blend(a[channel], b[channel], weight);
    out[3] = blend(a[3], b[3], bptc::kWeights[alpha_bits][alpha[texel]]);
    if (rotation > 0) std::swap(out[3], out[rotation - 1]);
  }
  return texels;
}

}  // namespace cairn
