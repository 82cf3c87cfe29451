#include "runtime/paging/object_selection.h"

#include <algorithm>
#include <limits>
#include <queue>

namespace cairn {
namespace {

constexpr double kBeyondTheView = 16;  // times the smallest size

struct Candidate {
  double px = 0;  // of its largest object
  TileId id;
  bool operator<(const Candidate& other) const { return px != other.px ? px < other.px : id > other.id; }
};

class ObjectSelector {
 public:
  ObjectSelector(const TileTree& tree, std::span<const SelectionView> views, double smallest_px,
                 PackReader::LevelRange levels)
      : tree_(tree), views_(views), smallest_px_(smallest_px), levels_(levels) {}

  ObjectSelection select(std::uint64_t budget_bytes) {
    const int tile_size = tree_.contents().pack().header().tile_size;
    ObjectSelection selection;
    consider({kMinLevel, 0, 0});
    while (!candidates_.empty()) {
      const TileId id = candidates_.top().id;
      candidates_.pop();
      if (const auto entry = entry_of(id); entry && (entry->flags & kConstant) == 0) {
        if (!tree_.contents().has(Layer::objects, id)) {
          ++selection.absent;
        } else {
          const std::uint64_t bytes = decoded_bytes_bound(*entry, tile_size);
          if (selection.bytes + bytes > budget_bytes) {
            selection.is_limited = true;
            return selection;
          }
          selection.bytes += bytes;
          selection.tiles.push_back(*entry);
        }
      }
      if (id.level >= levels_.finest) continue;
      for (int quadrant = 0; quadrant < 4; ++quadrant) {
        if (const TileId child = child_of(id, quadrant); is_valid(child)) consider(child);
      }
    }
    return selection;
  }

 private:
  std::optional<IndexEntry> entry_of(const TileId& id) const {
    if (id.level < levels_.coarsest) return std::nullopt;
    return tree_.contents().pack().find(Layer::objects, id);
  }

  void consider(const TileId& id) {
    // Above the coarsest tiles nothing is known but that there are some.
    if (id.level < levels_.coarsest) {
      const TileTree::Node& node = tree_.node(id);
      if (node.is_above_tiles || node.best.heights)
        candidates_.push({std::numeric_limits<double>::infinity(), id});
      return;
    }
    const auto entry = entry_of(id);
    if (!entry) return;
    const auto size_m = static_cast<double>(entry->geometric_error_m);
    const BoundingVolume volume = grown(tree_.node(id).best.volume, kReachPerSize * size_m);
    double px = 0;
    for (const SelectionView& view : views_) {
      px = std::max(px, view.frustum.sees(volume)
                            ? view.scale.length_px(volume, size_m)
                            : view.scale.error_px_in_the_middle(volume, size_m) / kBeyondTheView);
    }
    if (px > smallest_px_) candidates_.push({px, id});
  }

  const TileTree& tree_;
  const std::span<const SelectionView> views_;
  const double smallest_px_;
  const PackReader::LevelRange levels_;
  std::priority_queue<Candidate> candidates_;
};

}  // namespace

ObjectSelection select_objects(const TileTree& tree, std::span<const SelectionView> views, double smallest_px,
                               std::uint64_t budget_bytes) {
  const auto levels = tree.contents().pack().levels(Layer::objects);
  if (!levels || smallest_px == std::numeric_limits<double>::infinity()) return {};
  return ObjectSelector(tree, views, smallest_px, *levels).select(budget_bytes);
}

}  // namespace cairn
