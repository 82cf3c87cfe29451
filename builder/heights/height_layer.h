#pragma once

#include <cstdint>
#include <vector>

#include "builder/bake/tile_layer.h"
#include "builder/heights/height_leaf.h"
#include "builder/heights/height_node.h"
#include "builder/heights/height_plan.h"
#include "builder/mosaic/mosaic.h"

namespace cairn {

/// What the heights layer turned out to be.
struct HeightSummary {
  ErrorStats accuracy;
  std::vector<std::uint64_t> posts_used;  ///< by source
  std::vector<std::uint64_t> posts_lost;  ///< by source: those over which a source of another grid won
};

/// The heights layer of a bake, a TileLayer. A tile is pruned where its parent's surface is within the error
/// bound of every post and none of its descendants is stored.
class HeightLayer {
 public:
  using Leaf = SampledLeaf;
  using Node = HeightNode;

  /// REQUIRES: mosaic and plan outlive the layer.
  HeightLayer(const Mosaic& mosaic, const HeightPlan& plan, VoidMode voids)
      : mosaic_(mosaic), plan_(plan), voids_(voids) {}

  Result<SampledLeaf> sample_leaf(const TileId& id) const;
  HeightNode measure_leaf(SampledLeaf leaf) const;

  HeightNode begin_parent(const TileId& id) const;
  void merge_child(const HeightNode& child, HeightNode& parent) const;
  void finish_parent(HeightNode& parent) const;

  bool can_prune(const HeightNode& node) const;
  void prune(HeightNode& node) const;
  void keep(HeightNode& node) const;
  TileBlock encode(const HeightNode& node) const;

  void save_state(const HeightNode& node, std::vector<std::byte>& out) const {
    append_height_node(node, out);
  }
  Result<HeightNode> load_state(ByteReader& in) const { return read_height_node(in, plan_.tile_size()); }

  void finish_root(const HeightNode& root);
  const HeightSummary& summary() const { return summary_; }

 private:
  const Mosaic& mosaic_;
  const HeightPlan& plan_;
  VoidMode voids_;
  HeightSummary summary_;
};

}  // namespace cairn
