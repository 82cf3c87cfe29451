#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

namespace cairn::gl {

/// Which thing lies in which slot of a GPU array. A thing keeps its slot until it is released, or until
/// another takes it: then the slot that was used longest ago goes first, and none that the current frame has
/// used.
template <class Key>
class SlotPool {
 public:
  void begin_frame() { ++frame_; }
  std::uint32_t capacity() const { return static_cast<std::uint32_t>(slots_.size()); }
  void grow(std::uint32_t capacity) { slots_.resize(capacity); }

  /// The slot of a thing that has one; it counts as used in this frame.
  std::optional<std::uint32_t> find(const Key& key) {
    const auto it = by_key_.find(key);
    if (it == by_key_.end()) return std::nullopt;
    slots_[it->second].used = frame_;
    return it->second;
  }

  /// Gives a thing a slot; nullopt where this frame uses all. REQUIRES: it has none.
  std::optional<std::uint32_t> take(const Key& key) {
    std::optional<std::uint32_t> oldest;
    for (std::uint32_t i = 0; i < slots_.size(); ++i) {
      if (slots_[i].used < frame_ && (!oldest || slots_[i].used < slots_[*oldest].used)) oldest = i;
    }
    if (oldest) put(key, *oldest);
    return oldest;
  }

  /// Gives a thing a slot that no other has; nullopt where there is none. REQUIRES: it has none.
  std::optional<std::uint32_t> take_free(const Key& key) {
    for (std::uint32_t i = 0; i < slots_.size(); ++i) {
      if (slots_[i].used > 0) continue;
      put(key, i);
      return i;
    }
    return std::nullopt;
  }

  void release(const Key& key) {
    const auto it = by_key_.find(key);
    if (it == by_key_.end()) return;
    slots_[it->second].used = 0;
    by_key_.erase(it);
  }

 private:
  void put(const Key& key, std::uint32_t index) {
    Slot& slot = slots_[index];
    if (slot.used > 0) by_key_.erase(slot.key);
    slot = {key, frame_};
    by_key_.emplace(key, index);
  }

  struct Slot {
    Key key{};
    std::uint64_t used = 0;  // the frame; 0: never
  };
  std::vector<Slot> slots_;
  std::unordered_map<Key, std::uint32_t> by_key_;
  std::uint64_t frame_ = 1;
};

}  // namespace cairn::gl
