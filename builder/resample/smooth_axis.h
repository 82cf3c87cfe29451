#pragma once

#include <cstdint>
#include <vector>

#include "builder/resample/axis_weights.h"

namespace cairn {

/// What smooth resampling needs of one axis for a range of samples. All of it depends on the axis and on each
/// sample's absolute index only, so any two ranges agree where they overlap.
struct SmoothAxis {
  /// Samples and posts that correct one another and no others: a run, or a post that lies on a sample, or a
  /// sample that touches no post.
  struct Group {
    IndexRange samples;
    IndexRange posts;  ///< empty for a sample that touches none
  };

  /// REQUIRES: at least 1.032 samples per post, or every post on a sample; samples not empty.
  SmoothAxis(const AxisPositions& positions, IndexRange wanted);

  IndexRange samples;    ///< of whole groups, the wanted ones among them
  IndexRange corrected;  ///< the posts of these groups; empty where there are none
  IndexRange smoothed;   ///< the posts whose smoothed heights are used
  IndexRange posts;      ///< all posts that the samples depend on
  std::vector<Group> groups;

  AxisWeights guess;           ///< samples from smoothed posts
  AxisWeights guess_at_posts;  ///< the surface of these samples at the corrected posts, from smoothed posts
  AxisWeights correction;      ///< samples from what is missing at corrected posts; a row may be empty
  std::vector<IndexRange> cells;  ///< by sample: the post that it lies on, or the posts to both sides

  /// By post of `posts`: whether it lies on a sample. Nothing passes across such a post's line: it depends on
  /// its own posts alone.
  std::vector<std::uint8_t> pinned;

  std::vector<std::int64_t> interval;  ///< by corrected post: the sample at or before it
  std::vector<double> fraction;        ///< by corrected post: how far past that sample it lies, 0 ≤ … < 1

  const AxisWeights::Row& guess_row(std::int64_t sample) const { return row(guess, sample - samples.first); }
  const AxisWeights::Row& correction_row(std::int64_t sample) const {
    return row(correction, sample - samples.first);
  }
  const AxisWeights::Row& post_row(std::int64_t post) const {
    return row(guess_at_posts, post - corrected.first);
  }
  IndexRange cell(std::int64_t sample) const {
    return cells[static_cast<std::size_t>(sample - samples.first)];
  }
  /// The posts that the smoothed heights of these depend on. REQUIRES: `of` within `smoothed`, not empty.
  IndexRange posts_around(IndexRange of) const;
  bool is_pinned(std::int64_t post) const {
    return pinned[static_cast<std::size_t>(post - posts.first)] != 0;
  }

 private:
  static const AxisWeights::Row& row(const AxisWeights& weights, std::int64_t k) {
    return weights.rows[static_cast<std::size_t>(k)];
  }
  void add_group(const AxisPositions& positions, std::int64_t sample);
  void add_surface_at(const AxisPositions& positions, std::int64_t post);
  void find_posts(const AxisPositions& positions);
};

}  // namespace cairn
