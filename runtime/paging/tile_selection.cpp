#include "runtime/paging/tile_selection.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <queue>
#include <unordered_map>
#include <unordered_set>

namespace cairn {
namespace {

constexpr double kBoundless = std::numeric_limits<double>::infinity();
constexpr double kOutsideTheView = 16;  // times the limits

using Source = std::optional<IndexEntry>;

const Source& source_of(const CutNode& node, Layer layer) {
  return layer == Layer::heights ? node.heights : node.imagery;
}

/// The areas that a cut has selected in a layer: those whose own tiles it shows, and all above them.
std::unordered_set<TileId> selected_in(const TileCut& cut, Layer layer) {
  std::unordered_set<TileId> selected;
  for (const CutNode& node : cut) {
    const Source& source = source_of(node, layer);
    if (!source) continue;
    for (TileId id = source->id; selected.insert(id).second && id.level > kMinLevel;) id = parent_of(id);
  }
  return selected;
}

template <class Use>
void for_each_child(const TileId& area, Use use) {
  for (int quadrant = 0; quadrant < 4 && area.level < kMaxLevel; ++quadrant) {
    const TileId child = child_of(area, quadrant);
    if (is_valid(child)) use(child);
  }
}

bool is_seen(std::span<const SelectionView> views, const BoundingVolume& volume) {
  return std::any_of(views.begin(), views.end(),
                     [&](const SelectionView& view) { return view.frustum.sees(volume); });
}

/// The areas that show the best that the pack has for them in one layer. Areas below them show it, too, as
/// windows, until they are selected themselves. With an area, its parent is selected.
class LayerSelection {
 public:
  LayerSelection(const TileTree& tree, std::span<const SelectionView> views, Layer layer)
      : tree_(tree), views_(views), layer_(layer), tile_size_(tree.contents().pack().header().tile_size) {
    selected_.insert({kMinLevel, 0, 0});
    use(best({kMinLevel, 0, 0}));
  }

  bool contains(const TileId& area) const { return selected_.contains(area); }
  /// Bytes of the tiles that are shown.
  std::uint64_t bytes() const { return bytes_; }
  const Source& best(const TileId& area) const { return source_of(tree_.node(area).best, layer_); }

  bool has_finer(const TileId& area) const {
    const TileTree::Node& node = tree_.node(area);
    return layer_ == Layer::heights ? node.has_finer_heights : node.has_finer_imagery;
  }

  /// Selects the area after its ancestors and after those coarser areas in a view that touch it and must be
  /// no more than kLevelsApart above it, as far as the pack has tiles there. Appends what was selected, in
  /// order.
  void select(const TileId& area, std::vector<TileId>& done) {
    if (contains(area)) return;
    const TileId parent = parent_of(area);
    if (!has_finer(area) && best(area) == best(parent)) return;
    select(parent, done);
    if (!contains(parent)) return;
    const int coarsest = area.level - kLevelsApart;
    for (std::int32_t step = 0; coarsest >= kMinLevel && step < 9; ++step) {
      const TileId beside = neighbour_of(area, step % 3 - 1, step / 3 - 1);
      if (!is_valid(beside)) continue;
      const TileId other = ancestor_of(beside, coarsest);
      if (!contains(other) && is_seen(views_, tree_.node(other).best.volume)) select(other, done);
    }
    selected_.insert(area);
    use(best(area));
    if (--unselected_children(parent) == 0) drop(best(parent));
    done.push_back(area);
  }

  /// Takes the last select() of an area back. REQUIRES: no area below it is selected.
  void deselect(const TileId& area) {
    selected_.erase(area);
    drop(best(area));
    if (unselected_children(parent_of(area))++ == 0) use(best(parent_of(area)));
  }

 private:
  /// Of a selected area: while there are any, its own tile is shown.
  int& unselected_children(const TileId& area) {
    const auto [found, fresh] = unselected_children_.try_emplace(area, 0);
    if (fresh) for_each_child(area, [&](const TileId&) { ++found->second; });
    return found->second;
  }
  void use(const Source& source) {
    if (source && users_[source->id]++ == 0) bytes_ += decoded_bytes_bound(*source, tile_size_);
  }
  void drop(const Source& source) {
    if (source && --users_[source->id] == 0) bytes_ -= decoded_bytes_bound(*source, tile_size_);
  }

  const TileTree& tree_;
  const std::span<const SelectionView> views_;
  const Layer layer_;
  const int tile_size_;
  std::unordered_set<TileId> selected_;
  std::unordered_map<TileId, int> unselected_children_;
  std::unordered_map<TileId, int> users_;  // areas that show a tile
  std::uint64_t bytes_ = 0;
};

class Selector {
 public:
  Selector(const TileTree& tree, std::span<const SelectionView> views, const SelectionRules& rules,
           const TileCut& held)
      : tree_(tree),
        views_(views),
        rules_(rules),
        held_heights_(selected_in(held, Layer::heights)),
        held_imagery_(selected_in(held, Layer::imagery)),
        heights_(tree, views, Layer::heights) {
    if (rules.texel_px < kBoundless) imagery_.emplace(tree, views, Layer::imagery);
  }

  TileSelection select() {
    weigh_children({kMinLevel, 0, 0}, Layer::heights);
    if (imagery_) weigh_children({kMinLevel, 0, 0}, Layer::imagery);
    TileSelection selection;
    while (!selection.is_limited && !candidates_.empty()) {
      const Candidate next = candidates_.top();
      candidates_.pop();
      selection.is_limited = !select(next);
    }
    const CutNode& root = tree_.node({kMinLevel, 0, 0}).best;
    emit(root, root.heights, imagery_ ? root.imagery : std::nullopt, selection.cut);
    coarsen_unseen(Layer::heights, selection.cut);
    if (imagery_) coarsen_unseen(Layer::imagery, selection.cut);
    return selection;
  }

 private:
  struct Candidate {
    double excess = 0;  // times what is good enough
    Layer layer = Layer::heights;
    TileId area;
    bool operator<(const Candidate& other) const {
      if (excess != other.excess) return excess < other.excess;
      return layer != other.layer ? layer > other.layer : area > other.area;
    }
  };

  LayerSelection& selected(Layer layer) { return layer == Layer::heights ? heights_ : *imagery_; }
  std::uint64_t bytes() const { return heights_.bytes() + (imagery_ ? imagery_->bytes() : 0); }

  /// Looks for those children of a selected area for which its own tile is not good enough.
  void weigh_children(const TileId& area, Layer layer) {
    if (!selected(layer).has_finer(area)) return;
    const CutNode& shown = tree_.node(area).best;
    if (excess_in(shown, area, shown, layer) * rules_.hold <= 1) return;
    apart_.insert(area);
    const std::unordered_set<TileId>& held = layer == Layer::heights ? held_heights_ : held_imagery_;
    for_each_child(area, [&](const TileId& child) {
      if (selected(layer).contains(child)) return;
      const double excess = excess_in(shown, area, tree_.node(child).best, layer);
      const double held_excess = held.contains(child) ? excess * rules_.hold : excess;
      if (held_excess > 1) candidates_.push({held_excess, layer, child});
    });
  }

  /// How far what an area shows is from good enough in a part of it: at most 1 where it is.
  double excess_in(const CutNode& shown, const TileId& area, const CutNode& part, Layer layer) const {
    if (!shown.heights && !shown.imagery) return kBoundless;
    double excess = 0;
    for (const SelectionView& view : views_) {
      if (view.frustum.sees(part.volume)) {
        excess = std::max(excess, pixels_in_view(view.scale, shown, part.volume, layer));
      } else if (view.ring.contains(area)) {
        excess = std::max(excess, pixels_beside_view(view.scale, shown, part.volume, layer));
      }
    }
    return excess;
  }

  double pixels_in_view(const ScreenScale& scale, const CutNode& shown, const BoundingVolume& volume,
                        Layer layer) const {
    return layer == Layer::heights ? scale.error_px(volume, height_error_m(shown)) / rules_.heights_px
                                   : scale.length_px(volume, texel_m(shown)) / rules_.texel_px;
  }
  double pixels_beside_view(const ScreenScale& scale, const CutNode& shown, const BoundingVolume& volume,
                            Layer layer) const {
    const bool is_of_heights = layer == Layer::heights;
    const double length_m = is_of_heights ? height_error_m(shown) : texel_m(shown);
    const double limit_px = is_of_heights ? rules_.heights_px : rules_.texel_px;
    return scale.error_px_in_the_middle(volume, length_m) / (kOutsideTheView * limit_px);
  }
  /// Without heights, nothing is known of what there is below but how fine it may be.
  double height_error_m(const CutNode& shown) const {
    return shown.heights ? static_cast<double>(shown.heights->geometric_error_m)
                         : sample_width_m(shown.area.level, tree_.contents().pack().header());
  }
  double texel_m(const CutNode& shown) const {
    return sample_width_m(shown.imagery ? shown.imagery->id.level : shown.area.level,
                          tree_.contents().pack().header());
  }

  /// Selects the area, and what has to be selected with it; false, and nothing is changed, where that does
  /// not fit the budget.
  bool select(const Candidate& candidate) {
    LayerSelection& layer = selected(candidate.layer);
    std::vector<TileId> done;
    layer.select(candidate.area, done);
    if (bytes() > rules_.budget_bytes) {
      for (auto area = done.rbegin(); area != done.rend(); ++area) layer.deselect(*area);
      return false;
    }
    for (const TileId& area : done) weigh_children(area, candidate.layer);
    return true;
  }

  /// Appends the leaves below an area, depth first. Where all of its children would show what it shows
  /// itself, and that is good enough in it as a whole, it is a leaf.
  void emit(const CutNode& node, const Source& heights, const Source& imagery, TileCut& cut) const {
    bool has_parts = apart_.contains(node.area);
    for_each_child(node.area, [&](const TileId& child) {
      has_parts = has_parts || heights_.contains(child) || (imagery_ && imagery_->contains(child));
    });
    if (!has_parts) {
      cut.push_back({node.area, heights, imagery, node.volume});
      return;
    }
    for_each_child(node.area, [&](const TileId& id) {
      const CutNode& child = tree_.node(id).best;
      emit(child, heights_.contains(id) ? child.heights : heights,
           imagery_ && imagery_->contains(id) ? child.imagery : imagery, cut);
    });
  }

  /// Where no view sees a window of a tile, which is there for its finer children, a coarser tile is shown
  /// that is good enough there: one that is shown elsewhere, if there is one, and else the coarsest.
  void coarsen_unseen(Layer layer, TileCut& cut) const {
    // A coarser tile still has samples at the corners of the area.
    const int deepest =
        std::bit_width(static_cast<unsigned>(tree_.contents().pack().header().tile_size - 1)) - 1;
    std::unordered_set<TileId> used;
    std::vector<CutNode*> unseen;
    for (CutNode& node : cut) {
      const Source& source = source_of(node, layer);
      if (!source) continue;
      const bool may_change =
          source->id != node.area && has_selected_child(source->id, layer) && !is_seen(views_, node.volume);
      if (may_change) {
        unseen.push_back(&node);
      } else {
        used.insert(source->id);
      }
    }
    for (CutNode* node : unseen) {
      Source& source = layer == Layer::heights ? node->heights : node->imagery;
      const Source* coarser = nullptr;
      for (int level = kMinLevel; level < source->id.level; ++level) {
        const CutNode& above = tree_.node(ancestor_of(node->area, level)).best;
        const Source& candidate = source_of(above, layer);
        if (!candidate || node->area.level - candidate->id.level > deepest) continue;
        const bool is_better =
            coarser ? used.contains(candidate->id) : excess_in(above, above.area, *node, layer) <= 1;
        if (is_better) coarser = &candidate;
      }
      if (coarser) source = *coarser;
    }
  }

  bool has_selected_child(const TileId& area, Layer layer) const {
    const LayerSelection& selection = layer == Layer::heights ? heights_ : *imagery_;
    bool has = false;
    for_each_child(area, [&](const TileId& child) { has = has || selection.contains(child); });
    return has;
  }

  const TileTree& tree_;
  const std::span<const SelectionView> views_;
  const SelectionRules& rules_;
  const std::unordered_set<TileId> held_heights_;
  const std::unordered_set<TileId> held_imagery_;
  LayerSelection heights_;
  std::optional<LayerSelection> imagery_;
  std::unordered_set<TileId> apart_;  // areas whose parts were weighed one by one
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

double sample_width_m(int level, const PackHeader& pack) {
  return pack.body.shape.equator_degree_m() * tile_width_degrees(level) / (pack.tile_size - 1);
}

Shortfall shortfall_of(const TileTree& tree, const CutNode& shown) {
  const TileTree::Node& node = tree.node(shown.area);
  Shortfall shortfall;
  if (shown.heights && (node.has_finer_heights || node.best.heights != shown.heights)) {
    shortfall.heights_m = static_cast<double>(shown.heights->geometric_error_m);
  }
  if (shown.imagery && (node.has_finer_imagery || node.best.imagery != shown.imagery)) {
    shortfall.texel_m = sample_width_m(shown.imagery->id.level, tree.contents().pack().header());
  }
  return shortfall;
}

}  // namespace cairn
