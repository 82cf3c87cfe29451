#pragma once

#include "builder/texture_encode/bc7_block.h"

namespace cairn::CAIRN_ISA {

/// The 128 bits of a block, filled from the lowest up.
class BlockBits {
 public:
  CAIRN_INLINE void put(std::uint32_t value, unsigned bits) {
    const auto wide = static_cast<std::uint64_t>(value);
    if (at_ < 64) half_[0] |= wide << at_;
    if (at_ >= 64) half_[1] |= wide << (at_ - 64);
    if (at_ < 64 && at_ + bits > 64) half_[1] |= wide >> (64 - at_);
    at_ += bits;
  }
  CAIRN_INLINE void write(std::byte* out) const { std::memcpy(out, half_, 16); }

 private:
  std::uint64_t half_[2] = {0, 0};
  unsigned at_ = 0;
};

/// Writes one lane's block.
void pack_bc7(const Bc7Candidate& best, int lane, std::byte* out);

}  // namespace cairn::CAIRN_ISA
