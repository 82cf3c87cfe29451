#include "builder/export/region_mesher.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "builder/export/greedy_mesh.h"
#include "builder/export/mesh_error.h"

namespace cairn {
namespace {

constexpr int kMeshTries = 12;
constexpr int kCellHalvings = 5;  // of a cell: its middle is a whole unit then
constexpr double kToleranceShare = 0.98;
constexpr double kApartShare =
    0.01;  // of the bound, what straight lines on the plane may be off those in degrees

class RegionMesher {
 public:
  RegionMesher(const RegionRaster& raster, const LocalPlane& plane, double bound_m)
      : raster_(raster),
        grid_(raster.samples),
        plane_(plane),
        bound_m_(bound_m),
        mesh_({(grid_.columns - 1) * kUnitsOfStep, (grid_.rows - 1) * kUnitsOfStep},
              {sample(0, 0), sample(grid_.columns - 1, 0), sample(grid_.columns - 1, grid_.rows - 1),
               sample(0, grid_.rows - 1)},
              std::span(&grid_, 1), GreedyMesh::Border::refined, [](const HeightSamples& grid, int c, int r) {
                return static_cast<double>(grid.metres[grid.index(c, r)]);
              }) {}

  Result<MeshedRegion> run(std::size_t most_vertices, const std::function<Status()>& go_on);

 private:
  double sample(int c, int r) const { return static_cast<double>(grid_.metres[grid_.index(c, r)]); }
  bool is_void(int c, int r) const { return grid_.voids[grid_.index(c, r)] != 0; }
  bool is_ground(std::size_t vertex) const {
    return mesh_.heights()[vertex] != static_cast<double>(kVoidHeight);
  }
  bool is_rim(int c, int r) const;
  void add_rims();
  void add_squares();
  Status refine(double tolerance_m, std::size_t most_vertices, const std::function<Status()>& go_on);
  DecodedMesh ground() const;
  double plane_error(const DecodedMesh& mesh) const;
  void add_cell(const MeshError::Place& at, int halvings);
  Vector3 normal_at(double column, double row) const;
  GlbMesh on_plane(const DecodedMesh& mesh) const;

  const RegionRaster& raster_;
  const HeightSamples& grid_;
  const LocalPlane& plane_;
  double bound_m_;
  GreedyMesh mesh_;
};

bool RegionMesher::is_rim(int c, int r) const {
  const bool own = is_void(c, r);
  for (int y = std::max(r - 1, 0); y <= std::min(r + 1, grid_.rows - 1); ++y)
    for (int x = std::max(c - 1, 0); x <= std::min(c + 1, grid_.columns - 1); ++x)
      if (is_void(x, y) != own) return true;
  return false;
}

// Every sample on both sides of the rim is a vertex, so that each triangle is ground or is not.
void RegionMesher::add_rims() {
  if (!raster_.has_voids) return;
  for (int r = 0; r < grid_.rows; ++r)
    for (int c = 0; c < grid_.columns; ++c)
      if (is_rim(c, r)) mesh_.add(grid_.place(c, r), sample(c, r));
}

// Vertices near enough to each other that straight lines on the plane and in degrees are nearly one.
void RegionMesher::add_squares() {
  const LonLat south_west = raster_.place(0, 0);
  const auto units = static_cast<double>(kUnitsOfStep);
  const PlanePoint origin = plane_.to_plane(south_west);
  const PlanePoint east = plane_.to_plane(raster_.place(units * (grid_.columns - 1), 0));
  const PlanePoint north = plane_.to_plane(raster_.place(0, units * (grid_.rows - 1)));
  const PlanePoint middle = plane_.to_plane(raster_.place(units * (grid_.columns - 1) / 2, 0));
  const double width = std::hypot(east.east_m - origin.east_m, east.north_m - origin.north_m);
  const double height = std::hypot(north.east_m - origin.east_m, north.north_m - origin.north_m);
  const double bow = std::hypot(middle.east_m - (origin.east_m + east.east_m) / 2,
                                middle.north_m - (origin.north_m + east.north_m) / 2);
  const double pieces = std::ceil(std::sqrt(bow / (kApartShare * bound_m_)));
  const auto stride = [&](double length, int samples) {
    return std::max(1, static_cast<int>(std::floor((samples - 1) * (width / pieces) / length)));
  };
  if (!(pieces > 1)) return;
  const int across = stride(width, grid_.columns), up = stride(height, grid_.rows);
  for (int r = 0; r < grid_.rows; r += up)
    for (int c = 0; c < grid_.columns; c += across)
      if (!is_void(c, r)) mesh_.add(grid_.place(c, r), sample(c, r));
}

// By halves, which adds what one go would, so that an export can be cancelled.
Status RegionMesher::refine(double tolerance_m, std::size_t most_vertices,
                            const std::function<Status()>& go_on) {
  double now_m = tolerance_m;
  while (now_m < raster_.highest_m - raster_.lowest_m) now_m *= 2;
  for (; now_m >= tolerance_m; now_m /= 2) {
    if (auto status = go_on(); !status) return status;
    if (!mesh_.refine(now_m, most_vertices))
      return usage_error(
          fmt::format("mesh: expected at most {} vertices, which the memory holds, found more; a smaller "
                      "region or a larger error needs fewer",
                      most_vertices));
  }
  return {};
}

DecodedMesh RegionMesher::ground() const {
  DecodedMesh out;
  constexpr std::uint32_t kUnused = UINT32_MAX;
  std::vector<std::uint32_t> numbers(mesh_.places().size(), kUnused);
  const auto number = [&](std::size_t vertex) {
    if (numbers[vertex] == kUnused) {
      numbers[vertex] = static_cast<std::uint32_t>(out.columns.size());
      out.columns.push_back(static_cast<double>(mesh_.places()[vertex].column));
      out.rows.push_back(static_cast<double>(mesh_.places()[vertex].row));
      out.metres.push_back(mesh_.heights()[vertex]);
    }
    return numbers[vertex];
  };
  for (const Delaunay::Triangle& triangle : mesh_.triangles()) {
    const auto [a, b, c] = triangle.vertices;
    if (is_ground(a) && is_ground(b) && is_ground(c))
      out.triangles.push_back({number(a), number(b), number(c)});
  }
  return out;
}

// A triangle that is straight on the plane is not quite so in degrees, which is what the mesh is measured in.
// A place of it lies up to `apart` aside, where the surface is as much higher as it is steep. What is left
// out of the series by the middles of the edges is far less than the difference from 4/3 to 3/2.
double RegionMesher::plane_error(const DecodedMesh& mesh) const {
  std::vector<Vector3> points;
  double farthest = 0;
  for (std::size_t i = 0; i < mesh.columns.size(); ++i) {
    const PlanePoint p = plane_.to_plane(raster_.place(mesh.columns[i], mesh.rows[i]));
    points.push_back({p.east_m, p.north_m, mesh.metres[i]});
    farthest = std::max({farthest, std::abs(p.east_m), std::abs(p.north_m)});
  }
  const double rounding = std::hypot(1, 1) * std::max(kMeshStep_m / 2, std::ldexp(farthest, -24));
  const double height_rounding = std::max(
      kMeshStep_m / 2, std::ldexp(std::max(std::abs(raster_.lowest_m), std::abs(raster_.highest_m)), -24));
  std::vector<double> apart, steepest(points.size(), 0);
  for (const auto& t : mesh.triangles) {
    double most = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = t[i], b = t[(i + 1) % 3];
      const PlanePoint middle = plane_.to_plane(
          raster_.place((mesh.columns[a] + mesh.columns[b]) / 2, (mesh.rows[a] + mesh.rows[b]) / 2));
      most = std::max(most, std::hypot(middle.east_m - (points[a][0] + points[b][0]) / 2,
                                       middle.north_m - (points[a][1] + points[b][1]) / 2));
    }
    apart.push_back(1.5 * most + rounding);
    const Vector3 &p = points[t[0]], &q = points[t[1]], &s = points[t[2]];
    const Vector3 u{q[0] - p[0], q[1] - p[1], q[2] - p[2]}, v{s[0] - p[0], s[1] - p[1], s[2] - p[2]};
    const double slope = std::hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2]) /
                         std::abs(u[0] * v[1] - u[1] * v[0]);
    for (const std::uint32_t i : t) steepest[i] = std::max(steepest[i], slope);
  }
  double worst = 0;
  for (std::size_t i = 0; i < apart.size(); ++i)
    for (const std::uint32_t v : mesh.triangles[i]) worst = std::max(worst, apart[i] * steepest[v]);
  return worst + height_rounding;
}

// A bilinear cell is not flat: where triangles are too far off between samples, the corners of the cell, or
// of a smaller square with the place in it, and their middle become vertices.
void RegionMesher::add_cell(const MeshError::Place& at, int halvings) {
  const auto cell_of = [](double place, int count) {
    return std::clamp(static_cast<int>(place / static_cast<double>(kUnitsOfStep)), 0, count - 2);
  };
  const int c = cell_of(at.column, grid_.columns), r = cell_of(at.row, grid_.rows);
  if (is_void(c, r) || is_void(c + 1, r) || is_void(c, r + 1) || is_void(c + 1, r + 1)) return;
  const std::int64_t step = kUnitsOfStep >> halvings;
  const auto start = [step](double place, int cell) {
    const std::int64_t from = cell * kUnitsOfStep;
    return std::clamp(static_cast<std::int64_t>(place) / step * step, from, from + kUnitsOfStep - step);
  };
  const std::int64_t column = start(at.column, c), row = start(at.row, r);
  const auto add = [&](std::int64_t x, std::int64_t y) { mesh_.add({x, y}, grid_.bilinear_at(x, y)); };
  for (const std::int64_t x : {column, column + step})
    for (const std::int64_t y : {row, row + step}) add(x, y);
  add(column + step / 2, row + step / 2);
}

// By differences of the nearest sample's neighbours that have a height.
Vector3 RegionMesher::normal_at(double column, double row) const {
  const int c = static_cast<int>(std::lround(column / static_cast<double>(kUnitsOfStep))),
            r = static_cast<int>(std::lround(row / static_cast<double>(kUnitsOfStep)));
  const auto difference = [&](int dc, int dr) -> Vector3 {
    int before = 1, after = 1;
    if (c - dc < 0 || r - dr < 0 || is_void(c - dc, r - dr)) before = 0;
    if (c + dc >= grid_.columns || r + dr >= grid_.rows || is_void(c + dc, r + dr)) after = 0;
    const auto point = [&](int x, int y) -> Vector3 {
      const PlanePoint p = plane_.to_plane(
          raster_.place(static_cast<double>(x * kUnitsOfStep), static_cast<double>(y * kUnitsOfStep)));
      return {p.east_m, p.north_m, sample(x, y)};
    };
    const Vector3 from = point(c - before * dc, r - before * dr), to = point(c + after * dc, r + after * dr);
    return {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
  };
  const Vector3 e = difference(1, 0), n = difference(0, 1);
  const Vector3 normal{e[1] * n[2] - e[2] * n[1], e[2] * n[0] - e[0] * n[2], e[0] * n[1] - e[1] * n[0]};
  const double length = std::hypot(normal[0], normal[1], normal[2]);
  if (!(length > 0)) return {0, 0, 1};
  return {normal[0] / length, normal[1] / length, normal[2] / length};
}

GlbMesh RegionMesher::on_plane(const DecodedMesh& mesh) const {
  GlbMesh out;
  const auto width = static_cast<double>((grid_.columns - 1) * kUnitsOfStep),
             height = static_cast<double>((grid_.rows - 1) * kUnitsOfStep);
  for (std::size_t i = 0; i < mesh.columns.size(); ++i) {
    const PlanePoint p = plane_.to_plane(raster_.place(mesh.columns[i], mesh.rows[i]));
    out.positions.push_back({p.east_m, p.north_m, mesh.metres[i]});
    out.normals.push_back(normal_at(mesh.columns[i], mesh.rows[i]));
    out.texture.push_back(
        {static_cast<float>(mesh.columns[i] / width), static_cast<float>(1 - mesh.rows[i] / height)});
  }
  out.triangles = mesh.triangles;
  return out;
}

Result<MeshedRegion> RegionMesher::run(std::size_t most_vertices, const std::function<Status()>& go_on) {
  add_rims();
  add_squares();
  double tolerance = kToleranceShare * (bound_m_ - grid_.error_m);
  const std::int64_t side = std::max(grid_.columns, grid_.rows) * kUnitsOfStep;
  double found_m = 0;
  for (int i = 0; i < kMeshTries; ++i) {
    if (auto status = refine(tolerance, most_vertices, go_on); !status) return status.error();
    const DecodedMesh mesh = ground();
    if (mesh.triangles.empty())
      return failed("mesh: expected a triangle of ground in the region, found only single samples");
    const double apart = plane_error(mesh);
    const MeshError error = measure_mesh(mesh, std::span(&grid_, 1), side, bound_m_ - apart);
    found_m = error.metres + apart;
    if (found_m <= bound_m_) return MeshedRegion{on_plane(mesh), found_m};
    for (const MeshError::Place& place : error.above) add_cell(place, std::min(i, kCellHalvings));
    if (i > kCellHalvings) tolerance *= 0.85;
  }
  return failed(
      fmt::format("mesh: expected at most {:g} m off the source posts, found {:g} m", bound_m_, found_m));
}

}  // namespace

Result<MeshedRegion> mesh_region(const RegionRaster& raster, const LocalPlane& plane, double bound_m,
                                 std::size_t most_vertices, const std::function<Status()>& go_on) {
  return RegionMesher(raster, plane, bound_m).run(most_vertices, go_on);
}

}  // namespace cairn
