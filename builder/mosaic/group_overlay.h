#pragma once

#include <span>
#include <vector>

#include "builder/mosaic/overlaid_samples.h"
#include "builder/mosaic/source_group.h"
#include "cairn/status.h"

namespace cairn {

/// Lays groups over one another.
///
/// Inside its footprint the upper group alone counts. Beyond its rim, where something lies beneath the rim,
/// its difference from that is carried outwards and fades, so that two groups that agree leave no step and
/// two that disagree a ramp. Where two groups touch without an overlap, the surface runs from one rim to the
/// other, and no post is lost. Near such lines the samples are then fitted to the posts that won
/// (PostEquations), which the groups by themselves do not know of one another.
///
/// Each group is overlaid on the samples of its own level; where a finer group makes finer tiles, it is
/// interpolated linearly from there. So a sample's height is a function of its place alone. Safe to call from
/// several threads.
class GroupOverlay {
 public:
  struct Layer {
    const SourceGroup* group = nullptr;
    int level = 0;  ///< on whose samples it is overlaid: its native level, or a finer one of a group beneath
    double samples_per_degree = 1;  ///< of that level
    double fade_degrees = 0;        ///< beyond its rim; 0 for a step

    /// Degrees beyond the footprint up to which it changes samples.
    double reach() const;
    /// Degrees from a window up to which it has to be known: the fit looks so far.
    double margin() const;
  };

  /// `layers`: the highest priority first; levels do not rise along them where they reach one another.
  /// `tolerance_m`: of the fit, see fit_borders().
  GroupOverlay(std::vector<Layer> layers, double tolerance_m)
      : layers_(std::move(layers)), tolerance_m_(tolerance_m) {}

  const std::vector<Layer>& layers() const { return layers_; }

  /// Those that change samples of the area, in ascending order.
  std::vector<std::size_t> reaching(const GeoBounds& bounds) const;

  /// Those from number `first` on, of at most this level, that samples of the area can depend on, in
  /// ascending order.
  std::vector<std::size_t> needed(const GeoBounds& bounds, int level, std::size_t first = 0) const;

  /// `layers`: those needed() for the window; not empty. REQUIRES: the window has the density of `level`.
  Result<OverlaidSamples> sample(std::span<const std::size_t> layers, const SampleWindow& window,
                                 int level) const;

 private:
  struct Rim;
  Result<GroupSamples> own_samples(std::size_t layer, const SampleWindow& window, int level) const;
  Result<OverlaidSamples> sample_alone(std::size_t layer, const SampleWindow& window, int level) const;
  Result<OverlaidSamples> overlay(std::span<const std::size_t> layers, const SampleWindow& window,
                                  int level) const;
  Result<std::vector<MeasuredPosts>> covered_posts(std::span<const std::size_t> layers,
                                                   const SampleWindow& window, int level) const;
  Result<Rim> rim_of(std::span<const std::size_t> layers, const SampleWindow& window, int level,
                     const GroupSamples& own, const OverlaidSamples& below) const;
  Status add_differences(std::span<const std::size_t> layers, const SampleWindow& window, int level,
                         Rim& rim) const;
  static void lay(const GroupSamples& own, const Rim& rim, OverlaidSamples& below);
  void drop_losing_posts(std::span<const std::size_t> layers, const SampleWindow& window, const Rim& rim,
                         OverlaidSamples& overlaid) const;

  std::vector<Layer> layers_;
  double tolerance_m_;
};

}  // namespace cairn
