#include "builder/heights/rqt_layer.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "builder/bake/layer_bake.h"
#include "builder/bake/pipeline.h"
#include "builder/bake/tile_layer.h"
#include "builder/bake/tile_tree.h"
#include "format/height_block.h"
#include "format/rqt_block.h"
#include "format/rqt_borders.h"
#include "format/rqt_triangulate.h"

namespace cairn {
namespace {

constexpr int kLevelsInUnit = 2;

using Entries = std::unordered_map<TileId, IndexEntry>;

Result<std::map<int, Entries>> heights_by_level(const PackWriter& pack) {
  std::map<int, Entries> levels;
  const Status status = pack.visit_entries([&levels](const IndexEntry& entry) -> Status {
    if (entry.layer == Layer::heights) levels[entry.id.level].emplace(entry.id, entry);
    return {};
  });
  if (!status) return status.error();
  return levels;
}

/// The tiles of one level as leaves of a tree, which is walked in the order in which the heights were baked.
TileTree tree_over(int level, const Entries& tiles) {
  std::unordered_set<TileId> walked;
  for (const auto& [id, entry] : tiles) {
    for (TileId at = id; walked.insert(at).second && at.level > kMinLevel;) at = parent_of(at);
  }
  return TileTree(std::max(kMinLevel, level - kLevelsInUnit),
                  [level, walked = std::move(walked)](const TileId& id) {
                    return walked.contains(id) ? std::optional(level) : std::nullopt;
                  });
}

/// The triangulations of one level of heights, a TileLayer. Parents are not stored: they are of coarser
/// levels.
class RqtLevel {
 public:
  struct Node {
    TileId id;
    std::unique_ptr<RqtSteps> vertices;  ///< none in a parent
  };
  using Leaf = Node;

  RqtLevel(const RqtPlan& plan, const PackWriter& pack, int level, const Entries& heights)
      : plan_(plan),
        pack_(pack),
        heights_(heights),
        borders_(plan.tile_size),
        tolerance_m_(std::ldexp(plan.tolerance_m, plan.finest - level)) {}

  /// Triangulates every tile for itself, so that the borders of all can agree. sample_leaf() needs that.
  Status agree_on_borders(const TileTree& tree, int threads) {
    const std::vector<TileId> units = tree.units();
    const auto status = run_in_order<std::vector<Node>>(
        0, units.size(), static_cast<std::size_t>(threads) + 1,
        [&](std::size_t u) { return triangulate_all(tree.leaves(units[u])); },
        [&](std::size_t, std::vector<Node>&& nodes) -> Status {
          for (const Node& node : nodes) borders_.add(node.id, *node.vertices);
          return {};
        });
    if (status) borders_.settle();
    return status;
  }

  Result<Node> sample_leaf(const TileId& id) const {
    auto vertices = triangulate_tile(id);
    if (!vertices) return vertices.error();
    borders_.apply(id, *vertices);
    return Node{id, std::make_unique<RqtSteps>(std::move(*vertices))};
  }
  Node measure_leaf(Node leaf) const { return leaf; }

  Node begin_parent(const TileId& id) const { return {id, nullptr}; }
  void merge_child(const Node&, Node&) const {}
  void finish_parent(Node&) const {}

  bool can_prune(const Node& node) const { return !node.vertices; }
  void prune(Node&) const {}
  void keep(Node&) const {}

  TileBlock encode(Node& node) const {
    TileBlock out;
    out.entry.layer = Layer::rqt;
    out.entry.id = node.id;
    out.entry.geometric_error_m = tolerance_m_;
    out.entry.min_quanta = static_cast<std::int32_t>(node.vertices->triangle_count(kRqtSteps - 1));
    out.entry.max_quanta = static_cast<std::int32_t>(node.vertices->triangle_count(0));
    out.block = encode_rqt_block({tolerance_m_, kRqtSteps, std::move(*node.vertices)});
    return out;
  }

  void save_state(const Node& node, std::vector<std::byte>& out) const {
    ByteWriter writer(out);
    writer.write(std::int32_t{node.id.level});
    writer.write(node.id.x);
    writer.write(node.id.y);
  }
  Result<Node> load_state(ByteReader& in) const {
    Node node;
    node.id.level = in.read<std::int32_t>();
    node.id.x = in.read<std::int32_t>();
    node.id.y = in.read<std::int32_t>();
    if (!in.ok() || !is_valid(node.id)) return bad_data("journal: a finished subtree: expected more bytes");
    return node;
  }
  void finish_root(const Node&) {}

 private:
  Result<HeightTile> heights_of(const TileId& id) const {
    const IndexEntry& entry = heights_.at(id);
    if ((entry.flags & kConstant) != 0) {
      const auto side = static_cast<std::size_t>(plan_.tile_size);
      return HeightTile{plan_.tile_size, std::vector<std::int32_t>(side * side, entry.min_quanta), {}};
    }
    const auto block = pack_.read_block(entry);
    if (!block) return block.error();
    return decode_height_block(*block, plan_.tile_size);
  }

  Result<RqtSteps> triangulate_tile(const TileId& id) const {
    const auto tile = heights_of(id);
    if (!tile) return tile.error();
    return triangulate(*tile, plan_.quantum_m, tolerance_m_, kRqtSteps, root_rises(id));
  }

  Result<std::vector<Node>> triangulate_all(const std::vector<TileId>& ids) const {
    std::vector<Node> nodes;
    for (const TileId& id : ids) {
      auto vertices = triangulate_tile(id);
      if (!vertices) return vertices.error();
      nodes.push_back({id, std::make_unique<RqtSteps>(std::move(*vertices))});
    }
    return nodes;
  }

  const RqtPlan& plan_;
  const PackWriter& pack_;
  const Entries& heights_;
  RqtBorders borders_;
  float tolerance_m_;
};

}  // namespace

Status bake_rqt_layers(const RqtPlan& plan, int threads, BakeSession& session,
                       const ProgressCallback& progress) {
  if (auto status = session.writer.flush(); !status) return status;
  const Result<std::map<int, Entries>> found = heights_by_level(session.writer);
  if (!found) return found.error();
  const std::map<int, Entries>& levels = *found;
  const auto intervals = static_cast<std::uint64_t>(plan.tile_size - 1);
  const std::uint64_t samples = intervals * intervals;
  Progress now{"rqt", 0, 0, session.writer.position()};
  for (const auto& [level, tiles] : levels) now.total += tiles.size() * samples;
  for (const auto& [level, tiles] : levels) {
    const TileTree tree = tree_over(level, tiles);
    RqtLevel layer(plan, session.writer, level, tiles);
    const bool is_done = tree.units().size() <= session.done.size();
    if (!is_done) {
      if (auto status = layer.agree_on_borders(tree, threads); !status) return status;
    }
    if (auto status = bake_layer(layer, tree, samples, threads, session, now, progress); !status)
      return status;
  }
  return {};
}

}  // namespace cairn
