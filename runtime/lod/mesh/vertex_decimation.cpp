#include "runtime/lod/mesh/vertex_decimation.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include <glm/vec3.hpp>

namespace cairn {
namespace {

/// Rings that span more cells are kept: to test them takes longer and saves fewer triangles.
constexpr int kMaxCells = 8;

/// Multiplied with SquareErrors::sagitta_m(), bounds the sagitta of any triangle within a square of that
/// size, wherever the square lies. Beside the level surface's part, Σ wᵢwⱼ over the three pairs is at most
/// 1/3, and their distance at most √2 times the square's edge: 0.47 instead of SquareErrors' 0.39. The
/// heights are those of two neighbouring squares of the hierarchy.
constexpr double kAnywhere = 2.5;

/// Bound of the radius of curvature up to 20 km above the ellipsoid: a²/b at the poles, in metres.
constexpr double kLongest_m = 6.42e6;

/// Bound of what rounding moves a triangle's edge by, in cells.
constexpr double kRounding = 1e-6;

template <class Place>
int doubled_area(const Place& a, const Place& b, const Place& c) {
  return (b.column - a.column) * (c.row - a.row) - (b.row - a.row) * (c.column - a.column);
}

/// The columns that a triangle covers in a row.
struct ColumnRange {
  double west = std::numeric_limits<double>::infinity();
  double east = -std::numeric_limits<double>::infinity();

  void add(double column) { west = std::min(west, column), east = std::max(east, column); }
  template <class Place>
  void add_edge(const Place& from, const Place& to, int row) {
    if (std::min(from.row, to.row) > row || std::max(from.row, to.row) < row) return;
    if (from.row == to.row) {
      add(from.column), add(to.column);
    } else {
      const int columns = (to.column - from.column) * (row - from.row);
      add(from.column + static_cast<double>(columns) / (to.row - from.row));
    }
  }
};

}  // namespace

void VertexDecimation::decimate(const Surface& surface, LodTileMesh& mesh) {
  surface_ = &surface;
  find_places(mesh);
  const std::size_t triangles = mesh.triangles.size();
  last_corner_.assign(mesh.vertices.size(), kNone);
  corner_before_.resize(3 * triangles);
  for (std::size_t i = 0; i < triangles; ++i) link(mesh, i);
  OneRing ring;
  for (auto i = static_cast<std::uint32_t>(mesh.vertices.size()); i-- > 0;) {
    if (!is_inside(places_[i]) || !find_one_ring(mesh, i, ring)) continue;
    ring.box = box_of(ring);
    if (ring.box.cells() > kMaxCells) continue;
    ring.limit = limit_of(ring);
    if (const auto apex = apex_for(ring)) replace(ring, *apex, mesh);
  }
  if (mesh.triangles.size() > triangles) drop_unused(mesh);
}

void VertexDecimation::find_places(const LodTileMesh& mesh) {
  const TileWindow& window = surface_->window;
  const LatticePoint corner = window.point(0, 0);
  places_.clear();
  for (const LodVertex& v : mesh.vertices) {
    const auto column = static_cast<int>((v.point.x - corner.x) / window.spacing());
    const auto row = static_cast<int>((v.point.y - corner.y) / window.spacing());
    places_.push_back({column, row, window.quanta(column, row)});
  }
}

void VertexDecimation::link(const LodTileMesh& mesh, std::size_t triangle) {
  for (std::size_t k = 0; k < 3; ++k) {
    std::uint32_t& last = last_corner_[mesh.triangles[triangle][k]];
    corner_before_[3 * triangle + k] = last;
    last = static_cast<std::uint32_t>(3 * triangle + k);
  }
}

bool VertexDecimation::is_inside(const Place& place) const {
  const int cells = surface_->window.cells();
  return place.column > 0 && place.row > 0 && place.column < cells && place.row < cells;
}

/// Returns false where the triangles do not close around the vertex: at the rim of squares that were culled.
bool VertexDecimation::find_one_ring(const LodTileMesh& mesh, std::uint32_t vertex, OneRing& ring) const {
  std::array<std::array<std::uint32_t, 2>, kMaxNeighbours> edges;
  std::size_t count = 0;
  for (std::uint32_t corner = last_corner_[vertex]; corner != kNone; corner = corner_before_[corner]) {
    const LodTriangle& triangle = mesh.triangles[corner / 3];
    if (triangle[0] == kNone) continue;
    if (count == kMaxNeighbours) return false;
    edges[count] = {triangle[(corner + 1) % 3], triangle[(corner + 2) % 3]};
    ring.triangles[count++] = corner / 3;
  }
  if (count < 3) return false;
  std::uint32_t at = edges[0][0];
  for (std::size_t i = 0; i < count; ++i) {
    ring.neighbours[i] = at;
    ring.places[i] = places_[at];
    std::size_t next = 0;
    while (next < count && edges[next][0] != at) ++next;
    if (next == count) return false;
    at = edges[next][1];
  }
  ring.centre = places_[vertex];
  ring.count = count;
  return at == edges[0][0];
}

VertexDecimation::Box VertexDecimation::box_of(const OneRing& ring) {
  const Place& m = ring.centre;
  Box box{m.column, m.row, m.column, m.row};
  for (std::size_t i = 0; i < ring.count; ++i) {
    const Place& p = ring.places[i];
    box = {std::min(box.west, p.column), std::min(box.south, p.row), std::max(box.east, p.column),
           std::max(box.north, p.row)};
  }
  return box;
}

/// Returns the allowed vertical error under the ring, in quanta; negative where the sagitta alone may exceed
/// the tolerance. Samples within that error lie in the ring's sphere enlarged by it, so it is computed twice.
double VertexDecimation::limit_of(const OneRing& ring) const {
  const auto& [window, errors, quantum_m] = *surface_;
  const Place& m = ring.centre;
  int cells2 = 0, rise = 0;
  for (std::size_t i = 0; i < ring.count; ++i) {
    const int columns = ring.places[i].column - m.column, rows = ring.places[i].row - m.row;
    cells2 = std::max(cells2, columns * columns + rows * rows);
    rise = std::max(rise, std::abs(ring.places[i].height - m.height));
  }
  const int k = std::min(static_cast<int>(std::bit_width(static_cast<unsigned>(ring.box.cells() - 1))),
                         errors.levels());
  const double sagitta_m = kAnywhere * errors.sagitta_m(k);
  const double radius_m = std::sqrt(cells2) * errors.cell_radians() * kLongest_m + rise * quantum_m;
  const int column = m.column + window.column(), row = m.row + window.row();
  const glm::dvec3 place = errors.positions().at(column, row, m.height * quantum_m);
  const glm::dvec3 up = errors.positions().up_at(column, row);
  const auto allowed_m = [&](double radius) {
    return budget_.error_m(budget_.scale_of({place, radius}, up), 0, sagitta_m);
  };
  const double most_m = allowed_m(radius_m);
  return most_m < 0 ? most_m : allowed_m(radius_m + most_m + sagitta_m) / quantum_m;
}

/// Returns the corner whose fan keeps the limit; fans that are closest to the centre vertex are tried first.
std::optional<std::size_t> VertexDecimation::apex_for(const OneRing& ring) const {
  std::array<double, kMaxNeighbours> distance;
  for (std::size_t i = 0; i < ring.count; ++i) distance[i] = distance_from_centre(ring, i);
  for (std::size_t tries = 0; tries < ring.count; ++tries) {
    const auto least = static_cast<std::size_t>(
        std::min_element(distance.data(), distance.data() + ring.count) - distance.data());
    if (distance[least] > ring.limit) return std::nullopt;
    if (!any_exceeds(ring, least)) return least;
    distance[least] = std::numeric_limits<double>::infinity();
  }
  return std::nullopt;
}

/// Returns infinity where the fan would have a triangle that is not anticlockwise.
double VertexDecimation::distance_from_centre(const OneRing& ring, std::size_t apex) {
  const Place& m = ring.centre;
  double distance = 0;
  for (std::size_t i = 1; i + 1 < ring.count; ++i) {
    const auto [a, b, c] = fan_triangle(ring, apex, i);
    const int area = doubled_area(a, b, c);
    if (area <= 0) return std::numeric_limits<double>::infinity();
    const int of_a = doubled_area(m, b, c), of_b = doubled_area(a, m, c), of_c = area - of_a - of_b;
    if (of_a < 0 || of_b < 0 || of_c < 0) continue;
    const std::int64_t sum = std::int64_t{of_a} * (a.height - m.height) +
                             std::int64_t{of_b} * (b.height - m.height) +
                             std::int64_t{of_c} * (c.height - m.height);
    distance = static_cast<double>(std::abs(sum)) / area;
  }
  return distance;
}

bool VertexDecimation::any_exceeds(const OneRing& ring, std::size_t apex) const {
  for (std::size_t i = 1; i + 1 < ring.count; ++i) {
    if (exceeds(ring, fan_triangle(ring, apex, i))) return true;
  }
  return false;
}

/// Skips the rim of the ring's box: samples there lie on edges that the mesh keeps.
bool VertexDecimation::exceeds(const OneRing& ring, const FanTriangle& triangle) const {
  const auto& [a, b, c] = triangle;
  const double area = doubled_area(a, b, c);
  const int to_a = a.height - c.height, to_b = b.height - c.height;
  const double by_column = (to_a * (b.row - c.row) - to_b * (a.row - c.row)) / area;
  const double by_row = (to_b * (a.column - c.column) - to_a * (b.column - c.column)) / area;
  const auto [south, north] = std::minmax({a.row, b.row, c.row});
  for (int row = std::max(south, ring.box.south + 1); row <= std::min(north, ring.box.north - 1); ++row) {
    ColumnRange range;
    range.add_edge(a, b, row), range.add_edge(b, c, row), range.add_edge(c, a, row);
    const int first = std::max(static_cast<int>(range.west + 1 - kRounding), ring.box.west + 1);
    const int last = std::min(static_cast<int>(range.east + kRounding), ring.box.east - 1);
    double drawn = c.height + by_row * (row - c.row) + by_column * (first - c.column);
    for (int column = first; column <= last; ++column, drawn += by_column) {
      if (std::abs(surface_->window.quanta(column, row) - drawn) > ring.limit) return true;
    }
  }
  return false;
}

void VertexDecimation::replace(const OneRing& ring, std::size_t apex, LodTileMesh& mesh) {
  for (std::size_t i = 0; i < ring.count; ++i) mesh.triangles[ring.triangles[i]][0] = kNone;
  for (std::size_t i = 1; i + 1 < ring.count; ++i) {
    const auto [b, c] = edge_of(ring, apex, i);
    mesh.triangles.push_back({ring.neighbours[apex], ring.neighbours[b], ring.neighbours[c]});
    corner_before_.resize(3 * mesh.triangles.size());
    link(mesh, mesh.triangles.size() - 1);
  }
}

void VertexDecimation::drop_unused(LodTileMesh& mesh) {
  std::erase_if(mesh.triangles, [](const LodTriangle& t) { return t[0] == kNone; });
  std::vector<std::uint32_t> numbers(mesh.vertices.size(), kNone);
  for (const LodTriangle& triangle : mesh.triangles) {
    for (const std::uint32_t v : triangle) numbers[v] = 0;
  }
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (numbers[i] == kNone) continue;
    mesh.vertices[count] = mesh.vertices[i];
    numbers[i] = count++;
  }
  mesh.vertices.resize(count);
  for (LodTriangle& triangle : mesh.triangles) {
    for (std::uint32_t& v : triangle) v = numbers[v];
  }
}

}  // namespace cairn
