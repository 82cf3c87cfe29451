#pragma once

#include <cstdint>
#include <iterator>
#include <map>
#include <set>
#include <utility>

namespace cairn {

/// Hands out ranges of a buffer that grows at its end: the smallest free range that is large enough. Ranges
/// that are released beside each other become one, so that the buffer stays as small as its content.
class RangeArena {
 public:
  std::uint32_t take(std::uint32_t count) {
    if (count == 0) return 0;
    const auto fit = by_size_.lower_bound({count, 0});
    if (fit == by_size_.end()) return std::exchange(end_, end_ + count);
    const auto [size, first] = *fit;
    remove(free_.find(first));
    if (size > count) add(first + count, size - count);
    return first;
  }

  void release(std::uint32_t first, std::uint32_t count) {
    if (count == 0) return;
    const auto next = free_.lower_bound(first);
    if (next != free_.begin()) {
      const auto before = std::prev(next);
      if (before->first + before->second == first) {
        first = before->first;
        count += before->second;
        remove(before);
      }
    }
    if (next != free_.end() && next->first == first + count) {
      count += next->second;
      remove(next);
    }
    if (first + count == end_) {
      end_ = first;
    } else {
      add(first, count);
    }
  }

  std::uint32_t end() const { return end_; }

 private:
  void add(std::uint32_t first, std::uint32_t size) {
    free_.emplace(first, size);
    by_size_.emplace(size, first);
  }
  void remove(std::map<std::uint32_t, std::uint32_t>::iterator range) {
    by_size_.erase({range->second, range->first});
    free_.erase(range);
  }

  std::map<std::uint32_t, std::uint32_t> free_;                // sizes by first
  std::set<std::pair<std::uint32_t, std::uint32_t>> by_size_;  // with their firsts
  std::uint32_t end_ = 0;
};

}  // namespace cairn
