#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "builder/build_options.h"
#include "builder/geometric_error.h"
#include "builder/mosaic.h"
#include "format/tile_id.h"

namespace cairn {

/// Which tiles a bake works on, decided before any post is read. The tree is walked depth first, children in
/// the order of their quadrants, parents after their children: a space-filling order.
class BuildPlan {
 public:
  /// REQUIRES: the mosaic outlives the plan.
  static Result<BuildPlan> make(const Mosaic& mosaic, const BuildOptions& options);

  int tile_size() const { return tile_size_; }
  int top() const { return top_; }                 ///< the coarsest level
  int finest() const { return finest_; }           ///< the finest level that is stored
  double promise_m() const { return promise_m_; }  ///< E
  double quantum_m() const { return quantum_m_; }

  /// Whether the bake makes the tile or descendants of it.
  bool wants(const TileId& id) const;
  /// Whether the tile is sampled from the mosaic, not put together from its children. REQUIRES: wants(id).
  bool is_leaf(const TileId& id) const;
  /// How many of its children are wanted.
  int children_of(const TileId& id) const;
  /// Which posts of a leaf are its own to count.
  PostCounting counting(const TileId& leaf) const;

  /// Subtrees of at most 16 leaves, in the order of the walk: what one task does.
  std::vector<TileId> units() const;
  /// The leaves of a unit, in the order of the walk.
  std::vector<TileId> leaves(const TileId& unit) const;
  std::uint64_t leaf_count() const;
  /// Tiles by level, before economy leaves any out.
  std::map<int, std::uint64_t> tiles_by_level() const;

 private:
  explicit BuildPlan(const Mosaic& mosaic) : mosaic_(&mosaic) {}
  Status choose_levels(const BuildOptions& options);
  Status choose_quantum(const BuildOptions& options);
  template <class Visit>
  void walk(const TileId& id, const Visit& visit) const;

  const Mosaic* mosaic_;
  int tile_size_ = 513;
  int top_ = 0;
  int finest_ = 0;
  double promise_m_ = 0.5;
  double quantum_m_ = 0.25;
  std::optional<GeoBounds> region_;
};

}  // namespace cairn
