#pragma once

#include <algorithm>
#include <memory>
#include <span>
#include <unordered_map>

#include "cairn/render_list.h"

namespace cairn {

/// How far the objects of some tiles reach from the ground of an area: ground that is outside the picture may
/// bear what is inside.
class ObjectReach {
 public:
  explicit ObjectReach(std::span<const std::shared_ptr<const LoadedObjects>> tiles) {
    for (const std::shared_ptr<const LoadedObjects>& tile : tiles) {
      const double largest_m = kReachPerSize * static_cast<double>(tile->largest_m());
      for (TileId id = tile->tile();; id = parent_of(id)) {
        const auto [at, fresh] = beneath_.try_emplace(id, largest_m);
        if (!fresh && at->second >= largest_m) break;  // as it is above, then
        at->second = largest_m;
        if (id.level == kMinLevel) break;
      }
      double& own = own_[tile->tile()];
      own = std::max(own, largest_m);
      coarsest_ = std::min(coarsest_, tile->tile().level);
    }
  }

  /// Returns metres; 0 where no tile has objects in the area.
  double of(TileId area) const {
    const auto finer = beneath_.find(area);
    double reach = finer == beneath_.end() ? 0 : finer->second;
    for (; area.level >= coarsest_; area = parent_of(area)) {
      if (const auto found = own_.find(area); found != own_.end()) reach = std::max(reach, found->second);
      if (area.level == kMinLevel) break;
    }
    return reach;
  }

 private:
  std::unordered_map<TileId, double> beneath_;  // of an area and all below it
  std::unordered_map<TileId, double> own_;
  int coarsest_ = kMaxLevel + 1;
};

}  // namespace cairn
