#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "builder/mosaic/geoid.h"
#include "builder/mosaic/grid_placement.h"
#include "builder/mosaic/source_group.h"
#include "builder/raster/io/chunk_cache.h"
#include "builder/raster/raster_pool.h"
#include "builder/resample/post_block.h"
#include "builder/resample/resample_projected.h"
#include "builder/resample/window_index.h"
#include "builder/voids/lattice_fill.h"
#include "cairn/mosaic_options.h"

namespace cairn {

/// Rasters on one grid in any CRS, mosaicked post by post: where they overlap the first that has a value
/// wins. The posts are fitted in blocks of half a tile's samples a side (their west and south edges, not the
/// others), each with a halo, so that every sample is one block's to decide and neighbouring tiles agree bit
/// for bit. Blocks are kept in a cache, as up to four tiles share one.
class ProjectedGroup final : public SourceGroup {
 public:
  struct Member {
    std::size_t source;  // in the pool
    GridPlacement placement;
  };
  /// A grid, and the rasters on it in the order in which they win.
  struct Grid {
    Georeference georeference;
    std::vector<Member> members;
  };

  /// The first level on which a surface through all posts exists.
  static int level_for(const RasterPool& pool, const Grid& grid, int tile_size);

  /// Smooth resampling keeps each post within an interval, any other method meets it, both within
  /// `tolerance_m`. `blocks` may be shared by groups of different numbers. REQUIRES: pool and geoid (may be
  /// null) outlive the group; native_level >= level_for().
  ProjectedGroup(RasterPool& pool, const Geoid* geoid, Grid grid, int native_level, int tile_size,
                 ResampleMethod method, double tolerance_m, std::shared_ptr<ChunkCache> blocks,
                 std::uint64_t number);

  void set_reach(double solid_degrees, double fade_degrees) override;
  NearestPlace nearest_within(const GeoBounds& area, double margin) const override;
  Result<MeasuredPosts> posts(const SampleWindow& window) const override;
  Result<GroupSamples> sample(const SampleWindow& window) const override;

 private:
  /// The samples that a block decides, as they lie in the cache: heights, then the states unless all are
  /// sourced; nothing where the block has no posts.
  struct Block {
    ChunkCache::Bytes bytes;
    std::size_t count = 0;

    bool is_empty() const { return bytes->empty(); }
    const float* heights() const { return reinterpret_cast<const float*>(bytes->data()); }
    const SampleState* states() const {
      const std::size_t heights_end = count * sizeof(float);
      return bytes->size() == heights_end ? nullptr
                                          : reinterpret_cast<const SampleState*>(bytes->data() + heights_end);
    }
  };

  Result<PostBlock> read_posts(IndexRange columns, IndexRange rows) const;
  Status read_member(std::size_t member, PostBlock& block) const;
  void add_geoid(PostBlock& block) const;
  std::vector<PlanePoint> shifts_of(const PostBlock& block) const;
  FitTolerance fit_tolerance() const;
  SampleWindow window_of_block(std::int64_t x, std::int64_t y) const;
  Result<Block> block_at(std::int64_t x, std::int64_t y) const;
  Result<ChunkCache::Chunk> make_block(const SampleWindow& window) const;
  ChunkCache::Chunk cut_out(const SampleWindow& window, const SamplePositions& positions,
                            const PostBlock& posts, std::span<const float> heights,
                            std::span<const std::uint8_t> met) const;
  void take_block(const SampleWindow& from, const Block& block, const SampleWindow& window,
                  GroupSamples& samples) const;
  Status add_void_depths(const SampleWindow& block, const SampleWindow& window,
                         std::vector<double>& depths) const;
  LonLat nearest_to(LonLat place, const std::vector<IndexWindow>& extents) const;
  Status add_posts(const SampleWindow& window, MeasuredPosts& posts) const;

  RasterPool& pool_;
  const Geoid* geoid_;
  Grid grid_;
  WindowIndex members_;
  std::int64_t block_side_;
  double samples_per_degree_;
  ResampleMethod method_;
  double tolerance_m_;      // of the fit
  double solid_posts_ = 1;  // see set_reach()
  double fade_posts_ = 0;
  bool is_shifted_ = false;  // some member's posts lie a little off the grid's
  ProjectedResampler resampler_;
  LatticeFill fill_;
  std::shared_ptr<ChunkCache> blocks_;
  std::uint64_t number_;
};

}  // namespace cairn
