#include "runtime/surface/rim_wall.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace cairn::gl {
namespace {

/// The vertices strictly between two ends of polylines at one place, from `from` to `to`.
std::vector<RimVertex> between(const RimVertex& from, const RimVertex& to, std::span<const float> heights) {
  const float begin = from.vertex.at.height_m, end = to.vertex.at.height_m;
  std::vector<RimVertex> way;
  for (const float height : heights) {
    if (height <= std::min(begin, end) || height >= std::max(begin, end)) continue;
    way.push_back(from);
    way.back().vertex.at.height_m = height;
  }
  if (begin > end) std::reverse(way.begin(), way.end());
  return way;
}

bool is_same_place(const RimVertex& a, const RimVertex& b) {
  return a.along == b.along && a.vertex.at.height_m == b.vertex.at.height_m;
}

}  // namespace

void append_wall(std::span<const RimVertex> a, std::span<const RimVertex> b, std::span<const float> at_first,
                 std::span<const float> at_last, MeshPlan& plan) {
  // The second polyline goes from the first one's beginning to its end.
  std::vector<RimVertex> around = between(a.front(), b.front(), at_first);
  around.insert(around.end(), b.begin(), b.end());
  const std::vector<RimVertex> back = between(b.back(), a.back(), at_last);
  around.insert(around.end(), back.begin(), back.end());

  const auto first_of_a = static_cast<std::uint32_t>(plan.wall_vertices.size());
  const auto first_of_b = static_cast<std::uint32_t>(first_of_a + a.size());
  for (const RimVertex& vertex : a) plan.wall_vertices.push_back(vertex.vertex);
  for (const RimVertex& vertex : around) plan.wall_vertices.push_back(vertex.vertex);
  const auto append = [&](std::size_t i, std::size_t j, bool of_a) {
    const RimVertex& third = of_a ? a[i + 1] : around[j + 1];
    const bool has_area =
        !is_same_place(a[i], around[j]) && !is_same_place(a[i], third) && !is_same_place(around[j], third);
    const bool is_void = std::isnan(a[i].vertex.at.height_m) || std::isnan(around[j].vertex.at.height_m) ||
                         std::isnan(third.vertex.at.height_m);
    if (!has_area || is_void) return;
    const std::size_t last = of_a ? first_of_a + i + 1 : first_of_b + j + 1;
    plan.wall_triangles.push_back({static_cast<std::uint32_t>(first_of_a + i),
                                   static_cast<std::uint32_t>(first_of_b + j),
                                   static_cast<std::uint32_t>(last)});
  };
  for (std::size_t i = 0, j = 0; i + 1 < a.size() || j + 1 < around.size();) {
    const bool of_a = i + 1 < a.size() && (j + 1 == around.size() || a[i + 1].along < around[j + 1].along);
    append(i, j, of_a);
    of_a ? ++i : ++j;
  }
}

}  // namespace cairn::gl
