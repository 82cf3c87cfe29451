#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "builder/resample/index_window.h"
#include "builder/resample/post_block.h"
#include "builder/resample/window_index.h"
#include "builder/voids/fill_pyramid.h"
#include "cairn/status.h"

namespace cairn {

/// Gives every post of a lattice group a height, so that samples can be made of them: voids are filled
/// smoothly from their rims. Posts beyond all members, within reach, take the height of the nearest post of a
/// member, from which its slope goes on for eight posts: a plane is a plane there, too, and a cliff at the
/// edge goes no deeper.
///
/// Rasters that touch are filled as one. What is needed far from a void's rim is gathered in one pass over
/// such a cluster, the first time that a void is met. Safe to call from several threads.
class LatticeFill {
 public:
  using ReadPosts = std::function<Result<PostBlock>(IndexRange columns, IndexRange rows)>;

  /// `extents`: of the members; `read_posts`: the mosaic's posts, voids and all. `around`: posts around the
  /// Earth.
  LatticeFill(std::vector<IndexWindow> extents, std::int64_t around, ReadPosts read_posts);

  /// How many posts beyond its members the group is asked for, at most. Not while other threads call
  /// complete().
  void set_reach(std::int64_t posts) { reach_ = posts + kLeastReach; }

  /// Completes the heights of a block that has posts without a value.
  Status complete(PostBlock& block) const;

 private:
  struct Cluster {
    std::once_flag once;
    std::optional<Result<FillPyramid>> pyramid;  // set under `once`
  };

  Status fill_voids_of(std::size_t cluster, const IndexWindow& window, PostBlock& block) const;
  Result<FillPyramid> gather(const IndexWindow& extent) const;
  Status fill_voids_in(PostBlock& block) const;
  Status extend(PostBlock& block) const;

  struct Edge {
    IndexWindow member;
    PostBlock posts;
  };
  // How many posts an edge lies from a square, or from a post.
  struct NearEdge {
    std::int64_t distance = 0;
    std::size_t edge = 0;
    friend auto operator<=>(const NearEdge&, const NearEdge&) = default;
  };
  Result<std::vector<Edge>> edges_near(const IndexWindow& window) const;
  static void extend_square(const std::vector<Edge>& edges, const IndexWindow& square, PostBlock& block);
  static std::vector<NearEdge> by_distance(const std::vector<Edge>& edges, const IndexWindow& square);
  static float nearest_height(const std::vector<Edge>& edges, const std::vector<NearEdge>& near,
                              std::int64_t i, std::int64_t j);
  static float height_beyond(const Edge& edge, std::int64_t i, std::int64_t j);

  static constexpr std::int64_t kLeastReach = 64;  // posts: more than any sample's weights span
  std::int64_t reach_ = kLeastReach;

  std::int64_t around_;
  ReadPosts read_posts_;
  WindowIndex members_;
  WindowIndex hulls_;  // of clusters
  mutable std::vector<Cluster> clusters_;
};

}  // namespace cairn
