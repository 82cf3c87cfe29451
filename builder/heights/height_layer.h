#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "builder/bake/pyramid.h"
#include "builder/heights/baked_tile.h"
#include "builder/heights/build_plan.h"
#include "builder/mosaic/mosaic.h"
#include "builder/options/build_options.h"

namespace cairn {

/// What the heights layer turned out to be.
struct HeightSummary {
  PostStats accuracy;
  std::vector<std::uint64_t> posts_won;  ///< by source
};

/// The heights layer of a bake, see Pyramid and bake_layer(). A tile is left out where its parent's surface
/// is within the promise of every post and none of its descendants is stored.
class HeightLayer {
 public:
  using Tile = BakedTile;

  /// REQUIRES: mosaic and plan outlive the layer.
  HeightLayer(const Mosaic& mosaic, const BuildPlan& plan, VoidMode voids)
      : mosaic_(mosaic), plan_(plan), voids_(voids) {}

  static constexpr const char* stage() { return "heights"; }
  std::uint64_t samples_a_tile() const;

  Result<BakedTile> bake_leaf(const TileId& id) const;
  BakedTile open_parent(const TileId& id) const;
  void take(const BakedTile& child, BakedTile& parent) const;
  void close_parent(BakedTile& parent) const;
  Result<std::optional<TileBlock>> settle(BakedTile& tile) const;

  void append(const BakedTile& tile, std::vector<std::byte>& out) const { append_baked_tile(tile, out); }
  Result<BakedTile> read(ByteReader& in) const { return read_baked_tile(in, plan_.tile_size()); }

  /// Takes what a settled root of the whole tree knows.
  void summarise(const BakedTile& root);
  const HeightSummary& summary() const { return summary_; }

 private:
  const Mosaic& mosaic_;
  const BuildPlan& plan_;
  VoidMode voids_;
  HeightSummary summary_;
};

}  // namespace cairn
