#include "runtime/lod/mesh/vertex_decimation.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include <glm/vec3.hpp>

namespace cairn {
namespace {

/// Stars over more cells, along the grid, stay: what takes a vertex out of them takes longer and saves less.
constexpr int kMostCells = 8;

/// Times the chord of a square of the hierarchy: of any triangles within a square as large anywhere. Beside
/// the level surface's, Σ wᵢwⱼ of all three pairs is 1/3 at most and their distance √2 times the square's
/// edge (0.47 instead of SquareErrors' 0.39), over heights of two neighbouring squares.
constexpr double kAnywhere = 2.5;

/// No radius of curvature is longer 20 km above the ellipsoid: a²/b at its poles, metres.
constexpr double kLongest_m = 6.42e6;

/// Cells that rounding may move a triangle's edge by.
constexpr double kRounding = 1e-6;

template <class Place>
int doubled_area(const Place& a, const Place& b, const Place& c) {
  return (b.column - a.column) * (c.row - a.row) - (b.row - a.row) * (c.column - a.column);
}

/// From where to where a triangle is in a row, in columns.
struct Reach {
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

void VertexDecimation::thin(const Surface& surface, LodTileMesh& mesh) {
  surface_ = &surface;
  find_places(mesh);
  const std::size_t triangles = mesh.triangles.size();
  last_corner_.assign(mesh.vertices.size(), kNone);
  corner_before_.resize(3 * triangles);
  for (std::size_t i = 0; i < triangles; ++i) link(mesh, i);
  Star star;
  for (auto i = static_cast<std::uint32_t>(mesh.vertices.size()); i-- > 0;) {
    if (!is_inside(places_[i]) || !find_star(mesh, i, star)) continue;
    star.box = box_of(star);
    if (star.box.cells() > kMostCells) continue;
    star.limit = limit_of(star);
    if (const auto apex = apex_for(star)) replace(star, *apex, mesh);
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

/// False where the triangles do not close around the vertex: at the rim of what is left out of the picture.
bool VertexDecimation::find_star(const LodTileMesh& mesh, std::uint32_t vertex, Star& star) const {
  std::array<std::array<std::uint32_t, 2>, kMostAround> edges;
  std::size_t count = 0;
  for (std::uint32_t corner = last_corner_[vertex]; corner != kNone; corner = corner_before_[corner]) {
    const LodTriangle& triangle = mesh.triangles[corner / 3];
    if (triangle[0] == kNone) continue;
    if (count == kMostAround) return false;
    edges[count] = {triangle[(corner + 1) % 3], triangle[(corner + 2) % 3]};
    star.triangles[count++] = corner / 3;
  }
  if (count < 3) return false;
  std::uint32_t at = edges[0][0];
  for (std::size_t i = 0; i < count; ++i) {
    star.around[i] = at;
    star.places[i] = places_[at];
    std::size_t next = 0;
    while (next < count && edges[next][0] != at) ++next;
    if (next == count) return false;
    at = edges[next][1];
  }
  star.middle = places_[vertex];
  star.count = count;
  return at == edges[0][0];
}

VertexDecimation::Box VertexDecimation::box_of(const Star& star) {
  const Place& m = star.middle;
  Box box{m.column, m.row, m.column, m.row};
  for (std::size_t i = 0; i < star.count; ++i) {
    const Place& p = star.places[i];
    box = {std::min(box.west, p.column), std::min(box.south, p.row), std::max(box.east, p.column),
           std::max(box.north, p.row)};
  }
  return box;
}

/// A sample that is off by no more than what is allowed is in a sphere around the star, larger by that.
/// Negative where the Earth's curvature alone may take too much.
double VertexDecimation::limit_of(const Star& star) const {
  const auto& [window, errors, quantum_m] = *surface_;
  const Place& m = star.middle;
  int cells2 = 0, rise = 0;
  for (std::size_t i = 0; i < star.count; ++i) {
    const int columns = star.places[i].column - m.column, rows = star.places[i].row - m.row;
    cells2 = std::max(cells2, columns * columns + rows * rows);
    rise = std::max(rise, std::abs(star.places[i].height - m.height));
  }
  const int k = std::min(static_cast<int>(std::bit_width(static_cast<unsigned>(star.box.cells() - 1))),
                         errors.levels());
  const double chord_m = kAnywhere * errors.chord_m(k);
  const double radius_m = std::sqrt(cells2) * errors.cell_radians() * kLongest_m + rise * quantum_m;
  const int column = m.column + window.column(), row = m.row + window.row();
  const glm::dvec3 place = errors.positions().at(column, row, m.height * quantum_m);
  const glm::dvec3 up = errors.positions().up_at(column, row);
  const auto allowed_m = [&](double radius) {
    return allowance_.error_m(allowance_.scale_of({place, radius}, up), 0, chord_m);
  };
  const double most_m = allowed_m(radius_m);
  return most_m < 0 ? most_m : allowed_m(radius_m + most_m + chord_m) / quantum_m;
}

/// Those whose fan is off least at the middle are tried first.
std::optional<std::size_t> VertexDecimation::apex_for(const Star& star) const {
  std::array<double, kMostAround> off;
  for (std::size_t i = 0; i < star.count; ++i) off[i] = off_at_middle(star, i);
  for (std::size_t tries = 0; tries < star.count; ++tries) {
    const auto least =
        static_cast<std::size_t>(std::min_element(off.data(), off.data() + star.count) - off.data());
    if (off[least] > star.limit) return std::nullopt;
    if (!any_is_off(star, least)) return least;
    off[least] = std::numeric_limits<double>::infinity();
  }
  return std::nullopt;
}

/// Infinite where the fan would not be one of anticlockwise triangles.
double VertexDecimation::off_at_middle(const Star& star, std::size_t apex) {
  const Place& m = star.middle;
  double off = 0;
  for (std::size_t i = 1; i + 1 < star.count; ++i) {
    const auto [a, b, c] = blade(star, apex, i);
    const int area = doubled_area(a, b, c);
    if (area <= 0) return std::numeric_limits<double>::infinity();
    const int of_a = doubled_area(m, b, c), of_b = doubled_area(a, m, c), of_c = area - of_a - of_b;
    if (of_a < 0 || of_b < 0 || of_c < 0) continue;
    const std::int64_t sum = std::int64_t{of_a} * (a.height - m.height) +
                             std::int64_t{of_b} * (b.height - m.height) +
                             std::int64_t{of_c} * (c.height - m.height);
    off = static_cast<double>(std::abs(sum)) / area;
  }
  return off;
}

bool VertexDecimation::any_is_off(const Star& star, std::size_t apex) const {
  for (std::size_t i = 1; i + 1 < star.count; ++i) {
    if (is_off(star, blade(star, apex, i))) return true;
  }
  return false;
}

/// The box's own rim has no samples but on edges that stay.
bool VertexDecimation::is_off(const Star& star, const Blade& blade) const {
  const auto& [a, b, c] = blade;
  const double area = doubled_area(a, b, c);
  const int to_a = a.height - c.height, to_b = b.height - c.height;
  const double by_column = (to_a * (b.row - c.row) - to_b * (a.row - c.row)) / area;
  const double by_row = (to_b * (a.column - c.column) - to_a * (b.column - c.column)) / area;
  const auto [south, north] = std::minmax({a.row, b.row, c.row});
  for (int row = std::max(south, star.box.south + 1); row <= std::min(north, star.box.north - 1); ++row) {
    Reach reach;
    reach.add_edge(a, b, row), reach.add_edge(b, c, row), reach.add_edge(c, a, row);
    const int first = std::max(static_cast<int>(reach.west + 1 - kRounding), star.box.west + 1);
    const int last = std::min(static_cast<int>(reach.east + kRounding), star.box.east - 1);
    double drawn = c.height + by_row * (row - c.row) + by_column * (first - c.column);
    for (int column = first; column <= last; ++column, drawn += by_column) {
      if (std::abs(surface_->window.quanta(column, row) - drawn) > star.limit) return true;
    }
  }
  return false;
}

void VertexDecimation::replace(const Star& star, std::size_t apex, LodTileMesh& mesh) {
  for (std::size_t i = 0; i < star.count; ++i) mesh.triangles[star.triangles[i]][0] = kNone;
  for (std::size_t i = 1; i + 1 < star.count; ++i) {
    const auto [b, c] = edge_of(star, apex, i);
    mesh.triangles.push_back({star.around[apex], star.around[b], star.around[c]});
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
