#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <queue>
#include <span>
#include <vector>

#include "builder/export/grid_index.h"
#include "builder/export/height_samples.h"
#include "format/delaunay.h"

namespace cairn {

/// A triangle mesh over a rectangle that grows by the sample that it is farthest from (Garland & Heckbert
/// 1995, "Fast polygonal approximation of terrains and height fields", algorithm III). Triangles are
/// Delaunay.
class GreedyMesh {
 public:
  enum class Border {
    given,    ///< only add() puts vertices on it
    refined,  ///< it grows like the rest
  };

  /// The height that a vertex at a sample gets, which may be rounded.
  using VertexHeight = std::function<double(const HeightSamples& grid, int column, int row)>;

  /// The rectangle from (0, 0) on with these heights at its south-western, south-eastern, north-eastern and
  /// north-western corner. REQUIRES: the samples outlive the mesh.
  GreedyMesh(const GridPlace& north_east, const std::array<double, 4>& corners,
             std::span<const HeightSamples> samples, Border border, VertexHeight vertex_height);

  /// Adds a vertex; nothing happens where there is one.
  void add(const GridPlace& place, double metres);

  /// Adds samples until none is farther from the mesh than this. Returns false where it stopped before, at so
  /// many vertices.
  bool refine(double tolerance_m, std::size_t most_vertices = SIZE_MAX);

  const std::vector<GridPlace>& places() const { return net_.places(); }
  const std::vector<double>& heights() const { return heights_; }
  const std::vector<Delaunay::Triangle>& triangles() const { return net_.triangles(); }

 private:
  struct Worst {
    double error_m = 0;
    std::uint32_t version = 0;
    std::uint32_t grid = 0;
    int column = 0;
    int row = 0;
    bool measured = false;
  };
  struct Entry {
    double error_m;
    std::size_t triangle;
    std::uint32_t version;
    /// By error, then by number, so that the order does not depend on the library.
    bool operator<(const Entry& other) const {
      return error_m != other.error_m ? error_m < other.error_m : triangle > other.triangle;
    }
  };

  std::size_t triangle_at(const GridPlace& place);
  void insert(const GridPlace& place, double metres, std::size_t triangle);
  void measure(std::size_t triangle);
  void scan(std::size_t triangle, std::uint32_t grid, Worst& worst) const;

  std::int64_t margin_;  // samples nearer to the border do not become vertices
  GridPlace north_east_;
  std::span<const HeightSamples> samples_;
  GridIndex index_;
  VertexHeight vertex_height_;
  Delaunay net_;
  std::vector<double> heights_;
  std::vector<Worst> worst_;
  std::vector<std::size_t> unmeasured_;
  std::priority_queue<Entry> queue_;
  std::size_t last_ = 0;  // where the search for a triangle begins
};

}  // namespace cairn
