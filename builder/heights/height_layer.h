#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "builder/bake/pyramid.h"
#include "builder/heights/height_node.h"
#include "builder/heights/height_plan.h"
#include "builder/mosaic/mosaic.h"
#include "cairn/build_options.h"

namespace cairn {

/// What the heights layer turned out to be.
struct HeightSummary {
  ErrorStats accuracy;
  std::vector<std::uint64_t> posts_used;  ///< by source
};

/// The heights layer of a bake, see Pyramid and bake_layer(). A tile is left out where its parent's surface
/// is within the error bound of every post and none of its descendants is stored.
class HeightLayer {
 public:
  using Tile = HeightNode;

  /// REQUIRES: mosaic and plan outlive the layer.
  HeightLayer(const Mosaic& mosaic, const HeightPlan& plan, VoidMode voids)
      : mosaic_(mosaic), plan_(plan), voids_(voids) {}

  static constexpr const char* stage() { return "heights"; }
  std::uint64_t samples_a_tile() const;

  Result<HeightNode> bake_leaf(const TileId& id) const;
  HeightNode open_parent(const TileId& id) const;
  void take(const HeightNode& child, HeightNode& parent) const;
  void close_parent(HeightNode& parent) const;
  Result<std::optional<TileBlock>> settle(HeightNode& tile) const;

  void append(const HeightNode& tile, std::vector<std::byte>& out) const { append_height_node(tile, out); }
  Result<HeightNode> read(ByteReader& in) const { return read_height_node(in, plan_.tile_size()); }

  /// Takes what a settled root of the whole tree knows.
  void summarise(const HeightNode& root);
  const HeightSummary& summary() const { return summary_; }

 private:
  const Mosaic& mosaic_;
  const HeightPlan& plan_;
  VoidMode voids_;
  HeightSummary summary_;
};

}  // namespace cairn
