#include "runtime/lod/mesh/rim_ribbons.h"

#include <algorithm>
#include <cstddef>

namespace cairn {
namespace {

std::int64_t along(bool upright, const LodVertex& vertex) {
  return upright ? vertex.point.y : vertex.point.x;
}

/// The vertices of one side of a line, and where nothing lies between one and the next.
struct Chain {
  std::vector<LodVertex> vertices;
  std::vector<char> is_gap_after;

  bool has_edge(std::size_t from, std::size_t to) const {
    return std::any_of(is_gap_after.begin() + static_cast<std::ptrdiff_t>(from),
                       is_gap_after.begin() + static_cast<std::ptrdiff_t>(to),
                       [](char gap) { return gap == 0; });
  }
};

template <class Piece>
Chain chain_of(std::vector<Piece>& pieces) {
  std::sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) { return a.from < b.from; });
  Chain chain;
  for (const Piece& piece : pieces) {
    const bool goes_on = !chain.vertices.empty() && chain.vertices.back() == piece.vertices.front();
    for (std::size_t i = goes_on ? 1 : 0; i < piece.vertices.size(); ++i) {
      if (!chain.vertices.empty()) chain.is_gap_after.push_back(i == 0 ? 1 : 0);
      chain.vertices.push_back(piece.vertices[i]);
    }
  }
  chain.is_gap_after.push_back(1);
  return chain;
}

/// Appends the triangles between two chains that have only their ends in common.
void zip(bool upright, std::span<const LodVertex> a, std::span<const LodVertex> b, LodTileMesh& walls) {
  const auto first = static_cast<std::uint32_t>(walls.vertices.size());
  walls.vertices.insert(walls.vertices.end(), a.begin(), a.end());
  walls.vertices.insert(walls.vertices.end(), b.begin() + 1, b.end() - 1);
  const auto number_a = [&](std::size_t i) { return first + static_cast<std::uint32_t>(i); };
  const auto number_b = [&](std::size_t j) {
    if (j == 0) return number_a(0);
    return j + 1 == b.size() ? number_a(a.size() - 1) : number_a(a.size() + j - 1);
  };
  std::size_t i = 0, j = 0;
  while (i + 1 < a.size() || j + 1 < b.size()) {
    const bool takes_a =
        j + 1 == b.size() || (i + 1 < a.size() && along(upright, a[i + 1]) <= along(upright, b[j + 1]));
    const LodTriangle made{number_a(i), number_b(j), takes_a ? number_a(i + 1) : number_b(j + 1)};
    if (made[0] != made[1] && made[1] != made[2] && made[0] != made[2]) walls.triangles.push_back(made);
    takes_a ? ++i : ++j;
  }
}

}  // namespace

void RimRibbons::add(bool upright, Side side, std::span<const LodVertex> vertices) {
  const LatticePoint at = canonical(vertices.front().point);
  lines_[{upright, upright ? at.x : at.y}][side].push_back(
      {along(upright, vertices.front()), {vertices.begin(), vertices.end()}});
}

void RimRibbons::append_to(LodTileMesh& walls) {
  for (auto& [line, sides] : lines_) {
    const bool upright = line.first;
    if (sides[below].empty() || sides[above].empty()) continue;
    const Chain a = chain_of(sides[below]), b = chain_of(sides[above]);
    std::size_t i = 0, j = 0, from_a = 0, from_b = 0;
    bool begun = false;
    while (i < a.vertices.size() && j < b.vertices.size()) {
      const std::int64_t at_a = along(upright, a.vertices[i]), at_b = along(upright, b.vertices[j]);
      if (at_a != at_b) {
        ++(at_a < at_b ? i : j);
        continue;
      }
      const bool alike = i - from_a == 1 && j - from_b == 1;
      if (begun && !alike && a.has_edge(from_a, i) && b.has_edge(from_b, j)) {
        zip(upright, std::span(a.vertices).subspan(from_a, i - from_a + 1),
            std::span(b.vertices).subspan(from_b, j - from_b + 1), walls);
      }
      begun = true;
      from_a = i++, from_b = j++;
    }
  }
}

}  // namespace cairn
