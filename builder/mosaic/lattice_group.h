#pragma once

#include <optional>
#include <span>
#include <vector>

#include "builder/mosaic/geoid.h"
#include "builder/mosaic/lattice.h"
#include "builder/mosaic/source_group.h"
#include "builder/raster/raster_pool.h"
#include "builder/resample/axis_positions.h"
#include "builder/resample/axis_resampler.h"
#include "builder/resample/post_block.h"
#include "builder/resample/resample_lattice.h"
#include "builder/resample/smooth_lattice.h"
#include "builder/resample/window_index.h"
#include "builder/voids/lattice_fill.h"

namespace cairn {

/// Rasters whose posts lie on one lat/long lattice, mosaicked post by post: the first member that has a value
/// wins.
class LatticeGroup final : public SourceGroup {
 public:
  struct Member {
    std::size_t source = 0;  ///< in the pool
    LatticePlacement placement;
  };

  /// REQUIRES: all members on `lattice`, at most 65533 of them; pool and geoid (may be null) outlive the
  /// group; the method is well conditioned at this density.
  LatticeGroup(RasterPool& pool, const Geoid* geoid, const Lattice& lattice, std::vector<Member> members,
               int native_level, double samples_per_degree, ResampleMethod method);

  void set_reach(double solid_degrees, double fade_degrees) override;
  NearestPlace nearest_within(const GeoBounds& bounds, double margin) const override;
  Result<MeasuredPosts> posts(const SampleWindow& window) const override;
  Result<GroupSamples> sample(const SampleWindow& window) const override;

  /// The mosaic's posts before voids are filled, wrapped around the Earth.
  Result<PostBlock> read_posts(IndexRange columns, IndexRange rows) const;

 private:
  IndexWindow posts_for(IndexRange columns, IndexRange rows) const;
  void resample(const IndexWindow& from, std::span<const float> posts, const IndexWindow& samples,
                std::span<float> out) const;
  Status read_member(std::size_t member, std::int64_t turn, PostBlock& block) const;
  std::vector<SampleState> states_of(const SampleWindow& window, const PostBlock& block) const;
  Result<std::vector<double>> void_depths(const SampleWindow& window) const;
  MeasuredPosts posts_of(const SampleWindow& window, PostBlock&& block) const;

  RasterPool& pool_;
  const Geoid* geoid_;
  Lattice lattice_;
  std::vector<Member> members_;
  AxisResampler lon_;
  AxisResampler lat_;
  AxisPositions lon_positions_;
  AxisPositions lat_positions_;
  ResampleMethod method_;
  std::int64_t
      around_;  ///< posts around the Earth; so many that nothing wraps where 360 degrees are no whole number
  WindowIndex index_;  ///< of the members
  LatticeFill fill_;
  Footprint area_;          ///< the footprint, and what lies between members that touch
  double solid_posts_ = 1;  ///< see set_reach()
  double fade_posts_ = 0;
};

}  // namespace cairn
