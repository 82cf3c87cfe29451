#include "builder/export/quantized_mesh_tile.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "builder/export/greedy_mesh.h"
#include "builder/export/mesh_error.h"
#include "builder/export/rim_grids.h"
#include "builder/export/surface_normal.h"
#include "builder/export/tile_edge.h"

namespace cairn {
namespace {

constexpr int kMostTries = 12;
constexpr std::int64_t kParts = 8;  // of a step
constexpr int kMostHalvings = 2;
constexpr double kLeastStep_m = 1.0 / 4096;
/// Undulations are interpolated between nodes so far apart at most.
constexpr std::int64_t kShiftTicks = std::int64_t{1} << (kTickBits - 5);
constexpr double kShiftError_m = 0.005;  // what that is wrong by at most

/// What the middle of a triangle is below the ellipsoid at most: its circumscribed circle's sagitta.
double sagitta_m(double longest_side_m, const Ellipsoid& ellipsoid) {
  const double least_radius_m = ellipsoid.semi_minor_m * (ellipsoid.semi_minor_m / ellipsoid.semi_major_m);
  return longest_side_m * longest_side_m / (6 * least_radius_m);
}

double distance(const Vector3& a, const Vector3& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

class TileMaker {
 public:
  TileMaker(const QuantizedMeshSource& source, const GeographicTile& tile)
      : source_(source), tile_(tile), rect_(tile.rect()), bound_m_(source.plan.bound_m(tile)) {}

  Result<QuantizedMesh> make();

 private:
  struct Ground {
    std::shared_ptr<const MetreTile> tile;
    Patch patch;
  };

  Status collect();
  Status add_patch(const Patch& patch);
  void add_uncovered();
  void add_shift(HeightSamples& grid) const;
  void start_mesh();
  double height_of_vertex(const HeightSamples& grid, int column, int row) const;
  double height_at(const GridPlace& place) const;
  double surface_at(std::int64_t x, std::int64_t y) const;
  double rounded(double metres) const { return rounded_height(source_, metres, tile_.level); }
  std::int64_t x_of(const GridPlace& p) const { return rect_.west + p.column * unit_; }
  std::int64_t y_of(const GridPlace& p) const { return rect_.south + p.row * unit_; }
  bool at_pole(std::int64_t row) const {
    return (row == 0 && rect_.south == 0) || (row == side_ && rect_.north == kTicksPoleToPole);
  }
  QuantizedMesh quantized() const;
  double longest_side_m(const QuantizedMesh& mesh) const;
  MeshError measure(const QuantizedMesh& mesh, double limit_m) const;
  void add_cell(const MeshError::Place& at, int halvings);
  Status add_normals(QuantizedMesh& mesh) const;

  const QuantizedMeshSource& source_;
  GeographicTile tile_;
  TickRect rect_;
  double bound_m_;
  double rim_error_m_ = 0;  ///< of cells with voids that are not looked at
  std::array<TileEdge, 4> edges_;
  std::vector<Ground> ground_;
  std::vector<PatchLattice> lattices_;
  std::int64_t unit_ = 1;  ///< ticks: an eighth of a step of the finest lattice, so that cells can be divided
  std::int64_t side_ = 1;  ///< of the tile in units
  std::vector<HeightSamples> grids_;
  std::optional<GreedyMesh> mesh_;
};

Status TileMaker::collect() {
  int order = 0;
  for (const TileSide side : {TileSide::west, TileSide::south, TileSide::east, TileSide::north}) {
    auto edge = tile_edge(source_, tile_, side);
    if (!edge) return edge.error();
    order = std::max(order, edge->order);
    edges_[static_cast<std::size_t>(side)] = std::move(*edge);
  }
  const double wanted = kSurfaceShare * bound_m_;
  int finest = source_.patches.coarsest();
  while (source_.plan.order_of(finest, tile_.level) < kMostOrder && finest < kMaxLevel) ++finest;
  const std::vector<Patch> patches = source_.patches.over(rect_, wanted, finest);
  for (const Patch& patch : patches) {
    lattices_.push_back(lattice_of(source_, patch, tile_.level, wanted));
    order = std::max(order, lattices_.back().order);
  }
  RimGrids rims{lattice_step(tile_.level, order), {}};
  for (std::size_t i = 0; i < patches.size(); ++i) {
    if ((patches[i].entry.flags & kHasVoids) == 0) continue;
    const auto spread =
        add_rim(source_, tile_, patches[i], lattice_step(tile_.level, lattices_[i].order), wanted, rims);
    if (!spread) return spread.error();
    rim_error_m_ = std::max(rim_error_m_, *spread);
  }
  unit_ = rims.finest_step / kParts;
  side_ = rect_.width() / unit_;
  for (const Patch& patch : patches)
    if (auto status = add_patch(patch); !status) return status;
  for (HeightSamples& grid : rims.grids) {
    grid.column /= unit_;
    grid.row /= unit_;
    grid.step /= unit_;
    add_shift(grid);
    grids_.push_back(std::move(grid));
  }
  add_uncovered();
  return {};
}

Status TileMaker::add_patch(const Patch& patch) {
  auto tile = source_.tiles.read(patch.entry);
  if (!tile) return tile.error();
  const PatchLattice& lattice = lattices_[ground_.size()];
  ground_.push_back({std::move(*tile), patch});
  const MetreTile& metres = *ground_.back().tile;
  const std::int64_t step = lattice_step(tile_.level, lattice.order);
  const auto first = [step](std::int64_t a, std::int64_t b) {
    return (std::max(a, b) + step - 1) / step * step;
  };
  const auto count = [step](std::int64_t from, std::int64_t a, std::int64_t b) {
    return static_cast<int>((std::min(a, b) - from) / step + 1);
  };
  const std::int64_t west = first(patch.area.west, rect_.west), south = first(patch.area.south, rect_.south);
  HeightSamples grid;
  grid.column = (west - rect_.west) / unit_;
  grid.row = (south - rect_.south) / unit_;
  grid.step = step / unit_;
  grid.columns = count(west, patch.area.east, rect_.east);
  grid.rows = count(south, patch.area.north, rect_.north);
  grid.error_m = lattice.error_m;
  grid.metres.reserve(static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows));
  for (int r = 0; r < grid.rows; ++r)
    for (int c = 0; c < grid.columns; ++c)
      grid.metres.push_back(static_cast<float>(metres.height_at(west + c * step, south + r * step)));
  if (metres.has_voids) {
    grid.voids.resize(grid.metres.size());
    for (std::size_t i = 0; i < grid.metres.size(); ++i) {
      if (!std::isnan(grid.metres[i])) continue;
      grid.voids[i] = 1;
    }
    extend_ground(grid, 0);
  }
  add_shift(grid);
  grids_.push_back(std::move(grid));
  return {};
}

// Where the pack has no tile, the height is that of a void.
void TileMaker::add_uncovered() {
  double covered = 0;
  for (const Ground& ground : ground_) {
    const TickRect& a = ground.patch.area;
    covered += static_cast<double>(std::min(a.east, rect_.east) - std::max(a.west, rect_.west)) *
               static_cast<double>(std::min(a.north, rect_.north) - std::max(a.south, rect_.south));
  }
  const double whole = static_cast<double>(rect_.width()) * static_cast<double>(rect_.height());
  if (covered >= whole * (1 - 1e-9)) return;
  const std::int64_t step = lattice_step(tile_.level, 0);
  HeightSamples grid;
  grid.step = step / unit_;
  grid.columns = grid.rows = static_cast<int>(rect_.width() / step) + 1;
  for (int r = 0; r < grid.rows; ++r) {
    for (int c = 0; c < grid.columns; ++c) {
      const std::int64_t x = rect_.west + c * step, y = rect_.south + r * step;
      const bool has = std::any_of(ground_.begin(), ground_.end(), [&](const Ground& g) {
        return x >= g.patch.area.west && x <= g.patch.area.east && y >= g.patch.area.south &&
               y <= g.patch.area.north;
      });
      grid.metres.push_back(has ? kElsewhere : 0);
    }
  }
  grid.voids.assign(grid.metres.size(), 1);
  add_shift(grid);
  grids_.push_back(std::move(grid));
}

// Bilinear between nodes: undulations are smooth, and asking for each sample would take longer than the mesh.
void TileMaker::add_shift(HeightSamples& grid) const {
  if (!source_.shift.metres || grid.columns == 0 || grid.rows == 0) return;
  const std::int64_t step = grid.step * unit_;
  const int stride = static_cast<int>(std::max<std::int64_t>(1, kShiftTicks / step));
  const auto nodes = [stride](int samples) { return (samples + stride - 2) / stride + 1; };
  const int columns = nodes(grid.columns), rows = nodes(grid.rows);
  std::vector<double> shift;
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      const GridPlace p = grid.place(c * stride, r * stride);
      LonLat place = place_of(x_of(p), y_of(p));
      place.lat = std::min(place.lat, 90.0);
      shift.push_back(source_.shift.metres(place));
    }
  const auto at = [&](int c, int r) {
    return shift[static_cast<std::size_t>(std::min(r, rows - 1) * columns + std::min(c, columns - 1))];
  };
  for (int r = 0; r < grid.rows; ++r) {
    const double v = static_cast<double>(r % stride) / stride;
    for (int c = 0; c < grid.columns; ++c) {
      const double u = static_cast<double>(c % stride) / stride;
      const int i = c / stride, j = r / stride;
      const double metres = (at(i, j) * (1 - u) + at(i + 1, j) * u) * (1 - v) +
                            (at(i, j + 1) * (1 - u) + at(i + 1, j + 1) * u) * v;
      float& sample = grid.metres[grid.index(c, r)];
      sample = static_cast<float>(static_cast<double>(sample) + metres);
    }
  }
}

// In the finest tile that has the place; 0 in voids.
double TileMaker::surface_at(std::int64_t x, std::int64_t y) const {
  const Ground* best = nullptr;
  for (const Ground& g : ground_) {
    const TickRect& a = g.patch.area;
    if (x < a.west || x > a.east || y < a.south || y > a.north) continue;
    if (best == nullptr || g.patch.entry.id.level > best->patch.entry.id.level) best = &g;
  }
  if (best == nullptr) return 0;
  const double metres = best->tile->height_at(x, y);
  return std::isnan(metres) ? 0 : metres;
}

double TileMaker::height_at(const GridPlace& place) const {
  return rounded(surface_at(x_of(place), y_of(place)) + source_.shift.at(place_of(x_of(place), y_of(place))));
}

double TileMaker::height_of_vertex(const HeightSamples& grid, int column, int row) const {
  return rounded(static_cast<double>(grid.metres[grid.index(column, row)]));
}

void TileMaker::start_mesh() {
  const auto edge = [this](TileSide side) -> const std::vector<TileEdge::Vertex>& {
    return edges_[static_cast<std::size_t>(side)].vertices;
  };
  const auto &south = edge(TileSide::south), &north = edge(TileSide::north);
  mesh_.emplace(
      GridPlace{side_, side_},
      std::array{south.front().metres, south.back().metres, north.back().metres, north.front().metres},
      grids_, GreedyMesh::Border::given,
      [this](const HeightSamples& g, int c, int r) { return height_of_vertex(g, c, r); });
  for (const auto& v : south) mesh_->add({(v.along - rect_.west) / unit_, 0}, v.metres);
  for (const auto& v : edge(TileSide::east)) mesh_->add({side_, (v.along - rect_.south) / unit_}, v.metres);
  for (const auto& v : north) mesh_->add({(v.along - rect_.west) / unit_, side_}, v.metres);
  for (const auto& v : edge(TileSide::west)) mesh_->add({0, (v.along - rect_.south) / unit_}, v.metres);
  const int squares = base_squares(tile_.level, bound_m_, source_.patches.ellipsoid());
  for (int r = 1; r < squares; ++r)
    for (int c = 1; c < squares; ++c) {
      const GridPlace place{c * (side_ / squares), r * (side_ / squares)};
      mesh_->add(place, height_at(place));
    }
  // Of the triangles at a pole only the one over the whole edge has no area. It ends above the next samples.
  const std::int64_t next = side_ / QuantizedMesh::kLargest + 1;
  if (at_pole(0)) mesh_->add({side_ / 2, next}, height_at({side_ / 2, next}));
  if (at_pole(side_)) mesh_->add({side_ / 2, side_ - next}, height_at({side_ / 2, side_ - next}));
}

QuantizedMesh TileMaker::quantized() const {
  QuantizedMesh mesh;
  mesh.ellipsoid = source_.patches.ellipsoid();
  const LonLat low = place_of(rect_.west, rect_.south), high = place_of(rect_.east, rect_.north);
  mesh.bounds = {low.lon, low.lat, high.lon, high.lat};
  const auto [lowest, highest] = std::minmax_element(mesh_->heights().begin(), mesh_->heights().end());
  // The finest step, of which the level's is a multiple, that spans the range and fits single precision.
  const double farthest = std::max(std::abs(*lowest), std::abs(*highest));
  double step = source_.plan.height_step_m(tile_.level);
  while (step > kLeastStep_m && step / 2 * QuantizedMesh::kLargest >= *highest - *lowest &&
         farthest + step / 2 * QuantizedMesh::kLargest <= step / 2 * (1 << 24))
    step /= 2;
  mesh.lowest_m = static_cast<float>(*lowest);
  mesh.highest_m = static_cast<float>(*lowest + step * QuantizedMesh::kLargest);
  const auto part = [this](std::int64_t at) {
    return static_cast<std::uint16_t>((2 * QuantizedMesh::kLargest * at + side_) / (2 * side_));
  };
  for (std::size_t i = 0; i < mesh_->places().size(); ++i) {
    mesh.u.push_back(part(mesh_->places()[i].column));
    mesh.v.push_back(part(mesh_->places()[i].row));
    mesh.height.push_back(static_cast<std::uint16_t>(std::lround((mesh_->heights()[i] - *lowest) / step)));
  }
  for (const Delaunay::Triangle& triangle : mesh_->triangles()) {
    const auto& v = triangle.vertices;
    const auto pole_vertices =
        std::count_if(v.begin(), v.end(), [this](std::size_t i) { return at_pole(mesh_->places()[i].row); });
    if (pole_vertices >= 2) continue;
    mesh.triangles.push_back({static_cast<std::uint32_t>(v[0]), static_cast<std::uint32_t>(v[1]),
                              static_cast<std::uint32_t>(v[2])});
  }
  return mesh;
}

double TileMaker::longest_side_m(const QuantizedMesh& mesh) const {
  std::vector<Vector3> points(mesh.u.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] = geocentric(mesh.place(i), mesh.metres(i), mesh.ellipsoid);
  double longest = 0;
  for (const auto& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i)
      longest = std::max(longest, distance(points[t[i]], points[t[(i + 1) % 3]]));
  return longest;
}

MeshError TileMaker::measure(const QuantizedMesh& mesh, double limit_m) const {
  DecodedMesh decoded;
  const double units = static_cast<double>(side_) / QuantizedMesh::kLargest;
  for (std::size_t i = 0; i < mesh.u.size(); ++i) {
    decoded.columns.push_back(mesh.u[i] * units);
    decoded.rows.push_back(mesh.v[i] * units);
    decoded.metres.push_back(mesh.metres(i));
  }
  decoded.triangles = mesh.triangles;
  return measure_mesh(decoded, grids_, side_, limit_m);
}

// A bilinear cell is not flat: where triangles are too far off between samples, the corners of the cell, or
// of the quarter or the sixteenth of it that has the place, and their middle become vertices.
void TileMaker::add_cell(const MeshError::Place& at, int halvings) {
  const HeightSamples& grid = grids_[at.grid];
  const std::int64_t step = grid.step >> halvings;
  const auto first = [&](double place, std::int64_t origin, int count) {
    const double steps = (place - static_cast<double>(origin)) / static_cast<double>(step);
    const std::int64_t last = (static_cast<std::int64_t>(count - 1) << halvings) - 1;
    return std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(steps)), 0, last) * step;
  };
  const std::int64_t column = first(at.column, grid.column, grid.columns),
                     row = first(at.row, grid.row, grid.rows);
  const auto add = [&](std::int64_t x, std::int64_t y) {
    const GridPlace place{grid.column + x, grid.row + y};
    const bool inside = place.column > 0 && place.column < side_ && place.row > 0 && place.row < side_;
    if (!inside) return;
    const double metres = grid.bilinear_at(x, y);
    if (!std::isnan(metres)) mesh_->add(place, rounded(metres));
  };
  for (const std::int64_t x : {column, column + step})
    for (const std::int64_t y : {row, row + step}) add(x, y);
  add(column + step / 2, row + step / 2);
  if (halvings == kMostHalvings) add(std::llround(at.column) - grid.column, std::llround(at.row) - grid.row);
}

Status TileMaker::add_normals(QuantizedMesh& mesh) const {
  for (const GridPlace& place : mesh_->places()) {
    const auto point = surface_normal(source_.patches, source_.tiles, x_of(place), y_of(place));
    if (!point) return point.error();
    mesh.normals.push_back(point->normal);
    mesh.has_ground.push_back(point->has_height ? 1 : 0);
  }
  return {};
}

Result<QuantizedMesh> TileMaker::make() {
  if (auto status = collect(); !status) return status.error();
  start_mesh();
  double surface_error = 0;
  for (const HeightSamples& grid : grids_) surface_error = std::max(surface_error, grid.error_m);
  const double shift_error = source_.shift.metres ? kShiftError_m : 0;
  QuantizedMesh mesh = quantized();
  const double step = source_.plan.height_step_m(tile_.level);
  double tolerance =
      bound_m_ - surface_error - sagitta_m(longest_side_m(mesh), mesh.ellipsoid) - step - shift_error;
  tolerance = std::max(tolerance, 0.25 * bound_m_);
  for (int i = 0; i < kMostTries; ++i) {
    mesh_->refine(tolerance);
    mesh = quantized();
    const double apart = sagitta_m(longest_side_m(mesh), mesh.ellipsoid) + shift_error;
    const MeshError error = measure(mesh, bound_m_ - apart);
    mesh.error_m = std::max(error.metres, rim_error_m_) + apart;
    if (mesh.error_m <= bound_m_) break;
    for (const MeshError::Place& place : error.above) add_cell(place, std::min(i / 2, kMostHalvings));
    if (i < kMostTries / 2) tolerance *= 0.85;
  }
  if (auto status = add_normals(mesh); !status) return status.error();
  return mesh;
}

}  // namespace

Result<QuantizedMesh> make_quantized_mesh(const QuantizedMeshSource& source, const GeographicTile& tile) {
  return TileMaker(source, tile).make();
}

}  // namespace cairn
