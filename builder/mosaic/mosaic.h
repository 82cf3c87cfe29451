#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "builder/mosaic/geoid.h"
#include "builder/mosaic/group_overlay.h"
#include "builder/mosaic/source_group.h"
#include "builder/mosaic/vertical_datum.h"
#include "builder/raster/io/chunk_cache.h"
#include "builder/raster/raster_pool.h"
#include "cairn/mosaic_options.h"
#include "cairn/tile_id.h"

namespace cairn {

/// The samples of one tile, from all sources, and the posts that won there.
struct MosaicTile {
  std::vector<float> heights;  ///< metres, N·N, rows south to north; a smooth filler where the state is none
  std::vector<SampleState> states;   ///< empty where all are sourced
  std::vector<MeasuredPosts> posts;  ///< by group; which of them lost see GroupOverlay
  std::vector<std::size_t> groups;   ///< which groups those are
};

/// All sources of a bake as one surface. Groups of sources win over one another as wholes: those of finer
/// posts first, then by the order on the command line. How they go over into one another says GroupOverlay.
/// Beyond the rim of a group its difference from those beneath fades over posts of the coarsest of them;
/// into its voids it fades as far.
class Mosaic {
 public:
  static Result<std::unique_ptr<Mosaic>> open(const MosaicOptions& options, int tile_size);

  /// open() of sources that were looked at before: `options.inputs` do not count. Where no post is going to
  /// be read, the geoid need not be opened.
  static Result<std::unique_ptr<Mosaic>> over(std::unique_ptr<RasterPool> pool, const MosaicOptions& options,
                                              int tile_size, bool open_geoid);

  /// What may be kept of the sources and of what is resampled of them. Before any sample() only.
  void set_cache_bytes(std::size_t bytes);

  const RasterPool& pool() const { return *pool_; }
  RasterPool& pool() { return *pool_; }
  /// Whether any source's posts lie on no lattice of longitude and latitude.
  bool has_projected_sources() const;
  /// Lets go of the sources' files and caches, once no more is read of them.
  void close_sources() { pool_->close(); }
  const std::vector<std::unique_ptr<SourceGroup>>& groups() const { return groups_; }
  /// How the groups lie over one another, a layer for each.
  const std::vector<GroupOverlay::Layer>& overlaid() const { return overlay_->layers(); }

  /// The finest level that any group needs.
  int finest_level() const;
  GeoBounds bounds() const;
  bool is_global() const;
  /// Whether all posts of the group are whole metres.
  bool whole_metres(std::size_t group) const { return whole_metres_[group]; }
  /// The error bound of the group's posts: the one asked for, else 0.5 m for whole metres and 0.05 m for
  /// others.
  double error_bound_m(std::size_t group) const;
  /// The least and the largest error bound of any group.
  struct ErrorBounds {
    double least_m = 0;
    double largest_m = 0;
  };
  ErrorBounds error_bounds() const;
  /// What heights are measured from.
  const MosaicDatum& datum() const { return datum_; }
  /// How smooth resampling keeps a group's posts. Before any sample() only.
  void set_tolerance(std::size_t group, const SmoothTolerance& tolerance);
  /// Whether heights can be stored as the sources have them: every post lies on a sample, and none is
  /// converted.
  bool posts_are_samples() const;

  /// Whether any source covers an area of the tile.
  bool covers(const TileId& id) const;

  /// Whether any source reaches the tile or its edge.
  bool touches(const TileId& id) const;

  /// The level at which the tile's area must be sampled: the finest native level of the groups that touch it,
  /// counting the zone in which they fade. nullopt where no source covers any of it.
  std::optional<int> leaf_level(const TileId& id) const;

  /// REQUIRES: touches(id), and no group that touches it needs a finer level. Safe to call from several
  /// threads.
  Result<MosaicTile> sample(const TileId& id) const;

  /// By sample of the tile, as sample() orders them: 1 where a group reaches whose posts are no whole metres.
  /// A function of the sample's place alone. Empty where none reaches the tile.
  std::vector<std::uint8_t> near_fractions(const TileId& id) const;

 private:
  Mosaic() = default;
  void overlay_groups(const MosaicOptions& options);
  int finest_level_of(std::span<const std::size_t> groups) const;
  Result<MosaicTile> sample_window(const SampleWindow& window, int level) const;

  int tile_size_ = 513;
  std::unique_ptr<RasterPool> pool_;
  bool with_geoid_ = false;
  std::optional<Geoid> geoid_;
  std::shared_ptr<ChunkCache> blocks_ = std::make_shared<ChunkCache>(0);  // of projected groups
  std::vector<std::unique_ptr<SourceGroup>> groups_;                      // highest priority first
  std::optional<GroupOverlay> overlay_;                                   // a layer for each of them
  std::vector<bool> whole_metres_;                                        // by group
  std::optional<double> asked_error_bound_m_;
  MosaicDatum datum_;
};

}  // namespace cairn
