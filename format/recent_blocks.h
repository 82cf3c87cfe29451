#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <unordered_map>

namespace cairn {

/// Where the last 65,536 different blocks of a pack lie, by their checksum, so that an equal one need not be
/// written again. What it knows depends on the order of add() alone.
class RecentBlocks {
 public:
  struct Block {
    std::uint64_t checksum = 0;
    std::uint64_t offset = 0;
    std::uint32_t bytes = 0;
  };

  void add(const Block& block) {
    if (order_.size() == kMost) forget_oldest();
    order_.push_back(block);
    by_checksum_.emplace(block.checksum, block);
  }

  /// Calls `is_equal` with each block of this checksum until it returns true; whether it did.
  template <class IsEqual>
  bool find(std::uint64_t checksum, const IsEqual& is_equal) const {
    const auto [first, last] = by_checksum_.equal_range(checksum);
    for (auto it = first; it != last; ++it) {
      if (is_equal(it->second)) return true;
    }
    return false;
  }

 private:
  static constexpr std::size_t kMost = std::size_t{1} << 16;

  void forget_oldest() {
    const auto [first, last] = by_checksum_.equal_range(order_.front().checksum);
    for (auto it = first; it != last; ++it) {
      if (it->second.offset != order_.front().offset) continue;
      by_checksum_.erase(it);
      break;
    }
    order_.pop_front();
  }

  std::deque<Block> order_;
  std::unordered_multimap<std::uint64_t, Block> by_checksum_;
};

}  // namespace cairn
