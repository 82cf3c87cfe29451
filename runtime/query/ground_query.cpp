#include "cairn/ground_query.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <queue>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec2.hpp>

#include "runtime/query/ground_tiles.h"

namespace cairn {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kWidening = 1.02;    // geocentric angles to geodetic ones, with room for rounding
constexpr double kPolar_deg = 89.9;   // beyond it cells are no narrower than here
constexpr double kShortest_m = 1e-3;  // a piece that crosses a cell's edge is not split further

/// A straight line in space.
struct Line {
  glm::dvec3 origin;
  glm::dvec3 direction;  // a unit vector
  glm::dvec3 at(double t_m) const { return origin + direction * t_m; }
};

/// A piece of the line, from one distance to another.
struct Piece {
  double from_m = 0;
  double to_m = 0;
  double middle_m() const { return (from_m + to_m) / 2; }
  double half_m() const { return (to_m - from_m) / 2; }
};

/// Where a point of the line is, and what is below it.
struct Probe {
  Geodetic at;
  std::optional<TileId> tile;  // nullopt where there is none
  double error_m = 0;          // of the tile
  GroundTile::Position cell;
  std::optional<double> above_m;  // the height above the ground; nullopt where there is none or it is void

  bool shares_cell(const Probe& other) const {
    return tile == other.tile && cell.cell_column == other.cell.cell_column &&
           cell.cell_row == other.cell.cell_row;
  }
};

/// The parabola through three values at -1, 0 and 1: what a line has above a bilinear cell, but for some
/// millionths.
struct Parabola {
  double square = 0;
  double linear = 0;
  double middle = 0;

  Parabola(double first, double mid, double last)
      : square((first + last) / 2 - mid), linear((last - first) / 2), middle(mid) {}
  double operator()(double x) const { return (square * x + linear) * x + middle; }
  /// Where it is least from -1 to 1.
  double lowest_at() const {
    if (square > 0) return std::clamp(-linear / (2 * square), -1.0, 1.0);
    return linear > 0 ? -1 : 1;
  }
};

bool is_finite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

bool is_place(const Geodetic& at) {
  return std::isfinite(at.place.lon) && std::abs(at.place.lat) <= 90 && std::isfinite(at.height_m);
}

/// How far the longitudes of a piece are from that of its middle, degrees, with room for rounding. Seen from
/// the axis a straight line turns one way only, by less than half a turn: none is farther than those of its
/// ends.
double longitude_reach_deg(const Line& line, const Piece& piece) {
  const auto from_axis = [&](double t_m) { return glm::dvec2(line.at(t_m)); };
  const glm::dvec2 middle = from_axis(piece.middle_m());
  double reach = 0;
  for (const double end_m : {piece.from_m, piece.to_m}) {
    const glm::dvec2 end = from_axis(end_m);
    const double cross = middle.x * end.y - middle.y * end.x;
    reach = std::max(reach, std::abs(std::atan2(cross, glm::dot(middle, end))));
  }
  // A micrometre of rounding, seen from the axis.
  return glm::degrees(reach + 1e-6 / std::max(glm::length(middle), 1e-9)) * kWidening;
}

}  // namespace

/// The tiles, and the search along a line: pieces that pass above all ground beneath them are dropped, others
/// are split until they lie above one cell.
struct GroundQuery::State {
  Result<double> least_clearance_m(const Line& line, const Piece& piece, bool errors);
  Result<Probe> probe(const Line& line, double t_m);
  double cell_width_m(LonLat place) const;
  Result<std::optional<double>> first_meeting(const Line& line, double length_m);
  Result<std::optional<double>> meeting_in_cell(const Line& line, const Piece& piece, const Probe& first,
                                                const Probe& last);
  Result<double> meeting_between(const Line& line, Piece piece);
  Result<GroundHit> hit_at(const Line& line, double t_m);
  Status measure_clearance(const Line& line, double length_m, SightLine& sight);

  const Ellipsoid& ellipsoid() const { return tiles.pack().header().body.shape; }

  GroundTiles tiles;
};

/// A bound on how low the piece is above the ground: minus infinity is a fair answer, plus infinity says that
/// there is no ground. With `errors`, above the ground and its errors.
Result<double> GroundQuery::State::least_clearance_m(const Line& line, const Piece& piece, bool errors) {
  const glm::dvec3 middle = line.at(piece.middle_m());
  const Geodetic at = to_geodetic(middle, ellipsoid());
  // The height is a convex function along the line, so that it is nowhere below its tangent.
  const double steepness = std::abs(glm::dot(local_frame(at.place).up, line.direction));
  const double least_height_m = at.height_m - steepness * piece.half_m();
  const double radius_m =
      std::min(glm::length(middle), least_curvature_m(ellipsoid()) + std::min(at.height_m, 0.0));
  double lat_reach = 180, lon_reach = 360;
  if (piece.half_m() < radius_m / 4) {
    lat_reach = glm::degrees(std::asin(piece.half_m() / radius_m)) * kWidening;
    lon_reach = longitude_reach_deg(line, piece);
  }
  const Result<double> ceiling_m = tiles.ceiling_m(at.place, lon_reach, lat_reach, errors);
  if (!ceiling_m) return ceiling_m.error();
  return least_height_m - *ceiling_m;
}

Result<Probe> GroundQuery::State::probe(const Line& line, double t_m) {
  Probe probe;
  probe.at = to_geodetic(line.at(t_m), ellipsoid());
  const Result<const GroundTile*> tile = tiles.at(probe.at.place);
  if (!tile) return tile.error();
  if (!*tile) return probe;
  probe.tile = (*tile)->entry().id;
  probe.error_m = static_cast<double>((*tile)->entry().geometric_error_m);
  probe.cell = (*tile)->position_of(probe.at.place);
  if (const auto ground_m = (*tile)->height_m(probe.cell)) probe.above_m = probe.at.height_m - *ground_m;
  return probe;
}

/// Metres across a cell of the finest level at the place, the narrower way, but no less than near a pole.
double GroundQuery::State::cell_width_m(LonLat place) const {
  const auto levels = tiles.pack().levels(Layer::heights);
  const double degrees = tile_width_degrees(levels->finest) / (tiles.pack().header().tile_size - 1);
  const double narrowed = std::cos(glm::radians(std::min(std::abs(place.lat), kPolar_deg)));
  return glm::radians(degrees) * least_curvature_m(ellipsoid()) * narrowed;
}

/// The first distance at which the line is not above the ground.
Result<std::optional<double>> GroundQuery::State::first_meeting(const Line& line, double length_m) {
  using Answer = std::optional<double>;
  std::vector<Piece> pieces{{0, length_m}};  // the last is the nearest
  while (!pieces.empty()) {
    const Piece piece = pieces.back();
    pieces.pop_back();
    const Result<double> clearance_m = least_clearance_m(line, piece, false);
    if (!clearance_m) return clearance_m.error();
    if (*clearance_m > 0) continue;
    const Geodetic middle = to_geodetic(line.at(piece.middle_m()), ellipsoid());
    if (piece.half_m() <= cell_width_m(middle.place)) {
      const Result<Probe> first = probe(line, piece.from_m), last = probe(line, piece.to_m);
      if (!first) return first.error();
      if (!last) return last.error();
      if (first->above_m && *first->above_m <= 0) return Answer(piece.from_m);
      if (first->shares_cell(*last) || piece.half_m() < kShortest_m) {
        const Result<Answer> meeting = meeting_in_cell(line, piece, *first, *last);
        if (!meeting || *meeting) return meeting;
        continue;
      }
    }
    pieces.push_back({piece.middle_m(), piece.to_m});
    pieces.push_back({piece.from_m, piece.middle_m()});
  }
  return Answer();
}

/// The first meeting in a piece above one cell, or across an edge of cells and shorter than kShortest_m. The
/// line is above the ground where the piece begins, or there is none.
Result<std::optional<double>> GroundQuery::State::meeting_in_cell(const Line& line, const Piece& piece,
                                                                  const Probe& first, const Probe& last) {
  using Answer = std::optional<double>;
  Piece bracket = piece;
  if (!last.above_m) return Answer();
  if (!first.above_m) return *last.above_m <= 0 ? Answer(piece.to_m) : Answer();
  if (*last.above_m > 0) {
    const Result<Probe> middle = probe(line, piece.middle_m());
    if (!middle) return middle.error();
    if (!middle->above_m) return Answer();
    const Parabola above(*first.above_m, *middle->above_m, *last.above_m);
    const double lowest_at = above.lowest_at();
    if (above(lowest_at) > 0) return Answer();
    bracket.to_m = piece.middle_m() + lowest_at * piece.half_m();
    const Result<Probe> lowest = probe(line, bracket.to_m);
    if (!lowest) return lowest.error();
    if (!lowest->above_m || *lowest->above_m > 0) return Answer();
  }
  const Result<double> meeting = meeting_between(line, bracket);
  if (!meeting) return meeting.error();
  return Answer(*meeting);
}

/// Bisects a piece that begins above the ground and ends at or below it.
Result<double> GroundQuery::State::meeting_between(const Line& line, Piece piece) {
  for (int i = 0; i < 60 && piece.half_m() > 1e-7; ++i) {
    const Result<Probe> middle = probe(line, piece.middle_m());
    if (!middle) return middle.error();
    const bool is_above = middle->above_m && *middle->above_m > 0;
    (is_above ? piece.from_m : piece.to_m) = piece.middle_m();
  }
  return piece.to_m;
}

Result<GroundHit> GroundQuery::State::hit_at(const Line& line, double t_m) {
  GroundHit hit;
  hit.distance_m = t_m;
  hit.point = line.at(t_m);
  hit.at = to_geodetic(hit.point, ellipsoid());
  const Result<const GroundTile*> tile = tiles.at(hit.at.place);
  if (!tile) return tile.error();
  hit.normal = local_frame(hit.at.place).up;
  if (!*tile) return hit;
  hit.level = (*tile)->entry().id.level;
  hit.error_m = static_cast<double>((*tile)->entry().geometric_error_m);
  if (const auto normal = (*tile)->normal(hit.at.place)) hit.normal = *normal;
  return hit;
}

/// The piece that may be lowest comes first, until no other can be lower than what was found.
Status GroundQuery::State::measure_clearance(const Line& line, double length_m, SightLine& sight) {
  struct Bounded {
    double least_m = 0;
    Piece piece;
    bool operator<(const Bounded& other) const { return least_m > other.least_m; }
  };
  double clearance_m = kInfinite, with_errors_m = kInfinite;
  const auto note = [&](const Probe& probe, double above_m) {
    clearance_m = std::min(clearance_m, above_m);
    with_errors_m = std::min(with_errors_m, above_m - probe.error_m);
  };
  std::priority_queue<Bounded> pieces;
  const auto add = [&](const Piece& piece) -> Status {
    const Result<double> least_m = least_clearance_m(line, piece, true);
    if (!least_m) return least_m.error();
    if (*least_m < clearance_m) pieces.push({*least_m, piece});
    return {};
  };
  for (const double t_m : {0.0, length_m}) {
    const Result<Probe> end = probe(line, t_m);
    if (!end) return end.error();
    if (end->above_m) note(*end, *end->above_m);
  }
  if (const Status status = add({0, length_m}); !status) return status;
  while (!pieces.empty() && pieces.top().least_m < clearance_m) {
    const Piece piece = pieces.top().piece;
    pieces.pop();
    const Result<Probe> middle = probe(line, piece.middle_m());
    if (!middle) return middle.error();
    if (middle->above_m) note(*middle, *middle->above_m);
    if (piece.half_m() <= cell_width_m(middle->at.place)) {
      const Result<Probe> first = probe(line, piece.from_m), last = probe(line, piece.to_m);
      if (!first) return first.error();
      if (!last) return last.error();
      for (const Probe* end : {&*first, &*last}) {
        if (end->above_m) note(*end, *end->above_m);
      }
      const bool is_short = piece.half_m() < kShortest_m;
      if (is_short || first->shares_cell(*last)) {
        if (!is_short && first->above_m && middle->above_m && last->above_m) {
          const Parabola above(*first->above_m, *middle->above_m, *last->above_m);
          note(*middle, above(above.lowest_at()));
        }
        continue;
      }
    }
    if (const Status status = add({piece.from_m, piece.middle_m()}); !status) return status;
    if (const Status status = add({piece.middle_m(), piece.to_m}); !status) return status;
  }
  sight.clearance_m = clearance_m;
  sight.error_m = clearance_m < kInfinite ? clearance_m - with_errors_m : 0;
  return {};
}

GroundQuery::GroundQuery(std::shared_ptr<const PackReader> pack, std::size_t cached_tiles)
    : state_(new State{GroundTiles(std::move(pack), cached_tiles)}) {}
GroundQuery::GroundQuery(GroundQuery&&) noexcept = default;
GroundQuery& GroundQuery::operator=(GroundQuery&&) noexcept = default;
GroundQuery::~GroundQuery() = default;

Result<std::optional<GroundHit>> GroundQuery::ray(const glm::dvec3& origin, const glm::dvec3& direction,
                                                  double farthest_m) {
  using Answer = std::optional<GroundHit>;
  const double length = glm::length(direction);
  if (!is_finite(origin) || !std::isfinite(length) || length == 0) {
    return usage_error("ray: expected a finite origin and a finite direction that is not 0, found others");
  }
  if (!(farthest_m >= 0 && farthest_m < kInfinite)) {
    return usage_error("ray: expected a finite length of 0 or more, found " + std::to_string(farthest_m));
  }
  const Line line{origin, direction / length};
  const Result<std::optional<double>> meeting = state_->first_meeting(line, farthest_m);
  if (!meeting) return meeting.error();
  if (!*meeting) return Answer();
  const Result<GroundHit> hit = state_->hit_at(line, **meeting);
  if (!hit) return hit.error();
  return Answer(*hit);
}

Result<SightLine> GroundQuery::line_of_sight(const Geodetic& from, const Geodetic& to) {
  if (!is_place(from) || !is_place(to)) {
    return usage_error("line of sight: expected two finite places, found others");
  }
  const glm::dvec3 begin = to_geocentric(from.place, from.height_m, state_->ellipsoid());
  const glm::dvec3 way = to_geocentric(to.place, to.height_m, state_->ellipsoid()) - begin;
  const double length_m = glm::length(way);
  const Line line{begin, length_m > 0 ? way / length_m : local_frame(from.place).up};
  SightLine sight;
  const Result<std::optional<double>> meeting = state_->first_meeting(line, length_m);
  if (!meeting) return meeting.error();
  if (*meeting) {
    const Result<GroundHit> hit = state_->hit_at(line, **meeting);
    if (!hit) return hit.error();
    sight.is_clear = false;
    sight.obstacle = *hit;
  }
  if (const Status status = state_->measure_clearance(line, length_m, sight); !status) return status.error();
  return sight;
}

Result<std::optional<glm::dvec3>> GroundQuery::normal(LonLat place) {
  using Answer = std::optional<glm::dvec3>;
  if (!std::isfinite(place.lon) || !(std::abs(place.lat) <= 90)) {
    return usage_error("normal: expected a finite place, found another");
  }
  const Result<const GroundTile*> tile = state_->tiles.at(place);
  if (!tile) return tile.error();
  return *tile ? (*tile)->normal(place) : Answer();
}

}  // namespace cairn
