#include "builder/texture_encode/bc7_pack.h"

namespace cairn::CAIRN_ISA {

namespace {

// One lane's block, in whole numbers.
struct Block {
  unsigned mode, partition, rotation;
  unsigned stored[3][2][4];
  unsigned p[3][2];
  unsigned index[16], second_index[16];
};

unsigned take(I from, int lane) {
  return static_cast<unsigned>(from[lane]);
}

Block block_of(const Bc7Candidate& from, int lane) {
  Block block;
  block.mode = take(from.mode, lane);
  block.partition = take(from.partition, lane);
  block.rotation = take(from.rotation, lane);
  for (unsigned s = 0; s < bptc::kModes[block.mode].subsets; ++s) {
    for (int e = 0; e < 2; ++e) {
      for (int c = 0; c < 4; ++c) block.stored[s][e][c] = take(from.stored[s][e][c], lane);
      block.p[s][e] = take(from.p[s][e], lane);
    }
  }
  for (int i = 0; i < 16; ++i) {
    block.index[i] = take(from.index[i], lane);
    block.second_index[i] = take(from.second_index[i], lane);
  }
  return block;
}

unsigned subset_of(const bptc::Mode& mode, unsigned partition, unsigned texel) {
  if (mode.subsets == 2) return bptc::kPartitions2[partition] >> texel & 1U;
  if (mode.subsets == 3) return bptc::kPartitions3[partition] >> (2 * texel) & 3U;
  return 0;
}

unsigned anchor_of(const bptc::Mode& mode, unsigned partition, unsigned subset) {
  if (subset == 0) return 0;
  if (mode.subsets == 2) return bptc::kAnchors2[partition];
  return subset == 1 ? bptc::kAnchors3Second[partition] : bptc::kAnchors3Third[partition];
}

void swap(unsigned& a, unsigned& b) {
  const unsigned was = a;
  a = b;
  b = was;
}

// The top bit of each anchor's index is not stored: it must be 0, so ends are swapped where it is 1.
void clear_anchors(const bptc::Mode& mode, Block& block) {
  const unsigned last = (1U << mode.index_bits) - 1;
  for (unsigned s = 0; s < mode.subsets; ++s) {
    if (block.index[anchor_of(mode, block.partition, s)] <= last / 2) continue;
    const int channels = mode.second_index_bits ? 3 : 4;
    for (int c = 0; c < channels; ++c) swap(block.stored[s][0][c], block.stored[s][1][c]);
    swap(block.p[s][0], block.p[s][1]);
    for (unsigned i = 0; i < 16; ++i) {
      if (subset_of(mode, block.partition, i) == s) block.index[i] = last - block.index[i];
    }
  }
  const unsigned second_last = (1U << mode.second_index_bits) - 1;
  if (mode.second_index_bits && block.second_index[0] > second_last / 2) {
    swap(block.stored[0][0][3], block.stored[0][1][3]);
    for (unsigned& index : block.second_index) index = second_last - index;
  }
}

void put_ends(const bptc::Mode& mode, const Block& block, BlockBits& bits) {
  for (int c = 0; c < 4; ++c) {
    const unsigned width = c < 3 ? mode.colour_bits : mode.alpha_bits;
    if (width == 0) continue;
    for (unsigned s = 0; s < mode.subsets; ++s) {
      for (int e = 0; e < 2; ++e) bits.put(block.stored[s][e][c], width);
    }
  }
  for (unsigned s = 0; s < mode.subsets; ++s) {
    if (mode.end_p_bits | mode.subset_p_bits) bits.put(block.p[s][0], 1);
    if (mode.end_p_bits) bits.put(block.p[s][1], 1);
  }
}

void put_indices(const bptc::Mode& mode, const Block& block, BlockBits& bits) {
  for (unsigned i = 0; i < 16; ++i) {
    const unsigned subset = subset_of(mode, block.partition, i);
    const bool anchor = i == anchor_of(mode, block.partition, subset);
    bits.put(block.index[i], anchor ? mode.index_bits - 1U : mode.index_bits);
  }
  for (unsigned i = 0; mode.second_index_bits && i < 16; ++i) {
    bits.put(block.second_index[i], i == 0 ? mode.second_index_bits - 1U : mode.second_index_bits);
  }
}

}  // namespace

void pack_bc7(const Bc7Candidate& best, int lane, std::byte* out) {
  Block block = block_of(best, lane);
  const bptc::Mode& mode = bptc::kModes[block.mode];
  clear_anchors(mode, block);
  BlockBits bits;
  bits.put(1U << block.mode, block.mode + 1);
  bits.put(block.partition, mode.partition_bits);
  bits.put(block.rotation, mode.rotation_bits);
  bits.put(0, mode.selector_bits);
  put_ends(mode, block, bits);
  put_indices(mode, block, bits);
  bits.write(out);
}

}  // namespace cairn::CAIRN_ISA
