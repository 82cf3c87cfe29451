#include "builder/objects/scatter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include <fmt/format.h>

namespace cairn {
namespace {

constexpr double kRadian = std::numbers::pi / 180;
constexpr double kHectare = 1e4;
constexpr double kMostExpected = 1e9;
constexpr double kMeanOfCell = 2;  // candidates at most
constexpr double kLargestCell_m = 1e5;

/// splitmix64 (Steele, Lea & Flood 2014): numbers that depend on where they are asked for only.
class RandomStream {
 public:
  explicit RandomStream(std::uint64_t state) : state_(state) {}
  std::uint64_t next() {
    std::uint64_t z = state_ += 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
  }
  double next_unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }

 private:
  std::uint64_t state_;
};

std::uint64_t mixed(std::uint64_t a, std::uint64_t b) {
  return RandomStream(a ^ (b * 0xD6E8FEB86659FD93u)).next();
}

struct Candidate {
  LonLat at;
  std::uint64_t priority = 0;
  std::array<double, 3> position_m{};
};

/// The cells of the body's grid in rows from the south pole on, and the candidates in them.
class CandidateGrid {
 public:
  CandidateGrid(const ScatterRule& rule, const Body& body) : shape_(body.shape), spacing_m_(rule.spacing_m) {
    const double density = rule.per_hectare / kHectare;
    const double disc = std::numbers::pi * spacing_m_ * spacing_m_;
    // Of candidates per square metre, (1 − exp(−candidates · disc)) / disc remain.
    candidates_ = disc > 0 ? -std::log1p(-density * disc) / disc : density;
    side_m_ = std::min(std::max(spacing_m_, std::sqrt(kMeanOfCell / candidates_)), kLargestCell_m);
    const double least_radius = shape_.semi_minor_m * shape_.semi_minor_m / shape_.semi_major_m;
    row_degrees_ = side_m_ / (least_radius * kRadian);
    seed_ = mixed(rule.seed, 0x6361697Eu);
  }

  double row_degrees() const { return row_degrees_; }
  std::int64_t row_of(double lat) const { return static_cast<std::int64_t>((lat + 90) / row_degrees_); }
  double south_of(std::int64_t row) const { return static_cast<double>(row) * row_degrees_ - 90; }

  /// Appends the candidates of a row from a longitude to another, of whole cells.
  void add_candidates(std::int64_t row, double west, double east, std::vector<Candidate>& out) const {
    const double south = south_of(row);
    if (row < 0 || south >= 90) return;
    const double middle = std::min(south + row_degrees_ / 2, 90.0);
    const double around_m = 360 * degree_of_lon_m(middle);
    const auto columns = static_cast<std::int64_t>(std::max(1.0, std::floor(around_m / side_m_)));
    const double width = 360.0 / static_cast<double>(columns);
    const double mean =
        candidates_ * around_m / static_cast<double>(columns) * row_degrees_ * degree_of_lat_m(middle);
    const double none = std::exp(-mean);
    const std::uint64_t of_row = mixed(seed_, static_cast<std::uint64_t>(row));
    const auto last = static_cast<std::int64_t>(std::floor((east + 180) / width));
    for (auto column = static_cast<std::int64_t>(std::floor((west + 180) / width)); column <= last;
         ++column) {
      const std::int64_t own = (column % columns + columns) % columns;
      RandomStream random(mixed(of_row, static_cast<std::uint64_t>(own)));
      int count = 0;
      const double u = random.next_unit();
      for (double share = none, sum = none; u >= sum && count < 64; sum += share) share *= mean / ++count;
      for (int i = 0; i < count; ++i) {
        Candidate candidate;
        candidate.at.lon = (static_cast<double>(column) + random.next_unit()) * width - 180;
        candidate.at.lat = south + random.next_unit() * row_degrees_;
        candidate.priority = random.next();
        if (candidate.at.lat >= 90) continue;
        if (spacing_m_ > 0) candidate.position_m = position_of(candidate.at);
        out.push_back(candidate);
      }
    }
  }

  /// How many degrees of longitude the spacing is at most, in a row and beside it.
  double reach_degrees(std::int64_t row) const {
    if (spacing_m_ == 0) return 0;
    const double south = south_of(row - 1), north = south_of(row + 2);
    const double metres = std::min(degree_of_lon_m(std::clamp(south, -90.0, 90.0)),
                                   degree_of_lon_m(std::clamp(north, -90.0, 90.0)));
    return metres * 180 <= spacing_m_ * 1.01 ? 180 : spacing_m_ * 1.01 / metres;
  }

 private:
  double prime_vertical_m(double sine) const {
    const double f = shape_.flattening();
    return shape_.semi_major_m / std::sqrt(1 - f * (2 - f) * sine * sine);
  }
  double degree_of_lon_m(double lat) const {
    return prime_vertical_m(std::sin(lat * kRadian)) * std::max(std::cos(lat * kRadian), 0.0) * kRadian;
  }
  double degree_of_lat_m(double lat) const {
    const double f = shape_.flattening(), sine = std::sin(lat * kRadian);
    return prime_vertical_m(sine) * (1 - f * (2 - f)) / (1 - f * (2 - f) * sine * sine) * kRadian;
  }
  std::array<double, 3> position_of(LonLat at) const {
    const double sine = std::sin(at.lat * kRadian), cosine = std::cos(at.lat * kRadian);
    const double n = prime_vertical_m(sine), f = shape_.flattening();
    return {n * cosine * std::cos(at.lon * kRadian), n * cosine * std::sin(at.lon * kRadian),
            n * (1 - f * (2 - f)) * sine};
  }

  Ellipsoid shape_;
  double spacing_m_;
  double candidates_ = 0;  // per square metre
  double side_m_ = 0;      // of a cell
  double row_degrees_ = 0;
  std::uint64_t seed_ = 0;
};

/// A side of a ring from south to north, so that both its neighbours compute with the same numbers.
struct Edge {
  LonLat low, high;

  double lon_at(double lat) const {
    return low.lon + (lat - low.lat) / (high.lat - low.lat) * (high.lon - low.lon);
  }
};

std::vector<Edge> edges_of(const ScatterArea& area) {
  std::vector<Edge> edges;
  for (const auto& ring : area.rings) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const LonLat a = ring[i], b = ring[(i + 1) % ring.size()];
      if (a.lat == b.lat) continue;
      edges.push_back(a.lat < b.lat ? Edge{a, b} : Edge{b, a});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.low.lat < b.low.lat; });
  return edges;
}

bool is_inside(const std::vector<Edge>& edges, LonLat at) {
  bool inside = false;
  for (const Edge& edge : edges) {
    if (edge.low.lat <= at.lat && at.lat < edge.high.lat && at.lon < edge.lon_at(at.lat)) inside = !inside;
  }
  return inside;
}

double square_metres(const ScatterArea& area, const Body& body) {
  const double degree = body.shape.semi_major_m * kRadian;
  double sum = 0;
  for (const auto& ring : area.rings) {
    double own = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const LonLat a = ring[i], b = ring[(i + 1) % ring.size()];
      own += (b.lon - a.lon) * (std::sin(a.lat * kRadian) + std::sin(b.lat * kRadian)) / 2 / kRadian;
    }
    sum += std::abs(own);
  }
  return sum * degree * degree;
}

/// The longitudes of an area between two latitudes.
struct Span {
  double west = 720;
  double east = -720;

  void add(double lon) {
    west = std::min(west, lon);
    east = std::max(east, lon);
  }
};

Span span_of(const std::vector<Edge>& edges, double south, double north) {
  Span span;
  for (const Edge& edge : edges) {
    span.add(edge.low.lat >= south ? edge.low.lon : edge.lon_at(south));
    span.add(edge.high.lat <= north ? edge.high.lon : edge.lon_at(north));
  }
  return span;
}

class Scattering {
 public:
  Scattering(const ScatterArea& area, const Body& body, const TakeScattered& take)
      : rule_(area.rule), grid_(area.rule, body), edges_(edges_of(area)), take_(take) {
    for (const auto& share : rule_.models)
      weights_.push_back(weights_.empty() ? share.weight : weights_.back() + share.weight);
  }

  Status run(const GeoBounds& bounds) {
    if (edges_.empty()) return {};
    double top = -90;
    for (const Edge& edge : edges_) top = std::max(top, edge.high.lat);
    const double south = std::max(edges_.front().low.lat, bounds.south), north = std::min(top, bounds.north);
    std::vector<Edge> active;
    std::size_t next = 0;
    for (std::int64_t row = grid_.row_of(south); grid_.south_of(row) <= north; ++row) {
      const double low = grid_.south_of(row), high = low + grid_.row_degrees();
      for (; next < edges_.size() && edges_[next].low.lat <= high; ++next) active.push_back(edges_[next]);
      std::erase_if(active, [low](const Edge& edge) { return edge.high.lat < low; });
      if (active.empty()) continue;
      Span span = span_of(active, low, high);
      span.west = std::max(span.west, bounds.west);
      span.east = std::min(span.east, bounds.east);
      if (span.west > span.east) continue;
      if (auto status = take_row(row, span, active, bounds); !status) return status;
    }
    return {};
  }

 private:
  Status take_row(std::int64_t row, const Span& span, const std::vector<Edge>& active,
                  const GeoBounds& bounds) {
    own_.clear();
    grid_.add_candidates(row, span.west, span.east, own_);
    const double reach = grid_.reach_degrees(row);
    if (rule_.spacing_m > 0) find_neighbours(row, span, reach);
    for (const Candidate& candidate : own_) {
      const LonLat at = candidate.at;
      const bool in_bounds =
          at.lon >= bounds.west && at.lon < bounds.east && at.lat >= bounds.south && at.lat < bounds.north;
      if (!in_bounds || !is_inside(active, at) || !is_first(candidate, reach)) continue;
      if (auto status = take_(place_of(candidate)); !status) return status;
    }
    return {};
  }

  void find_neighbours(std::int64_t row, const Span& span, double reach) {
    neighbours_.clear();
    for (std::int64_t r = row - 1; r <= row + 1; ++r)
      grid_.add_candidates(r, span.west - reach, span.east + reach, neighbours_);
    std::sort(neighbours_.begin(), neighbours_.end(),
              [](const Candidate& a, const Candidate& b) { return a.at.lon < b.at.lon; });
  }

  /// Whether none within the spacing has a higher priority. A whole turn away it meets itself, which has not.
  bool is_first(const Candidate& candidate, double reach) const {
    if (rule_.spacing_m == 0) return true;
    const double west = candidate.at.lon - reach, east = candidate.at.lon + reach;
    auto other = std::lower_bound(neighbours_.begin(), neighbours_.end(), west,
                                  [](const Candidate& c, double lon) { return c.at.lon < lon; });
    for (; other != neighbours_.end() && other->at.lon <= east; ++other) {
      if (other->priority <= candidate.priority) continue;
      const double x = other->position_m[0] - candidate.position_m[0],
                   y = other->position_m[1] - candidate.position_m[1],
                   z = other->position_m[2] - candidate.position_m[2];
      if (x * x + y * y + z * z < rule_.spacing_m * rule_.spacing_m) return false;
    }
    return true;
  }

  ObjectPlace place_of(const Candidate& candidate) const {
    RandomStream random(candidate.priority);
    ObjectPlace place;
    place.at = candidate.at;
    const double which = random.next_unit() * weights_.back();
    const auto model = std::upper_bound(weights_.begin(), weights_.end() - 1, which) - weights_.begin();
    place.model = rule_.models[static_cast<std::size_t>(model)].model;
    const double heading = random.next_unit() * 360;
    place.heading_degrees = rule_.heading_degrees.value_or(heading);
    place.scale = rule_.min_scale + random.next_unit() * (rule_.max_scale - rule_.min_scale);
    return place;
  }

  const ScatterRule& rule_;
  CandidateGrid grid_;
  std::vector<Edge> edges_;  // by their southern ends
  const TakeScattered& take_;
  std::vector<double> weights_;  // summed up
  std::vector<Candidate> own_;
  std::vector<Candidate> neighbours_;  // by longitude, those of the row as well
};

}  // namespace

Status scatter(const ScatterArea& area, const Body& body, const GeoBounds& bounds,
               const TakeScattered& take) {
  const double expected = square_metres(area, body) / kHectare * area.rule.per_hectare;
  if (expected > kMostExpected)
    return bad_data(fmt::format("density: expected at most {:.0e} objects in an area, found about {:.1e}",
                                kMostExpected, expected));
  Scattering scattering(area, body, take);
  for (const double turn : {-360.0, 0.0, 360.0}) {
    const GeoBounds turned{bounds.west + turn, bounds.south, bounds.east + turn, bounds.north};
    if (auto status = scattering.run(turned); !status) return status;
  }
  return {};
}

}  // namespace cairn
