#pragma once

#include <bit>
#include <cstdint>
#include <map>
#include <vector>

namespace cairn {

/// Hands out ranges of a buffer that grows at its end. Sizes are rounded up to an eighth, so that what one
/// released another can take.
class RangeArena {
 public:
  std::uint32_t take(std::uint32_t count) {
    const std::uint32_t size = rounded(count);
    auto& free = free_[size];
    if (!free.empty()) {
      const std::uint32_t first = free.back();
      free.pop_back();
      return first;
    }
    const std::uint32_t first = end_;
    end_ += size;
    return first;
  }
  void release(std::uint32_t first, std::uint32_t count) { free_[rounded(count)].push_back(first); }
  std::uint32_t end() const { return end_; }

 private:
  static std::uint32_t rounded(std::uint32_t count) {
    const std::uint32_t eighth = std::bit_ceil(count + 16) / 16;
    return (count + eighth - 1) / eighth * eighth;
  }

  std::map<std::uint32_t, std::vector<std::uint32_t>> free_;
  std::uint32_t end_ = 0;
};

}  // namespace cairn
