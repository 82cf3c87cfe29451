#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "builder/mosaic/geoid.h"
#include "builder/mosaic/source_group.h"
#include "builder/raster/raster_pool.h"
#include "cairn/mosaic_options.h"
#include "cairn/tile_id.h"

namespace cairn {

/// The samples of one tile, from all sources, and the posts that won there.
struct MosaicTile {
  std::vector<float> heights;  ///< metres, N·N, rows south to north; a smooth filler where the state is none
  std::vector<SampleState> states;   ///< empty where all are sourced
  std::vector<MeasuredPosts> posts;  ///< one a group; those that lost to a source of higher priority are NaN
  std::vector<std::size_t> groups;   ///< which groups those are
};

/// All sources of a bake as one surface. Groups of sources win over one another as wholes: finer posts first,
/// then the order on the command line. Beyond the edge of a group its heights fade into those beneath over
/// one post of the coarsest group beneath, so there is no cliff; posts beneath lose as far as the fade_weight
/// reaches. A group fades the same way into its voids, from their rims inwards, where something lies beneath.
///
/// A group is sampled at its native level only; where a finer group makes finer tiles, it is interpolated
/// linearly from there. So a sample's height is a function of its place alone, whichever tile asks and at
/// whatever level, and shared edges agree bit for bit.
class Mosaic {
 public:
  static Result<std::unique_ptr<Mosaic>> open(const MosaicOptions& options, int tile_size,
                                              std::size_t cache_bytes);

  const RasterPool& pool() const { return *pool_; }
  /// Lets go of the sources' files and caches, once no more is read of them.
  void close_sources() { pool_->close(); }
  const std::vector<std::unique_ptr<SourceGroup>>& groups() const { return groups_; }

  /// The finest level that any group needs.
  int finest_level() const;
  GeoBounds bounds() const;
  bool is_global() const;
  bool whole_metres() const { return whole_metres_; }
  /// Samples for each post along an axis, the least of any source.
  double samples_per_post() const;
  /// How smooth resampling keeps the posts. Before any sample() only.
  void set_tolerance(const SmoothTolerance& tolerance);
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

 private:
  struct Reach {
    double solid = 0;  ///< degrees beyond the footprint in which the group alone counts: one of its posts
    double fade = 0;   ///< and then, in which it fades into those beneath; 0 where nothing lies beneath
  };

  Mosaic() = default;
  void set_reaches();
  double weight(std::size_t group, const Footprint& near, LonLat place) const;
  std::vector<std::size_t> groups_touching(const GeoBounds& bounds) const;
  struct GroupLayer {
    std::size_t group = 0;
    GroupSamples samples;
  };
  Result<std::vector<GroupLayer>> sample_layers(const SampleWindow& window, int level) const;
  Result<MosaicTile> sample_window(const SampleWindow& window, int level) const;
  void blend(std::size_t group, const SampleWindow& window, GroupSamples&& samples, MosaicTile& tile) const;
  void drop_losing_posts(const SampleWindow& window, std::span<const std::size_t> touching,
                         MosaicTile& tile) const;

  int tile_size_ = 513;
  std::unique_ptr<RasterPool> pool_;
  std::optional<Geoid> geoid_;
  std::vector<std::unique_ptr<SourceGroup>> groups_;  // highest priority first
  std::vector<Reach> reaches_;                        // by group
  bool whole_metres_ = true;
};

}  // namespace cairn
