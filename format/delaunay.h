#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace cairn {

/// A place on a grid. Coordinates stay below 2^28, so that whole numbers decide every test exactly.
struct GridPlace {
  std::int64_t column = 0;
  std::int64_t row = 0;
  friend bool operator==(const GridPlace&, const GridPlace&) = default;
};

/// Returns twice the area of the triangle: positive where the three turn left, 0 where they lie on a line.
std::int64_t doubled_area(const GridPlace& a, const GridPlace& b, const GridPlace& c);

/// A Delaunay triangulation that grows by one place at a time (Guibas & Stolfi 1985; Lawson 1977).
/// The triangle around a new place is split, then edges are flipped until every circumcircle is empty.
class Delaunay {
 public:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  struct Triangle {
    std::array<std::size_t, 3> vertices;    ///< anticlockwise
    std::array<std::size_t, 3> neighbours;  ///< beyond the edge from vertex i to the next; kNone outside
  };

  /// Two triangles over a rectangle.
  Delaunay(const GridPlace& south_west, const GridPlace& north_east);

  const std::vector<GridPlace>& places() const { return places_; }
  const std::vector<Triangle>& triangles() const { return triangles_; }
  /// Returns whether the place is in the triangle or on its edge.
  bool covers(std::size_t triangle, const GridPlace& place) const;

  /// Adds a place; returns the triangles that are new or have changed, ascending, each once. Those that were
  /// there before cover together what they cover now. REQUIRES: the triangle covers the place, which is no
  /// vertex yet.
  std::vector<std::size_t> insert(const GridPlace& place, std::size_t triangle);

 private:
  std::size_t edge_to(std::size_t triangle, std::size_t neighbour) const;
  void relink(std::size_t triangle, std::size_t before, std::size_t now);
  void split_inside(std::size_t triangle, std::size_t vertex);
  void split_edge(std::size_t triangle, std::size_t edge, std::size_t vertex);
  bool must_flip(std::size_t triangle, std::size_t edge) const;
  void flip(std::size_t triangle, std::size_t edge);
  void settle(std::size_t vertex);

  std::vector<GridPlace> places_;
  std::vector<Triangle> triangles_;
  std::vector<std::size_t> open_;  // whose edge opposite the new vertex is to be looked at
  std::vector<std::size_t> changed_;
};

}  // namespace cairn
