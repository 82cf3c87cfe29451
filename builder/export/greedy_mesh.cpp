#include "builder/export/greedy_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace cairn {
namespace {

std::int64_t floor_div(std::int64_t a, std::int64_t b) {
  return a / b - (a % b != 0 && (a < 0) != (b < 0) ? 1 : 0);
}
std::int64_t ceil_div(std::int64_t a, std::int64_t b) {
  return -floor_div(-a, b);
}

/// The columns of a row that lie in a triangle, edges included; empty where first > last.
struct RowSpan {
  std::int64_t first;
  std::int64_t last;
};
RowSpan row_span(const std::array<GridPlace, 3>& corners, std::int64_t row, std::int64_t origin,
                 std::int64_t step) {
  std::int64_t first = INT64_MAX, last = INT64_MIN;
  for (std::size_t i = 0; i < 3; ++i) {
    const GridPlace &a = corners[i], &b = corners[(i + 1) % 3];
    const auto [low, high] = std::minmax(a.row, b.row);
    if (row < low || row > high) continue;
    if (a.row == b.row) {
      const auto [west, east] = std::minmax(a.column, b.column);
      first = std::min(first, ceil_div(west - origin, step));
      last = std::max(last, floor_div(east - origin, step));
      continue;
    }
    // Where the edge crosses the row: a.column + (b.column - a.column)·(row - a.row) / (b.row - a.row).
    const std::int64_t sign = b.row > a.row ? 1 : -1;
    const std::int64_t whole =
        sign * ((a.column - origin) * (b.row - a.row) + (b.column - a.column) * (row - a.row));
    const std::int64_t divisor = sign * (b.row - a.row) * step;
    first = std::min(first, ceil_div(whole, divisor));
    last = std::max(last, floor_div(whole, divisor));
  }
  return {first, last};
}

}  // namespace

GreedyMesh::GreedyMesh(const GridPlace& north_east, const std::array<double, 4>& corners,
                       std::span<const HeightSamples> samples, Border border, VertexHeight vertex_height)
    : margin_(border == Border::given ? 1 : 0),
      north_east_(north_east),
      samples_(samples),
      index_(samples, std::max(north_east.column, north_east.row)),
      vertex_height_(std::move(vertex_height)),
      net_({0, 0}, north_east),
      heights_(corners.begin(), corners.end()),
      worst_(2),
      unmeasured_{0, 1} {}

void GreedyMesh::add(const GridPlace& place, double metres) {
  const std::size_t triangle = triangle_at(place);
  for (const std::size_t v : net_.triangles()[triangle].vertices)
    if (net_.places()[v] == place) return;
  insert(place, metres, triangle);
}

// Walks towards the place. Ends, since the triangulation is Delaunay (Devillers, Pion & Teillaud 2002).
std::size_t GreedyMesh::triangle_at(const GridPlace& place) {
  std::size_t at = last_;
  for (;;) {
    const Delaunay::Triangle& triangle = net_.triangles()[at];
    std::size_t next = Delaunay::kNone;
    for (std::size_t i = 0; i < 3; ++i) {
      const GridPlace &a = net_.places()[triangle.vertices[i]],
                      &b = net_.places()[triangle.vertices[(i + 1) % 3]];
      if (doubled_area(a, b, place) < 0) {
        next = triangle.neighbours[i];
        break;
      }
    }
    if (next == Delaunay::kNone) return last_ = at;
    at = next;
  }
}

void GreedyMesh::insert(const GridPlace& place, double metres, std::size_t triangle) {
  const std::vector<std::size_t> changed = net_.insert(place, triangle);
  heights_.push_back(metres);
  worst_.resize(net_.triangles().size());
  last_ = changed.back();
  for (const std::size_t t : changed) {
    ++worst_[t].version;
    if (std::exchange(worst_[t].measured, false) || worst_[t].version == 1) unmeasured_.push_back(t);
  }
}

bool GreedyMesh::refine(double tolerance_m, std::size_t most_vertices) {
  for (;;) {
    for (const std::size_t t : std::exchange(unmeasured_, {}))
      if (!worst_[t].measured) measure(t);
    while (!queue_.empty() && worst_[queue_.top().triangle].version != queue_.top().version) queue_.pop();
    if (queue_.empty() || queue_.top().error_m <= tolerance_m) return true;
    if (net_.places().size() >= most_vertices) return false;
    const std::size_t triangle = queue_.top().triangle;
    queue_.pop();
    const Worst worst = worst_[triangle];
    const HeightSamples& grid = samples_[worst.grid];
    insert(grid.place(worst.column, worst.row), vertex_height_(grid, worst.column, worst.row), triangle);
  }
}

void GreedyMesh::measure(std::size_t triangle) {
  Worst worst = worst_[triangle];
  worst.error_m = 0;
  worst.measured = true;
  std::array<double, 3> columns{}, rows{};
  for (std::size_t i = 0; i < 3; ++i) {
    const GridPlace& corner = net_.places()[net_.triangles()[triangle].vertices[i]];
    columns[i] = static_cast<double>(corner.column);
    rows[i] = static_cast<double>(corner.row);
  }
  const auto [west, east] = std::minmax_element(columns.begin(), columns.end());
  const auto [south, north] = std::minmax_element(rows.begin(), rows.end());
  for (const std::uint32_t grid : index_.over(*west, *south, *east, *north)) scan(triangle, grid, worst);
  worst_[triangle] = worst;
  if (worst.error_m > 0) queue_.push({worst.error_m, triangle, worst.version});
}

void GreedyMesh::scan(std::size_t triangle, std::uint32_t number, Worst& worst) const {
  const HeightSamples& grid = samples_[number];
  const auto& v = net_.triangles()[triangle].vertices;
  const std::array<GridPlace, 3> corners{net_.places()[v[0]], net_.places()[v[1]], net_.places()[v[2]]};
  const auto [south, north] = std::minmax({corners[0].row, corners[1].row, corners[2].row});
  const std::int64_t first_row = std::max<std::int64_t>(0, ceil_div(south - grid.row, grid.step));
  const std::int64_t last_row = std::min<std::int64_t>(grid.rows - 1, floor_div(north - grid.row, grid.step));
  if (first_row > last_row) return;
  // The plane, from the first corner on.
  const double area = static_cast<double>(doubled_area(corners[0], corners[1], corners[2]));
  const double rise_1 = heights_[v[1]] - heights_[v[0]], rise_2 = heights_[v[2]] - heights_[v[0]];
  const auto column_of = [&](std::size_t i) {
    return static_cast<double>(corners[i].column - corners[0].column);
  };
  const auto row_of = [&](std::size_t i) { return static_cast<double>(corners[i].row - corners[0].row); };
  const double east = (rise_1 * row_of(2) - rise_2 * row_of(1)) / area;
  const double north_slope = (rise_2 * column_of(1) - rise_1 * column_of(2)) / area;
  for (std::int64_t r = first_row; r <= last_row; ++r) {
    const std::int64_t y = grid.row + r * grid.step;
    if (y < margin_ || y > north_east_.row - margin_) continue;
    RowSpan span = row_span(corners, y, grid.column, grid.step);
    span.first = std::max<std::int64_t>({span.first, 0, ceil_div(margin_ - grid.column, grid.step)});
    span.last = std::min<std::int64_t>(
        {span.last, grid.columns - 1, floor_div(north_east_.column - margin_ - grid.column, grid.step)});
    const float* row = grid.metres.data() + grid.index(0, static_cast<int>(r));
    const double start = heights_[v[0]] + north_slope * static_cast<double>(y - corners[0].row) +
                         east * static_cast<double>(grid.column - corners[0].column);
    const double slope = east * static_cast<double>(grid.step);
    for (std::int64_t c = span.first; c <= span.last; ++c) {
      const double error = std::abs(static_cast<double>(row[c]) - (start + slope * static_cast<double>(c)));
      if (!(error > worst.error_m)) continue;  // also where the sample is NaN
      const GridPlace place = grid.place(static_cast<int>(c), static_cast<int>(r));
      if (std::find(corners.begin(), corners.end(), place) != corners.end()) continue;
      worst.error_m = error;
      worst.grid = number;
      worst.column = static_cast<int>(c);
      worst.row = static_cast<int>(r);
    }
  }
}

}  // namespace cairn
