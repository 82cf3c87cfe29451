#include "runtime/lab/screen_error.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

#include "runtime/lab/parallel.h"
#include "runtime/lod/mesh/grid_positions.h"
#include "runtime/view/horizon.h"
#include "runtime/view/view_frustum.h"

namespace cairn {
namespace {

constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();
constexpr double kNearest_m = 1;

bool contains(const TileId& outer, const TileId& inner) {
  return outer.level <= inner.level && ancestor_of(inner, outer.level) == outer;
}

using GridVertex = FinestView::GridVertex;

/// What is linear over a triangle, along the grid.
struct Plane {
  Plane(const GridVertex& a, const GridVertex& b, const GridVertex& c) : origin(a) {
    const double bx = b.column - a.column, by = b.row - a.row, cx = c.column - a.column, cy = c.row - a.row;
    const double area = bx * cy - cx * by;
    east = ((b.at - a.at) * cy - (c.at - a.at) * by) / area;
    north = ((c.at - a.at) * bx - (b.at - a.at) * cx) / area;
  }
  glm::dvec3 at(double column, double row) const {
    return origin.at + east * (column - origin.column) + north * (row - origin.row);
  }

  GridVertex origin;
  glm::dvec3 east;
  glm::dvec3 north;
};

struct Span {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void add(double x) {
    low = std::min(low, x);
    high = std::max(high, x);
  }
};

/// Where a triangle meets a row of the grid. REQUIRES: it does.
Span span_in_row(const GridVertex (&v)[3], double row) {
  Span span;
  for (int side = 0; side < 3; ++side) {
    const GridVertex &a = v[side], &b = v[(side + 1) % 3];
    if (row < std::min(a.row, b.row) || row > std::max(a.row, b.row)) continue;
    if (a.row == b.row) {
      span.add(a.column);
      span.add(b.column);
    } else {
      span.add(a.column + (b.column - a.column) * ((row - a.row) / (b.row - a.row)));
    }
  }
  return span;
}

}  // namespace

PlacedMesh place(const LodScene& scene, LodMesh mesh, int threads) {
  PlacedMesh placed;
  placed.positions.resize(mesh.tiles.size());
  for (const LodTileMesh& tile : mesh.tiles) placed.areas.push_back(scene.tiles[tile.tile].area);
  for_each_index(mesh.tiles.size(), threads, [&](std::size_t i) {
    for (const LodVertex& v : mesh.tiles[i].vertices) {
      placed.positions[i].push_back(to_geocentric(v.point, v.height_m, scene.ellipsoid));
    }
  });
  placed.mesh = std::move(mesh);
  return placed;
}

/// A mesh's vertices in the camera.
struct FinestView::Projected {
  const PlacedMesh* mesh = nullptr;
  std::vector<std::vector<glm::dvec3>> vertices;
};

struct FinestView::Tally {
  ScreenError error;
  double sum_of_squares = 0;

  void add(const Tally& other) {
    if (other.error.max_px > error.max_px) error.worst = other.error.worst;
    error.max_px = std::max(error.max_px, other.error.max_px);
    error.max_pop_px = std::max(error.max_pop_px, other.error.max_pop_px);
    error.samples += other.error.samples;
    error.holes += other.error.holes;
    sum_of_squares += other.sum_of_squares;
  }
};

Result<FinestView> FinestView::of(LabTerrain& terrain, const ViewState& view, int threads) {
  FinestView finest(view, threads);
  const Occluder occluder(terrain.lowest_m(), view.ellipsoid);
  const ViewFrustum volume(view, occluder);
  std::vector<std::shared_ptr<const HeightTile>> heights;
  std::vector<TileId> sources;
  for (const FinestArea& area : terrain.finest()) {
    if (!volume.sees(area.volume)) continue;
    const auto tile = terrain.heights(area.source);
    if (!tile) return tile.error();
    heights.push_back(*tile);
    sources.push_back(area.source.id);
    finest.leaves_.push_back({south_west_of(area.area), area.area, 0, 0, {}, {}});
  }
  std::vector<char> seen(finest.leaves_.size());
  for_each_index(finest.leaves_.size(), threads, [&](std::size_t i) {
    seen[i] =
        finest.fill(finest.leaves_[i], *heights[i], sources[i], terrain.pack().header().quantum_m, occluder);
  });
  std::vector<Leaf> kept;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (seen[i] != 0) kept.push_back(std::move(finest.leaves_[i]));
  }
  finest.leaves_ = std::move(kept);
  return finest;
}

bool FinestView::fill(Leaf& leaf, const HeightTile& heights, const TileId& source, double quantum_m,
                      const Occluder& occluder) const {
  leaf.spacing = lattice_width(source.level) / (heights.size - 1);
  const int cells = (heights.size - 1) >> (leaf.area.level - source.level);
  leaf.side = cells + 1;
  const LatticePoint corner = south_west_of(source);
  const auto column = static_cast<int>((leaf.corner.x - corner.x) / leaf.spacing);
  const auto row = static_cast<int>((leaf.corner.y - corner.y) / leaf.spacing);
  const GridPositions positions(leaf.corner, leaf.spacing, leaf.side, view_.ellipsoid);
  const Horizon horizon(screen_.camera().position, occluder);
  const double half_width = view_.viewport_width_px / 2.0, half_height = view_.viewport_height_px / 2.0;
  leaf.samples.assign(static_cast<std::size_t>(leaf.side) * static_cast<std::size_t>(leaf.side),
                      {kNowhere, kNowhere});
  leaf.seen.assign(static_cast<std::size_t>(leaf.side), {leaf.side, 0});
  bool any = false;
  std::size_t i = 0;
  for (int r = 0; r < leaf.side; ++r) {
    auto& [first, end] = leaf.seen[static_cast<std::size_t>(r)];
    for (int c = 0; c < leaf.side; ++c, ++i) {
      if (heights.is_void(column + c, row + r)) continue;
      const glm::dvec3 point = positions.at(c, r, heights.at(column + c, row + r) * quantum_m);
      const glm::dvec3 p = screen_.camera().in_camera(point);
      if (p.z < kNearest_m) continue;
      const double u = p.x * screen_.pixels_per_radian() / p.z, v = p.y * screen_.pixels_per_radian() / p.z;
      if (std::abs(u) > half_width || std::abs(v) > half_height || horizon.hides(point)) continue;
      leaf.samples[i] = {static_cast<float>(u), static_cast<float>(v)};
      first = std::min(first, c);
      end = c + 1;
      any = true;
    }
  }
  return any;
}

FinestView::Projected FinestView::project(const PlacedMesh& mesh) const {
  Projected projected{&mesh, std::vector<std::vector<glm::dvec3>>(mesh.positions.size())};
  for_each_index(mesh.positions.size(), threads_, [&](std::size_t i) {
    projected.vertices[i].reserve(mesh.positions[i].size());
    for (const glm::dvec3& p : mesh.positions[i]) {
      projected.vertices[i].push_back(screen_.camera().in_camera(p));
    }
  });
  return projected;
}

void FinestView::draw(const Projected& mesh, const Leaf& leaf, std::vector<Pixel>& out) const {
  out.assign(leaf.samples.size(), {kNowhere, kNowhere});
  const double scale = 1 / static_cast<double>(leaf.spacing);
  for (std::size_t i = 0; i < mesh.mesh->areas.size(); ++i) {
    const TileId& area = mesh.mesh->areas[i];
    if (!contains(area, leaf.area) && !contains(leaf.area, area)) continue;
    const LodTileMesh& tile = mesh.mesh->mesh.tiles[i];
    for (const LodTriangle& t : tile.triangles) {
      GridVertex v[3];
      for (std::size_t k = 0; k < 3; ++k) {
        const LatticePoint& p = tile.vertices[t[k]].point;
        v[k] = {static_cast<double>(p.x - leaf.corner.x) * scale,
                static_cast<double>(p.y - leaf.corner.y) * scale, mesh.vertices[i][t[k]]};
      }
      draw_triangle(v, leaf, out);
    }
  }
}

/// At every sample of the grid that the triangle covers, its edges included.
void FinestView::draw_triangle(const GridVertex (&v)[3], const Leaf& leaf, std::vector<Pixel>& out) const {
  const int last = leaf.side - 1;
  Span columns, rows;
  for (const GridVertex& vertex : v) columns.add(vertex.column), rows.add(vertex.row);
  if (columns.high < 0 || rows.high < 0 || columns.low > last || rows.low > last) return;
  if (v[0].at.z <= 0 && v[1].at.z <= 0 && v[2].at.z <= 0) return;
  const Plane plane(v[0], v[1], v[2]);
  const int last_row = static_cast<int>(std::min<double>(std::floor(rows.high), last));
  for (int r = static_cast<int>(std::max(std::ceil(rows.low), 0.0)); r <= last_row; ++r) {
    const auto& [seen_first, seen_end] = leaf.seen[static_cast<std::size_t>(r)];
    if (seen_first >= seen_end) continue;
    const Span span = span_in_row(v, r);
    const int first = static_cast<int>(std::max<double>(std::ceil(span.low - 1e-9), seen_first));
    const int end = static_cast<int>(std::min<double>(std::floor(span.high + 1e-9), seen_end - 1));
    if (first > end) continue;
    const glm::dvec3 start = plane.at(0, r);
    Pixel* row = &out[static_cast<std::size_t>(r) * static_cast<std::size_t>(leaf.side)];
    for (int c = first; c <= end; ++c) {
      const double z = start.z + plane.east.z * c;
      const double f = z > 0 ? screen_.pixels_per_radian() / z : std::numeric_limits<double>::infinity();
      row[c] = {static_cast<float>((start.x + plane.east.x * c) * f),
                static_cast<float>((start.y + plane.east.y * c) * f)};
    }
  }
}

double FinestView::squared_px(const Pixel& a, const Pixel& b) {
  const double du = static_cast<double>(a.u - b.u), dv = static_cast<double>(a.v - b.v);
  return du * du + dv * dv;
}

void FinestView::compare(const Leaf& leaf, const std::vector<Pixel>& now, Tally& tally) const {
  double worst = -1;
  std::size_t worst_index = 0;
  for (int r = 0; r < leaf.side; ++r) {
    const std::size_t row = static_cast<std::size_t>(r) * static_cast<std::size_t>(leaf.side);
    const auto& [first, end] = leaf.seen[static_cast<std::size_t>(r)];
    for (int c = first; c < end; ++c) {
      const std::size_t i = row + static_cast<std::size_t>(c);
      if (std::isnan(leaf.samples[i].u)) continue;
      ++tally.error.samples;
      const double square = squared_px(leaf.samples[i], now[i]);
      if (!(square < std::numeric_limits<double>::infinity())) {
        ++tally.error.holes;
        continue;
      }
      tally.sum_of_squares += square;
      if (square > worst) {
        worst = square;
        worst_index = i;
      }
    }
  }
  if (worst < 0) return;
  tally.error.max_px = std::sqrt(worst);
  const auto side = static_cast<std::size_t>(leaf.side);
  tally.error.worst = {leaf.corner.x + static_cast<std::int64_t>(worst_index % side) * leaf.spacing,
                       leaf.corner.y + static_cast<std::int64_t>(worst_index / side) * leaf.spacing};
}

void FinestView::compare_before(const Leaf& leaf, const std::vector<Pixel>& now, const Leaf& leaf_before,
                                const std::vector<Pixel>& before, Tally& tally) const {
  double pop = 0;
  for (int r = 0; r < leaf.side; ++r) {
    const std::size_t row = static_cast<std::size_t>(r) * static_cast<std::size_t>(leaf.side);
    const auto& [first, end] = leaf.seen[static_cast<std::size_t>(r)];
    for (int c = first; c < end; ++c) {
      const std::size_t i = row + static_cast<std::size_t>(c);
      if (std::isnan(leaf.samples[i].u) || std::isnan(leaf_before.samples[i].u)) continue;
      const double moved = squared_px(now[i], before[i]);
      if (moved > pop) pop = moved;
    }
  }
  tally.error.max_pop_px = std::sqrt(pop);
}

const FinestView::Leaf* FinestView::leaf_of(const TileId& area) const {
  const auto it =
      std::find_if(leaves_.begin(), leaves_.end(), [&](const Leaf& leaf) { return leaf.area == area; });
  return it == leaves_.end() ? nullptr : &*it;
}

std::uint64_t FinestView::count_useful(const Projected& mesh) const {
  const double half_width = view_.viewport_width_px / 2.0, half_height = view_.viewport_height_px / 2.0;
  std::uint64_t useful = 0;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    for (const LodTriangle& t : mesh.mesh->mesh.tiles[i].triangles) {
      Span us, vs;
      double u[3], v[3];
      bool in_front = true, behind = true;
      for (std::size_t k = 0; k < 3; ++k) {
        const glm::dvec3& p = mesh.vertices[i][t[k]];
        in_front = in_front && p.z > 0;
        behind = behind && p.z <= 0;
        us.add(u[k] = p.x * screen_.pixels_per_radian() / p.z);
        vs.add(v[k] = p.y * screen_.pixels_per_radian() / p.z);
      }
      const double area = std::abs((u[1] - u[0]) * (v[2] - v[0]) - (u[2] - u[0]) * (v[1] - v[0])) / 2;
      const bool inside =
          us.low <= half_width && us.high >= -half_width && vs.low <= half_height && vs.high >= -half_height;
      // A triangle that reaches behind the camera is large wherever it is in the viewport.
      useful += in_front ? inside && area >= 0.25 : !behind;
    }
  }
  return useful;
}

ScreenError FinestView::measure(const PlacedMesh& mesh, const Before* before) const {
  const Projected now = project(mesh);
  const Projected then = before ? project(before->mesh) : Projected{};
  std::vector<Tally> tallies(leaves_.size());
  for_each_index(leaves_.size(), threads_, [&](std::size_t i) {
    thread_local std::vector<Pixel> drawn, drawn_before;
    const Leaf& leaf = leaves_[i];
    draw(now, leaf, drawn);
    compare(leaf, drawn, tallies[i]);
    const Leaf* leaf_before = before ? before->finest.leaf_of(leaf.area) : nullptr;
    if (!leaf_before) return;
    draw(then, leaf, drawn_before);
    compare_before(leaf, drawn, *leaf_before, drawn_before, tallies[i]);
  });
  Tally sum;
  for (const Tally& tally : tallies) sum.add(tally);
  sum.error.useful_triangles = count_useful(now);
  if (sum.error.samples > 0) {
    sum.error.rms_px = std::sqrt(sum.sum_of_squares / static_cast<double>(sum.error.samples));
  }
  return sum.error;
}

}  // namespace cairn
