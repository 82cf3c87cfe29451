#pragma once

#include "builder/bake/tile_tree.h"
#include "builder/heights/geometric_error.h"
#include "builder/mosaic/mosaic.h"
#include "cairn/grid_options.h"
#include "cairn/height_options.h"
#include "cairn/tile_id.h"

namespace cairn {

/// What the heights layer of a bake will be, decided before any post is read.
class HeightPlan {
 public:
  /// REQUIRES: the mosaic outlives the plan.
  static Result<HeightPlan> make(const Mosaic& mosaic, const MosaicOptions& asked,
                                 const HeightOptions& heights, const GridOptions& grid);

  int tile_size() const { return tile_size_; }
  int top() const { return tree_.top(); }                  ///< the coarsest level
  int finest() const { return finest_; }                   ///< the finest level that is stored
  double error_bound_m() const { return error_bound_m_; }  ///< E
  double quantum_m() const { return quantum_m_; }

  /// What is left of the error bound for the surface before it is rounded to quanta.
  SmoothTolerance tolerance() const;

  /// The tiles, before pruning leaves any out.
  const TileTree& tree() const { return tree_; }
  /// Which posts of a leaf are its own to count.
  PostCounting counting(const TileId& leaf) const;

 private:
  explicit HeightPlan(const Mosaic& mosaic);
  Status choose_levels(const MosaicOptions& asked, const GridOptions& grid);
  double default_quantum(ResampleMethod resampling) const;
  void choose_quantum(const MosaicOptions& asked, const HeightOptions& heights);

  const Mosaic* mosaic_;
  int tile_size_ = 513;
  int finest_ = 0;
  double error_bound_m_ = 0.5;
  double quantum_m_ = 0.25;
  TileTree tree_;
};

}  // namespace cairn
