#include "builder/resample/projection_mesh.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "format/simd_clones.h"

namespace cairn {
namespace {

// At finer ones a mesh's nodes cost as much as its places.
constexpr std::int64_t kLeastFinerStep = 4;

IndexRange nodes_around(IndexRange places, std::int64_t step) {
  return {floor_divide(places.first, step) - 1, floor_divide(places.last, step) + 2};
}

using Weights = std::array<double, 4>;

// Of the nodes at -1, 0, 1, 2.
Weights lagrange(double f) {
  return {-f * (f - 1) * (f - 2) / 6, (f + 1) * (f - 1) * (f - 2) / 2, -(f + 1) * f * (f - 2) / 2,
          (f + 1) * f * (f - 1) / 6};
}

// Places whose nodes are the same four: `weights` are four rows of `stride`, a number for each place.
CAIRN_SIMD_CLONES void combine_run(const double* weights, std::size_t stride, const PlanePoint* p,
                                   std::size_t count, double* out) {
  const double *a = weights, *b = a + stride, *c = b + stride, *d = c + stride;
  for (std::size_t i = 0; i < count; ++i) {
    out[2 * i] = a[i] * p[0].x + b[i] * p[1].x + c[i] * p[2].x + d[i] * p[3].x;
    out[2 * i + 1] = a[i] * p[0].y + b[i] * p[1].y + c[i] * p[2].y + d[i] * p[3].y;
  }
}

PlanePoint combine(const Weights& w, const PlanePoint* p, std::size_t stride) {
  PlanePoint sum;
  for (std::size_t k = 0; k < 4; ++k) {
    sum.x += w[k] * p[k * stride].x;
    sum.y += w[k] * p[k * stride].y;
  }
  return sum;
}

}  // namespace

std::int64_t projection_mesh_step(double places_per_degree) {
  // The error in places grows with the step's fourth power and falls with the third of the places' number.
  if (places_per_degree >= 8192) return 64;
  return std::clamp<std::int64_t>(static_cast<std::int64_t>(places_per_degree / 16), 1, 16);
}

ProjectionMesh::ProjectionMesh(IndexWindow places, std::int64_t step, double tolerance, Map map)
    : ProjectionMesh(places, step,
                     [tolerance](const PlanePoint&) {
                       return PlanePoint{tolerance, tolerance};
                     },
                     std::move(map), {{-HUGE_VAL, -HUGE_VAL}, {HUGE_VAL, HUGE_VAL}}) {}

ProjectionMesh::ProjectionMesh(IndexWindow places, std::int64_t step, const Tolerance& tolerance, Map map,
                               const Box& wanted)
    : places_(places),
      step_(step),
      map_(std::move(map)),
      nodes_{nodes_around(places.x, step), nodes_around(places.y, step)},
      cells_{{floor_divide(places.x.first, step), floor_divide(places.x.last, step)},
             {floor_divide(places.y.first, step), floor_divide(places.y.last, step)}} {
  assert(step > 0);
  if (step == 1) {
    kinds_.assign(static_cast<std::size_t>(cells_.count()), Cell::exact);
    return;
  }
  make_nodes();
  for (std::int64_t y = cells_.y.first; y <= cells_.y.last; ++y) {
    for (std::int64_t x = cells_.x.first; x <= cells_.x.last; ++x)
      kinds_.push_back(kind_of(x, y, tolerance, wanted));
  }
}

ProjectionMesh::Cell ProjectionMesh::kind_of(std::int64_t cell_x, std::int64_t cell_y,
                                             const Tolerance& tolerance, const Box& wanted) {
  if (is_beside(cell_x, cell_y, wanted)) return Cell::unwanted;
  if (is_smooth(cell_x, cell_y, tolerance)) return Cell::smooth;
  const std::int64_t finer = step_ / 4;
  if (finer < kLeastFinerStep) return Cell::exact;
  const auto part = [this](IndexRange all, std::int64_t cell) {
    return IndexRange{std::max(all.first, cell * step_), std::min(all.last, (cell + 1) * step_ - 1)};
  };
  finer_.try_emplace(cells_.offset(cell_x, cell_y),
                     IndexWindow{part(places_.x, cell_x), part(places_.y, cell_y)}, finer, tolerance, map_,
                     wanted);
  return Cell::finer;
}

void ProjectionMesh::make_nodes() {
  points_.reserve(static_cast<std::size_t>(nodes_.count()));
  for (std::int64_t y = nodes_.y.first; y <= nodes_.y.last; ++y) {
    for (std::int64_t x = nodes_.x.first; x <= nodes_.x.last; ++x)
      points_.push_back(map_(x * step_, y * step_));
  }
  weights_.resize(static_cast<std::size_t>(4 * step_));
  for (std::int64_t i = 0; i < step_; ++i) {
    const Weights at = lagrange(static_cast<double>(i) / static_cast<double>(step_));
    for (std::size_t k = 0; k < 4; ++k)
      weights_[k * static_cast<std::size_t>(step_) + static_cast<std::size_t>(i)] = at[k];
  }
}

// The nodes around the cell span a rectangle. Inside the cell the map may leave it, as at a pole, but by less
// than half its size. Nodes that are not finite make no rectangle, and then the answer is no.
bool ProjectionMesh::is_beside(std::int64_t cell_x, std::int64_t cell_y, const Box& wanted) const {
  PlanePoint least{HUGE_VAL, HUGE_VAL}, most{-HUGE_VAL, -HUGE_VAL};
  for (std::int64_t r = -1; r <= 2; ++r) {
    const PlanePoint* node = &points_[nodes_.offset(cell_x - 1, cell_y + r)];
    for (std::int64_t c = 0; c < 4; ++c, ++node) {
      if (!std::isfinite(node->x) || !std::isfinite(node->y)) return false;
      least = {std::min(least.x, node->x), std::min(least.y, node->y)};
      most = {std::max(most.x, node->x), std::max(most.y, node->y)};
    }
  }
  const double x = (most.x - least.x) / 2, y = (most.y - least.y) / 2;
  return most.x + x < wanted.least.x || least.x - x > wanted.most.x || most.y + y < wanted.least.y ||
         least.y - y > wanted.most.y;
}

// Not finite nodes make the sum not finite, which no tolerance holds.
bool ProjectionMesh::is_smooth(std::int64_t cell_x, std::int64_t cell_y, const Tolerance& tolerance) const {
  const std::int64_t x = cell_x * step_ + step_ / 2, y = cell_y * step_ + step_ / 2;
  const Stencil across = stencil_of(x), up = stencil_of(y);
  PlanePoint sum;
  for (std::int64_t r = 0; r < 4; ++r) {
    const PlanePoint line = combine(across.weights, &points_[nodes_.offset(across.first, up.first + r)], 1);
    sum.x += up.weights[static_cast<std::size_t>(r)] * line.x;
    sum.y += up.weights[static_cast<std::size_t>(r)] * line.y;
  }
  const PlanePoint exact = map_(x, y);
  const PlanePoint allowed = tolerance(exact);
  return std::abs(sum.x - exact.x) <= allowed.x && std::abs(sum.y - exact.y) <= allowed.y;
}

ProjectionMesh::Stencil ProjectionMesh::stencil_of(std::int64_t place) const {
  const std::int64_t below = floor_divide(place, step_);
  return {below - 1, lagrange(static_cast<double>(place - below * step_) / static_cast<double>(step_))};
}

void ProjectionMesh::row(std::int64_t y, std::span<PlanePoint> out) const {
  assert(places_.y.holds(y) && out.size() == static_cast<std::size_t>(places_.x.count()));
  static_assert(sizeof(PlanePoint) == 2 * sizeof(double));
  const std::int64_t cell_y = floor_divide(y, step_);
  const auto columns = static_cast<std::size_t>(nodes_.x.count());
  std::vector<PlanePoint> nodes(columns);
  if (step_ > 1) {
    const Stencil up = stencil_of(y);
    const PlanePoint* corner = &points_[nodes_.offset(nodes_.x.first, up.first)];
    for (std::size_t c = 0; c < columns; ++c) nodes[c] = combine(up.weights, corner + c, columns);
  }
  const auto step = static_cast<std::size_t>(step_);
  for (std::int64_t x = places_.x.first; x <= places_.x.last;) {
    const std::int64_t below = floor_divide(x, step_),
                       next = std::min((below + 1) * step_, places_.x.last + 1);
    PlanePoint* to = &out[static_cast<std::size_t>(x - places_.x.first)];
    const std::size_t cell = cells_.offset(below, cell_y);
    const Cell kind = kinds_[cell];
    if (kind == Cell::finer) {
      finer_.at(cell).row(y, {to, static_cast<std::size_t>(next - x)});
      x = next;
    } else if (kind == Cell::unwanted) {
      std::fill_n(to, next - x, kNowhere);
      x = next;
    } else if (kind == Cell::smooth) {
      combine_run(&weights_[static_cast<std::size_t>(x - below * step_)], step,
                  &nodes[static_cast<std::size_t>(below - 1 - nodes_.x.first)],
                  static_cast<std::size_t>(next - x), &to->x);
      x = next;
    } else {
      for (; x < next; ++x) *to++ = map_(x, y);
    }
  }
}

}  // namespace cairn
