#include "builder/voids/lattice_fill.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "builder/voids/void_fill.h"

namespace cairn {
namespace {

constexpr std::int64_t kPassPosts = 1024;  // along a side of a block of the gathering pass
constexpr std::int64_t kSlopePosts = 8;    // beyond a member's edge over which its slope goes on
constexpr std::int64_t kSlopeOf = 2;       // posts behind the one at the edge that the slope comes from

IndexWindow window_of(const PostBlock& block) {
  return {{block.i0, block.i0 + block.columns - 1}, {block.j0, block.j0 + block.rows - 1}};
}

IndexWindow hull(const IndexWindow& a, const IndexWindow& b) {
  return {{std::min(a.x.first, b.x.first), std::max(a.x.last, b.x.last)},
          {std::min(a.y.first, b.y.first), std::max(a.y.last, b.y.last)}};
}

IndexWindow moved(IndexWindow w, std::int64_t columns) {
  w.x.first += columns;
  w.x.last += columns;
  return w;
}

IndexWindow grown(const IndexWindow& w, std::int64_t by) {
  return {{w.x.first - by, w.x.last + by}, {w.y.first - by, w.y.last + by}};
}

// Groups of extents that hang together, by number.
std::vector<std::vector<std::size_t>> connected(const WindowIndex& index) {
  std::vector<std::vector<std::size_t>> groups;
  std::vector<bool> seen(index.extents().size(), false);
  for (std::size_t start = 0; start < seen.size(); ++start) {
    if (seen[start]) continue;
    seen[start] = true;
    groups.push_back({start});
    for (std::size_t k = 0; k < groups.back().size(); ++k) {
      for (const std::size_t other : index.overlapping(grown(index.extents()[groups.back()[k]], 1))) {
        if (seen[other]) continue;
        seen[other] = true;
        groups.back().push_back(other);
      }
    }
  }
  return groups;
}

std::vector<IndexWindow> hulls_of(const WindowIndex& index) {
  std::vector<IndexWindow> hulls;
  for (const auto& group : connected(index)) {
    hulls.push_back(index.extents()[group.front()]);
    for (const std::size_t member : group) hulls.back() = hull(hulls.back(), index.extents()[member]);
  }
  return hulls;
}

IndexRange clamped(const IndexRange& range, const IndexRange& to) {
  return {std::clamp(range.first, to.first, to.last), std::clamp(range.last, to.first, to.last)};
}

std::int64_t apart(const IndexRange& a, const IndexRange& b) {
  return std::max({a.first - b.last, b.first - a.last, std::int64_t{0}});
}

std::int64_t beyond(std::int64_t at, const IndexRange& range) {
  return std::max({range.first - at, at - range.last, std::int64_t{0}});
}

// The smaller of two slopes, 0 where they differ in sign (the minmod limiter: Roe 1986): a plane goes on as a
// plane, and a cliff at the edge ends there.
float smaller_slope(float a, float b) {
  if (!(a * b > 0)) return 0;
  return std::abs(a) < std::abs(b) ? a : b;
}

// What the slope at the edge of `member` adds at column i (or row i), beyond it. `at(k)` is the height k
// posts inwards from the edge.
template <class HeightAt>
float slope_beyond(std::int64_t i, const IndexRange& member, const HeightAt& at) {
  const std::int64_t distance = beyond(i, member);
  if (distance == 0 || member.count() <= kSlopeOf) return 0;
  return smaller_slope(at(0) - at(1), at(1) - at(2)) * static_cast<float>(std::min(distance, kSlopePosts));
}

}  // namespace

LatticeFill::LatticeFill(std::vector<IndexWindow> extents, std::int64_t around, ReadPosts read_posts)
    : around_(around),
      read_posts_(std::move(read_posts)),
      members_(std::move(extents)),
      hulls_(hulls_of(members_)),
      clusters_(hulls_.extents().size()) {}

Result<FillPyramid> LatticeFill::gather(const IndexWindow& extent) const {
  FillPyramidBuilder builder(extent);
  for (std::int64_t y = extent.y.first; y <= extent.y.last; y += kPassPosts) {
    for (std::int64_t x = extent.x.first; x <= extent.x.last; x += kPassPosts) {
      const IndexWindow window{{x, std::min(x + kPassPosts - 1, extent.x.last)},
                               {y, std::min(y + kPassPosts - 1, extent.y.last)}};
      const auto block = read_posts_(window.x, window.y);
      if (!block) return block.error();
      builder.add(window, block->heights);
    }
  }
  return builder.complete();
}

// Fills the block's voids that lie in `window`, a part of the cluster as the block counts its posts.
Status LatticeFill::fill_voids_of(std::size_t number, const IndexWindow& window, PostBlock& block) const {
  Cluster& cluster = clusters_[number];
  std::call_once(cluster.once, [&] { cluster.pyramid = gather(hulls_.extents()[number]); });
  if (!cluster.pyramid->ok()) return cluster.pyramid->error();
  const FillPyramid& pyramid = **cluster.pyramid;
  if (pyramid.empty()) return {};
  const IndexWindow needed = posts_to_fill(window);
  const auto posts = read_posts_(needed.x, needed.y);
  if (!posts) return posts.error();
  std::vector<float> filled(static_cast<std::size_t>(window.count()));
  fill_voids(pyramid, posts->heights, window, filled);
  std::size_t at = 0;
  for (std::int64_t j = window.y.first; j <= window.y.last; ++j) {
    for (std::int64_t i = window.x.first; i <= window.x.last; ++i, ++at) {
      const std::size_t post = block.index(static_cast<int>(i - block.i0), static_cast<int>(j - block.j0));
      if (block.owners[post] == PostBlock::kVoid) block.heights[post] = filled[at];
    }
  }
  return {};
}

// The members that come within reach of the window, each with the posts of its that are nearest to the
// window's.
Result<std::vector<LatticeFill::Edge>> LatticeFill::edges_near(const IndexWindow& window) const {
  std::vector<Edge> edges;
  for (const auto& [number, turn] : members_.overlapping(grown(window, reach_ + 1), around_)) {
    const IndexWindow member = moved(members_.extents()[number], turn);
    const IndexWindow edge = grown({clamped(window.x, member.x), clamped(window.y, member.y)}, kSlopeOf);
    const IndexWindow nearest{clamped(edge.x, member.x), clamped(edge.y, member.y)};
    auto posts = read_posts_(nearest.x, nearest.y);
    if (!posts) return posts.error();
    if (auto status = fill_voids_in(*posts); !status) return status.error();
    edges.push_back({member, std::move(*posts)});
  }
  return edges;
}

// The height of the member's surface at post (i, j) outside it: that of the nearest post, from which the
// slope goes on for kSlopePosts. NaN where the nearest post has none.
float LatticeFill::height_beyond(const Edge& edge, std::int64_t i, std::int64_t j) {
  const std::int64_t column = std::clamp(i, edge.member.x.first, edge.member.x.last);
  const std::int64_t row = std::clamp(j, edge.member.y.first, edge.member.y.last);
  const std::int64_t inwards_x = i < column ? 1 : -1, inwards_y = j < row ? 1 : -1;
  const auto height_at = [&](std::int64_t c, std::int64_t r) {
    return edge.posts
        .heights[edge.posts.index(static_cast<int>(c - edge.posts.i0), static_cast<int>(r - edge.posts.j0))];
  };
  return height_at(column, row) +
         slope_beyond(i, edge.member.x, [&](int k) { return height_at(column + inwards_x * k, row); }) +
         slope_beyond(j, edge.member.y, [&](int k) { return height_at(column, row + inwards_y * k); });
}

// Posts that no member has take the height of the nearest member's surface there; those out of reach count
// for nothing, and get 0. Of members equally near the first counts. Done square by square: few members are
// near one.
Status LatticeFill::extend(PostBlock& block) const {
  constexpr int kSquare = 32;
  const auto edges = edges_near(window_of(block));
  if (!edges) return edges.error();
  for (int r = 0; r < block.rows; r += kSquare) {
    for (int c = 0; c < block.columns; c += kSquare) {
      const IndexWindow square{{block.i0 + c, block.i0 + std::min(c + kSquare, block.columns) - 1},
                               {block.j0 + r, block.j0 + std::min(r + kSquare, block.rows) - 1}};
      extend_square(*edges, square, block);
    }
  }
  return {};
}

void LatticeFill::extend_square(const std::vector<Edge>& edges, const IndexWindow& square, PostBlock& block) {
  std::vector<NearEdge> near;  // made for the first post that needs it
  for (std::int64_t j = square.y.first; j <= square.y.last; ++j) {
    for (std::int64_t i = square.x.first; i <= square.x.last; ++i) {
      float& height =
          block.heights[block.index(static_cast<int>(i - block.i0), static_cast<int>(j - block.j0))];
      if (!std::isnan(height)) continue;
      if (near.empty()) near = by_distance(edges, square);
      height = nearest_height(edges, near, i, j);
    }
  }
}

std::vector<LatticeFill::NearEdge> LatticeFill::by_distance(const std::vector<Edge>& edges,
                                                            const IndexWindow& square) {
  std::vector<NearEdge> near;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const IndexWindow& member = edges[e].member;
    near.push_back({std::max(apart(square.x, member.x), apart(square.y, member.y)), e});
  }
  std::sort(near.begin(), near.end());
  return near;
}

float LatticeFill::nearest_height(const std::vector<Edge>& edges, const std::vector<NearEdge>& near,
                                  std::int64_t i, std::int64_t j) {
  float height = 0;
  NearEdge nearest{INT64_MAX, 0};
  for (const NearEdge& candidate : near) {
    if (candidate.distance > nearest.distance) break;
    const Edge& edge = edges[candidate.edge];
    const NearEdge here{std::max(beyond(i, edge.member.x), beyond(j, edge.member.y)), candidate.edge};
    if (!(here < nearest)) continue;
    const float there = height_beyond(edge, i, j);
    if (std::isnan(there)) continue;
    nearest = here;
    height = there;
  }
  return height;
}

Status LatticeFill::fill_voids_in(PostBlock& block) const {
  if (std::find(block.owners.begin(), block.owners.end(), PostBlock::kVoid) == block.owners.end()) return {};
  const IndexWindow window = window_of(block);
  for (const auto& [number, turn] : hulls_.overlapping(window, around_)) {
    const IndexWindow extent = moved(hulls_.extents()[number], turn);
    const IndexWindow part{
        {std::max(window.x.first, extent.x.first), std::min(window.x.last, extent.x.last)},
        {std::max(window.y.first, extent.y.first), std::min(window.y.last, extent.y.last)}};
    if (auto status = fill_voids_of(number, part, block); !status) return status;
  }
  return {};
}

Status LatticeFill::complete(PostBlock& block) const {
  if (auto status = fill_voids_in(block); !status) return status;
  if (std::find(block.owners.begin(), block.owners.end(), PostBlock::kOutside) == block.owners.end())
    return {};
  return extend(block);
}

}  // namespace cairn
