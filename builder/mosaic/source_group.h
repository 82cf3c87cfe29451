#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "builder/mosaic/sample_window.h"
#include "builder/raster/footprint.h"
#include "builder/resample/smooth_tolerance.h"
#include "cairn/status.h"

namespace cairn {

/// Posts to measure a surface against. x and y count samples from the window's south-west corner.
struct MeasuredPosts {
  /// Posts of a lattice: heights[row · xs.size() + column] lies at (xs[column], ys[row]); NaN where there is
  /// none.
  std::vector<double> xs;
  std::vector<double> ys;
  std::vector<float> heights;
  std::vector<std::uint16_t> owners;  ///< which source gave it, see PostBlock; by place as `heights`

  /// Posts of a projected raster.
  struct Placed {
    double x = 0;
    double y = 0;
    float height = 0;
    std::uint16_t owner = 0;
  };
  std::vector<Placed> placed;
  std::vector<Placed> lost;  ///< those that lost to a group above; of a lattice they have NaN and an owner
};

/// What a group of sources says about a window of samples.
struct GroupSamples {
  std::vector<float> heights;       ///< metres, rows south to north; NaN only where the state is none
  std::vector<SampleState> states;  ///< empty where all are sourced
  /// How much a filled sample's height counts against what lies beneath the group: 1 beside the rim of the
  /// void, 0 farther in than the group fades. Empty where no sample is filled, or nothing lies beneath.
  std::vector<float> fill_weights;
  MeasuredPosts posts;  ///< in the closed window
};

/// The place in an area that is nearest to a place, by the larger of the two axes' distances; itself inside.
using NearestPlace = std::function<LonLat(LonLat)>;

/// Sources that are resampled together: rasters on one lattice, or one projected raster. Sampling is a pure
/// function of the world's sample grid: windows that share a sample give it the same bits. Safe to call from
/// several threads.
class SourceGroup {
 public:
  virtual ~SourceGroup() = default;

  /// The level whose samples are as dense as the posts: where the group is sampled.
  int native_level() const { return native_level_; }
  /// Degrees between posts, the larger of both axes.
  double spacing_degrees() const { return spacing_degrees_; }
  /// Samples for each post along an axis, the lesser of both axes.
  double samples_per_post() const { return samples_per_post_; }
  /// Whether every post lies on a sample.
  bool posts_on_samples() const { return posts_on_samples_; }
  const Footprint& footprint() const { return footprint_; }
  /// The members' numbers in the RasterPool, by the order in which they win.
  const std::vector<std::size_t>& sources() const { return sources_; }

  /// How the group ends inside its voids, in degrees: so far from their rims it counts alone, and so much
  /// farther it fades into what lies beneath (0 where nothing does). Before any sample() only.
  virtual void set_reach(double solid_degrees, double fade_degrees) = 0;
  /// How far from posts with a value voids are filled, in posts, 256 at most; farther in, samples have no
  /// source. By default they are filled whatever their distance. Before any sample() only.
  void set_void_distance(double posts) { void_posts_ = posts; }
  /// How smooth resampling keeps the posts. Before any sample() only.
  void set_tolerance(const SmoothTolerance& tolerance) { tolerance_ = tolerance; }
  const SmoothTolerance& tolerance() const { return tolerance_; }

  /// Whether the footprint comes within `margin` degrees of the area. Posts of a projected group are equally
  /// far apart on the ground: towards a pole its margin takes in more degrees of longitude.
  bool comes_within(const GeoBounds& area, double margin) const {
    return footprint_.overlaps(is_projected_ ? widened(area, margin) : area, margin);
  }

  /// The nearest place in the area of the group's posts, for places in `bounds` grown by `margin` degrees
  /// that are no farther than that from it; for others any place farther away. It refers to the group.
  virtual NearestPlace nearest_within(const GeoBounds& bounds, double margin) const {
    return [near = footprint_.near(bounds, 2 * margin)](LonLat place) { return near.nearest_to(place); };
  }

  /// The posts in the closed window alone, without samples. REQUIRES: as sample().
  virtual Result<MeasuredPosts> posts(const SampleWindow& window) const = 0;

  /// REQUIRES: the window has the native level's density.
  virtual Result<GroupSamples> sample(const SampleWindow& window) const = 0;

 protected:
  /// The area, so much wider that `margin` degrees beyond it are as wide on the ground as they are high.
  static GeoBounds widened(GeoBounds area, double margin);

  bool is_projected_ = false;
  int native_level_ = 0;
  double spacing_degrees_ = 0;
  double samples_per_post_ = 1;
  bool posts_on_samples_ = false;
  Footprint footprint_;
  std::vector<std::size_t> sources_;
  SmoothTolerance tolerance_;
  std::optional<double> void_posts_;
};

}  // namespace cairn
