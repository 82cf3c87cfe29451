#include "runtime/paging/tile_selection.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <queue>
#include <unordered_map>
#include <unordered_set>

#include "cairn/geodesy.h"

namespace cairn {
namespace {

constexpr double kBoundless = std::numeric_limits<double>::infinity();
constexpr double kOutsideTheView = 4;  // times the limits

/// An area of the tree that is walked, and the sources chosen for it.
struct Area {
  const TileTree::Node* node = nullptr;
  const std::optional<IndexEntry>* heights = nullptr;
  const std::optional<IndexEntry>* imagery = nullptr;
  bool needs_heights = false;
  bool needs_imagery = false;
  std::int32_t first_child = -1;  ///< of child_count in a row; -1: a leaf
  std::int32_t child_count = 0;

  const TileId& id() const { return node->best.area; }
};

/// The areas that a cut splits, by what it shows.
class HeldSplits {
 public:
  explicit HeldSplits(const TileCut& cut) {
    for (const CutNode& node : cut) {
      if (node.heights) add(node.heights->id, heights_);
      if (node.imagery) add(node.imagery->id, imagery_);
    }
  }
  bool heights(const TileId& area) const { return heights_.contains(area); }
  bool imagery(const TileId& area) const { return imagery_.contains(area); }

 private:
  static void add(TileId id, std::unordered_set<TileId>& splits) {
    while (id.level > kMinLevel) {
      id = parent_of(id);
      if (!splits.insert(id).second) return;
    }
  }
  std::unordered_set<TileId> heights_;
  std::unordered_set<TileId> imagery_;
};

/// The tiles that the leaves show, and their bytes.
class SourceUse {
 public:
  explicit SourceUse(int tile_size) : tile_size_(tile_size) {}

  void add(const Area& area) {
    add(*area.heights);
    add(*area.imagery);
  }
  void remove(const Area& area) {
    remove(*area.heights);
    remove(*area.imagery);
  }
  std::uint64_t bytes() const { return bytes_; }

 private:
  void add(const std::optional<IndexEntry>& entry) {
    if (entry && users_[key_of(*entry)]++ == 0) bytes_ += decoded_bytes_bound(*entry, tile_size_);
  }
  void remove(const std::optional<IndexEntry>& entry) {
    if (entry && --users_[key_of(*entry)] == 0) bytes_ -= decoded_bytes_bound(*entry, tile_size_);
  }
  const int tile_size_;
  std::unordered_map<TileKey, int> users_;
  std::uint64_t bytes_ = 0;
};

class Selector {
 public:
  Selector(const TileTree& tree, std::span<const SelectionView> views, const SelectionRules& rules,
           const TileCut& held)
      : tree_(tree),
        views_(views),
        rules_(rules),
        held_(held),
        tile_size_(tree.contents().pack().header().tile_size),
        use_(tile_size_) {}

  TileSelection select() {
    const TileTree::Node& root = tree_.node({kMinLevel, 0, 0});
    add_area({&root, &root.best.heights, imagery_of(root)});
    TileSelection selection;
    while (!candidates_.empty()) {
      const std::size_t next = candidates_.top().area;
      candidates_.pop();
      if (!split(next)) {
        selection.is_limited = true;
        break;
      }
    }
    emit(0, selection.cut);
    return selection;
  }

 private:
  struct Candidate {
    double excess = 0;  // times what is good enough
    std::size_t area = 0;
    bool operator<(const Candidate& other) const {
      return excess != other.excess ? excess < other.excess : area > other.area;
    }
  };

  const std::optional<IndexEntry>* imagery_of(const TileTree::Node& node) const {
    static constexpr std::optional<IndexEntry> kNone;
    return rules_.texel_px < kBoundless ? &node.best.imagery : &kNone;
  }

  void add_area(Area area) {
    const double excess = weigh(area);
    areas_.push_back(area);
    use_.add(area);
    if (excess > 1) candidates_.push({excess, areas_.size() - 1});
  }

  /// How far the area is from good enough, and which of its layers are not.
  double weigh(Area& area) const {
    double heights = heights_excess(area), imagery = imagery_excess(area);
    if (held_.heights(area.id())) heights *= rules_.hold;
    if (held_.imagery(area.id())) imagery *= rules_.hold;
    area.needs_heights = heights > 1;
    area.needs_imagery = imagery > 1;
    return std::max(heights, imagery);
  }

  double heights_excess(const Area& area) const {
    const TileTree::Node& node = *area.node;
    if (node.is_above_tiles && !*area.heights && !*area.imagery) return kBoundless;
    if (!node.has_finer_heights && node.best.heights == *area.heights) return 0;
    // Without heights, nothing is known of what there is below but how fine it may be.
    const double error_m = *area.heights ? static_cast<double>((*area.heights)->geometric_error_m)
                                         : sample_width_m(area.id().level, tile_size_);
    double excess = 0;
    for (const SelectionView& view : views_) {
      if (view.frustum.sees(node.best.volume)) {
        excess = std::max(excess, view.scale.error_px(node.best.volume, error_m) / rules_.heights_px);
      } else if (view.ring.contains(area.id())) {
        const double px = view.scale.error_px_in_the_middle(node.best.volume, error_m);
        excess = std::max(excess, px / (kOutsideTheView * rules_.heights_px));
      }
    }
    return excess;
  }

  double imagery_excess(const Area& area) const {
    const TileTree::Node& node = *area.node;
    if (rules_.texel_px == kBoundless) return 0;
    if (!node.has_finer_imagery && node.best.imagery == *area.imagery) return 0;
    const int level = *area.imagery ? (*area.imagery)->id.level : area.id().level;
    const double texel_m = sample_width_m(level, tile_size_);
    double excess = 0;
    for (const SelectionView& view : views_) {
      if (view.frustum.sees(node.best.volume)) {
        excess = std::max(excess, view.scale.length_px(node.best.volume, texel_m) / rules_.texel_px);
      } else if (view.ring.contains(area.id())) {
        const double px = view.scale.error_px_in_the_middle(node.best.volume, texel_m);
        excess = std::max(excess, px / (kOutsideTheView * rules_.texel_px));
      }
    }
    return excess;
  }

  /// Splits the area; false, and nothing is changed, where that does not fit the budget.
  bool split(std::size_t index) {
    const Area parent = areas_[index];
    if (parent.id().level == kMaxLevel) return true;
    std::vector<Area> children;
    for (int quadrant = 0; quadrant < 4; ++quadrant) {
      const TileId id = child_of(parent.id(), quadrant);
      if (!is_valid(id)) continue;
      const TileTree::Node& node = tree_.node(id);
      children.push_back({&node, parent.needs_heights ? &node.best.heights : parent.heights,
                          parent.needs_imagery ? imagery_of(node) : parent.imagery});
    }
    use_.remove(parent);
    for (const Area& child : children) use_.add(child);
    const bool fits = use_.bytes() <= rules_.budget_bytes;
    for (const Area& child : children) use_.remove(child);
    if (!fits) {
      use_.add(parent);
      return false;
    }
    areas_[index].first_child = static_cast<std::int32_t>(areas_.size());
    areas_[index].child_count = static_cast<std::int32_t>(children.size());
    for (const Area& child : children) add_area(child);
    return true;
  }

  /// Appends the leaves below an area, depth first. Where all of its children would show what it shows
  /// itself, it is a leaf.
  void emit(std::size_t index, TileCut& cut) const {
    const Area& area = areas_[index];
    const std::size_t first = cut.size();
    for (std::int32_t child = 0; child < area.child_count; ++child) {
      emit(static_cast<std::size_t>(area.first_child + child), cut);
    }
    const auto adds_nothing = [&](const CutNode& leaf) {
      return leaf.area.level == area.id().level + 1 && leaf.heights == *area.heights &&
             leaf.imagery == *area.imagery;
    };
    const auto begin = cut.begin() + static_cast<std::ptrdiff_t>(first);
    if (area.first_child >= 0 && !std::all_of(begin, cut.end(), adds_nothing)) return;
    cut.resize(first);
    cut.push_back({area.id(), *area.heights, *area.imagery, area.node->best.volume});
  }

  const TileTree& tree_;
  const std::span<const SelectionView> views_;
  const SelectionRules& rules_;
  const HeldSplits held_;
  const int tile_size_;
  SourceUse use_;
  std::vector<Area> areas_;
  std::priority_queue<Candidate> candidates_;
};

}  // namespace

SelectionView selection_view(const ViewState& view, const TileAvailability& contents,
                             const Occluder& occluder, RefinementPattern pattern, FocusTile& focus) {
  // Measured from the highest ground that the eye's tile may have, from the index: what is loaded must not
  // decide the level.
  const double above_ground_m = view.height_m - contents.ceiling_m(view.eye);
  const double ideal = level_for_pixel_size(view, above_ground_m, contents.pack().header().tile_size);
  const TileId eye_tile = focus.update(view.eye, ideal, kMinLevel, contents.levels().finest);
  return {ViewFrustum(view, occluder), ScreenScale(view), eye_tile,
          mark_splits({eye_tile, kMinLevel, pattern})};
}

TileSelection select_tiles(const TileTree& tree, std::span<const SelectionView> views,
                           const SelectionRules& rules, const TileCut& held) {
  assert(rules.heights_px > 0 && rules.texel_px > 0 && rules.hold >= 1);
  return Selector(tree, views, rules, held).select();
}

double sample_width_m(int level, int tile_size) {
  const double degree_m = kEquatorialRadius * std::numbers::pi / 180;
  return degree_m * tile_width_degrees(level) / (tile_size - 1);
}

Shortfall shortfall_of(const TileTree& tree, const CutNode& shown) {
  const TileTree::Node& node = tree.node(shown.area);
  Shortfall shortfall;
  if (shown.heights && (node.has_finer_heights || node.best.heights != shown.heights)) {
    shortfall.heights_m = static_cast<double>(shown.heights->geometric_error_m);
  }
  if (shown.imagery && (node.has_finer_imagery || node.best.imagery != shown.imagery)) {
    shortfall.texel_m = sample_width_m(shown.imagery->id.level, tree.contents().pack().header().tile_size);
  }
  return shortfall;
}

}  // namespace cairn
