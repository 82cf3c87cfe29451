#include "format/delaunay.h"

#include <algorithm>
#include <cassert>

namespace cairn {
namespace {

/// Whether d lies inside the circle through a, b, c, which turn left.
bool in_circle(const GridPlace& a, const GridPlace& b, const GridPlace& c, const GridPlace& d) {
  __extension__ using Wide = __int128;
  const auto lifted = [&](const GridPlace& p) {
    const std::int64_t x = p.column - d.column, y = p.row - d.row;
    return std::array<Wide, 3>{x, y, Wide{x} * x + Wide{y} * y};
  };
  const auto u = lifted(a), v = lifted(b), w = lifted(c);
  return u[2] * (v[0] * w[1] - v[1] * w[0]) - v[2] * (u[0] * w[1] - u[1] * w[0]) +
             w[2] * (u[0] * v[1] - u[1] * v[0]) >
         0;
}

}  // namespace

std::int64_t doubled_area(const GridPlace& a, const GridPlace& b, const GridPlace& c) {
  return (b.column - a.column) * (c.row - a.row) - (b.row - a.row) * (c.column - a.column);
}

Delaunay::Delaunay(const GridPlace& south_west, const GridPlace& north_east) {
  assert(south_west.column < north_east.column && south_west.row < north_east.row);
  places_ = {
      south_west, {north_east.column, south_west.row}, north_east, {south_west.column, north_east.row}};
  triangles_ = {{{0, 1, 2}, {kNone, kNone, 1}}, {{0, 2, 3}, {0, kNone, kNone}}};
}

bool Delaunay::covers(std::size_t triangle, const GridPlace& place) const {
  const auto& v = triangles_[triangle].vertices;
  for (std::size_t i = 0; i < 3; ++i) {
    if (doubled_area(places_[v[i]], places_[v[(i + 1) % 3]], place) < 0) return false;
  }
  return true;
}

std::size_t Delaunay::edge_to(std::size_t triangle, std::size_t neighbour) const {
  const auto& n = triangles_[triangle].neighbours;
  return static_cast<std::size_t>(std::find(n.begin(), n.end(), neighbour) - n.begin());
}

void Delaunay::relink(std::size_t triangle, std::size_t before, std::size_t now) {
  if (triangle != kNone) triangles_[triangle].neighbours[edge_to(triangle, before)] = now;
}

std::vector<std::size_t> Delaunay::insert(const GridPlace& place, std::size_t triangle) {
  assert(covers(triangle, place));
  const std::size_t vertex = places_.size();
  places_.push_back(place);
  changed_.clear();
  open_.clear();
  const auto v = triangles_[triangle].vertices;
  std::size_t on_edge = 3;
  for (std::size_t i = 0; i < 3; ++i) {
    if (doubled_area(places_[v[i]], places_[v[(i + 1) % 3]], place) == 0) on_edge = i;
  }
  if (on_edge == 3) {
    split_inside(triangle, vertex);
  } else {
    split_edge(triangle, on_edge, vertex);
  }
  settle(vertex);
  std::sort(changed_.begin(), changed_.end());
  changed_.erase(std::unique(changed_.begin(), changed_.end()), changed_.end());
  return changed_;
}

// Every new triangle has the new vertex last, so that its edge 0 is opposite.
void Delaunay::split_inside(std::size_t triangle, std::size_t vertex) {
  const Triangle old = triangles_[triangle];
  const std::array<std::size_t, 3> parts{triangle, triangles_.size(), triangles_.size() + 1};
  triangles_.resize(triangles_.size() + 2);
  for (std::size_t i = 0; i < 3; ++i) {
    triangles_[parts[i]] = {{old.vertices[i], old.vertices[(i + 1) % 3], vertex},
                            {old.neighbours[i], parts[(i + 1) % 3], parts[(i + 2) % 3]}};
    if (i > 0) relink(old.neighbours[i], triangle, parts[i]);
    open_.push_back(parts[i]);
    changed_.push_back(parts[i]);
  }
}

void Delaunay::split_edge(std::size_t triangle, std::size_t edge, std::size_t vertex) {
  const Triangle old = triangles_[triangle];
  const std::size_t a = old.vertices[edge], b = old.vertices[(edge + 1) % 3],
                    c = old.vertices[(edge + 2) % 3];
  const std::size_t beyond = old.neighbours[edge];
  const std::size_t second = triangles_.size();
  triangles_.push_back({{b, c, vertex}, {old.neighbours[(edge + 1) % 3], triangle, kNone}});
  triangles_[triangle] = {{c, a, vertex}, {old.neighbours[(edge + 2) % 3], kNone, second}};
  relink(old.neighbours[(edge + 1) % 3], triangle, second);
  for (const std::size_t part : {triangle, second}) {
    open_.push_back(part);
    changed_.push_back(part);
  }
  if (beyond == kNone) return;
  // The triangle beyond is (b, a, d): its parts touch those of this one along the halves of the edge.
  const Triangle other = triangles_[beyond];
  const std::size_t there = edge_to(beyond, triangle);
  const std::size_t d = other.vertices[(there + 2) % 3];
  const std::size_t fourth = triangles_.size();
  triangles_.push_back({{d, b, vertex}, {other.neighbours[(there + 2) % 3], second, beyond}});
  triangles_[beyond] = {{a, d, vertex}, {other.neighbours[(there + 1) % 3], fourth, triangle}};
  relink(other.neighbours[(there + 2) % 3], beyond, fourth);
  triangles_[triangle].neighbours[1] = beyond;
  triangles_[second].neighbours[2] = fourth;
  for (const std::size_t part : {beyond, fourth}) {
    open_.push_back(part);
    changed_.push_back(part);
  }
}

bool Delaunay::must_flip(std::size_t triangle, std::size_t edge) const {
  const std::size_t beyond = triangles_[triangle].neighbours[edge];
  if (beyond == kNone) return false;
  const auto& v = triangles_[triangle].vertices;
  const std::size_t opposite = triangles_[beyond].vertices[(edge_to(beyond, triangle) + 2) % 3];
  return in_circle(places_[v[0]], places_[v[1]], places_[v[2]], places_[opposite]);
}

// (a, b, v) and (b, a, d) become (a, d, v) and (d, b, v).
void Delaunay::flip(std::size_t triangle, std::size_t edge) {
  assert(edge == 0);
  const Triangle old = triangles_[triangle];
  const std::size_t beyond = old.neighbours[edge];
  const Triangle other = triangles_[beyond];
  const std::size_t there = edge_to(beyond, triangle);
  const auto [a, b, v] = old.vertices;
  const std::size_t d = other.vertices[(there + 2) % 3];
  const std::size_t beyond_ad = other.neighbours[(there + 1) % 3],
                    beyond_db = other.neighbours[(there + 2) % 3];
  triangles_[triangle] = {{a, d, v}, {beyond_ad, beyond, old.neighbours[2]}};
  triangles_[beyond] = {{d, b, v}, {beyond_db, old.neighbours[1], triangle}};
  relink(beyond_ad, beyond, triangle);
  relink(old.neighbours[1], triangle, beyond);
}

void Delaunay::settle(std::size_t vertex) {
  while (!open_.empty()) {
    const std::size_t triangle = open_.back();
    open_.pop_back();
    assert(triangles_[triangle].vertices[2] == vertex);
    if (!must_flip(triangle, 0)) continue;
    const std::size_t beyond = triangles_[triangle].neighbours[0];
    flip(triangle, 0);
    for (const std::size_t part : {triangle, beyond}) {
      open_.push_back(part);
      changed_.push_back(part);
    }
  }
  (void)vertex;
}

}  // namespace cairn
