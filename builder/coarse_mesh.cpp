#include "builder/coarse_mesh.h"

#include <algorithm>
#include <cassert>

namespace cairn {
namespace {

std::int64_t floor_divide(std::int64_t a, std::int64_t b) {
  return a / b - (a % b < 0 ? 1 : 0);
}

IndexRange nodes_around(IndexRange places, std::int64_t step) {
  return {floor_divide(places.first, step) - 1, floor_divide(places.last, step) + 2};
}

using Weights = std::array<double, 4>;

// Of the nodes at -1, 0, 1, 2.
Weights lagrange(double f) {
  return {-f * (f - 1) * (f - 2) / 6, (f + 1) * (f - 1) * (f - 2) / 2, -(f + 1) * f * (f - 2) / 2,
          (f + 1) * f * (f - 1) / 6};
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

CoarseMesh::CoarseMesh(IndexWindow places, std::int64_t step, const Map& map)
    : places_(places), step_(step), nodes_{nodes_around(places.x, step), nodes_around(places.y, step)} {
  assert(step > 0);
  points_.reserve(static_cast<std::size_t>(nodes_.count()));
  for (std::int64_t y = nodes_.y.first; y <= nodes_.y.last; ++y) {
    for (std::int64_t x = nodes_.x.first; x <= nodes_.x.last; ++x) points_.push_back(map(x * step, y * step));
  }
  columns_.reserve(static_cast<std::size_t>(places.x.count()));
  for (std::int64_t x = places.x.first; x <= places.x.last; ++x) columns_.push_back(stencil_of(x));
}

CoarseMesh::Stencil CoarseMesh::stencil_of(std::int64_t place) const {
  const std::int64_t below = floor_divide(place, step_);
  return {below - 1, lagrange(static_cast<double>(place - below * step_) / static_cast<double>(step_))};
}

void CoarseMesh::row(std::int64_t y, std::span<PlanePoint> out) const {
  assert(places_.y.holds(y) && out.size() == columns_.size());
  const Stencil up = stencil_of(y);
  const auto columns = static_cast<std::size_t>(nodes_.x.count());
  std::vector<PlanePoint> nodes(columns);
  const PlanePoint* corner = &points_[nodes_.offset(nodes_.x.first, up.first)];
  for (std::size_t c = 0; c < columns; ++c) nodes[c] = combine(up.weights, corner + c, columns);
  for (std::size_t x = 0; x < columns_.size(); ++x) {
    const Stencil& along = columns_[x];
    out[x] = combine(along.weights, &nodes[static_cast<std::size_t>(along.first - nodes_.x.first)], 1);
  }
}

}  // namespace cairn
