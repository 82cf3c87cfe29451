#include "runtime/light/tile_shadow.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "cairn/geodesy.h"
#include "runtime/surface/axis_table.h"

namespace cairn {
namespace {

constexpr double kFarthest_m = 400e3;
constexpr double kStepShare = 0.004;  // of the distance, between far samples
constexpr double kLit_deg = 80;       // of the sun's height, above which no ground is in the way
constexpr double kDark_deg = -8;      // below which all is: a mountain of 60 km would be needed
constexpr double kWidestBlock_deg = 1;
constexpr int kLeastBlock = 64;  // cells
// Towards the place where the sun stands in the zenith, the light's direction turns: a block is no wider than
// this share of the way there, unless it has so few cells.
constexpr double kShareOfZenith = 0.25;
constexpr int kLeastBlockAtZenith = 8;
constexpr double kMostSlope = 8;

/// A place in the plane of a line of light: metres towards the sun and up, at the middle of the block.
struct ProfilePoint {
  double ahead = 0;
  double up = 0;
};

/// The upper hull of what lies ahead on a line, its nearest point last.
class Hull {
 public:
  void clear() { points_.clear(); }
  /// Returns the steepest slope from the point up to what lies ahead, and adds the point, which is nearer
  /// than all before it.
  double add(const ProfilePoint& p) {
    const auto slope = [&](const ProfilePoint& to) {
      return (to.up - p.up) / std::max(to.ahead - p.ahead, 1e-3);
    };
    while (points_.size() > 1 && slope(points_[points_.size() - 2]) >= slope(points_.back()))
      points_.pop_back();
    const double steepest = points_.empty() ? -kMostSlope : slope(points_.back());
    points_.push_back(p);
    return steepest;
  }

 private:
  std::vector<ProfilePoint> points_;
};

/// Where the sun stands over the middle of a block of samples, and the plane of its light.
struct SunPlane {
  glm::dvec3 to_sun;
  double height_rad;  // of the sun
  double cosine;      // of that height
  double sine;

  SunPlane(const glm::dvec3& sun, LonLat middle) : to_sun(sun) {
    sine = std::clamp(glm::dot(local_frame(middle).up, sun), -1.0, 1.0);
    height_rad = std::asin(sine);
    cosine = std::cos(height_rad);
  }
  /// `along` is the distance along the light, `aside` that from the axis through the body's middle.
  ProfilePoint point(double along, double aside) const {
    // Towards the sun and level is (cosine, -sine) in these two, up is (sine, cosine).
    return {along * cosine - aside * sine, along * sine + aside * cosine};
  }
};

class BlockShadow {
 public:
  BlockShadow(ShadowGround& ground, const TileId& id, const HeightTile& heights, const glm::dvec3& to_sun,
              std::vector<std::int8_t>& out)
      : reader_(ground),
        ellipsoid_(ground.pack().header().body.shape),
        quantum_m_(ground.pack().header().quantum_m),
        highest_m_(ground.highest_m()),
        id_(id),
        bounds_(tile_bounds(id)),
        heights_(heights),
        to_sun_(to_sun),
        columns_(column_table(id.level, id.x, heights.size)),
        rows_(row_table(id.level, id.y, heights.size, ellipsoid_)),
        lowest_m_(range_of(heights).lowest * quantum_m_),
        out_(out) {
    cell_deg_ = bounds_.width() / (heights.size - 1);
    cell_m_ = glm::radians(cell_deg_) * ellipsoid_.semi_minor_m;
  }

  /// Samples first to first + side, last included, of both axes.
  void run(int west, int south, int side);

 private:
  /// A line towards the sun: its minor coordinate, in cells, at a number of steps away from the sun's side.
  struct Line {
    double start, slope, bend;
    double at(double k) const { return start + k * (slope + k * bend); }
  };

  LonLat place(double column, double row) const {
    return {bounds_.west + column * cell_deg_, bounds_.south + row * cell_deg_};
  }
  glm::dvec2 cells_per_metre(double column, double row) const;
  double slope_at(double minor, double k) const;
  /// The column and row of a minor coordinate, k steps from the sun's side.
  glm::dvec2 in_tile(double minor, double k) const {
    const double major = steps_down_ ? side_ - k : k;
    return by_rows_ ? glm::dvec2(west_ + minor, south_ + major) : glm::dvec2(west_ + major, south_ + minor);
  }
  double height_m(double minor, int k) const;
  ProfilePoint profile_point(const SunPlane& sun, double minor, int k, double height) const;
  void add_far_ground(const SunPlane& sun, const glm::dvec2& start, Hull& hull);
  void fill(std::int8_t value);
  std::int8_t& out(int minor, int k) {
    const glm::dvec2 at = in_tile(minor, k);
    return out_[static_cast<std::size_t>(at.y) * static_cast<std::size_t>(heights_.size) +
                static_cast<std::size_t>(at.x)];
  }

  ShadowGroundReader reader_;
  Ellipsoid ellipsoid_;
  double quantum_m_, highest_m_;
  TileId id_;
  GeoBounds bounds_;
  const HeightTile& heights_;
  glm::dvec3 to_sun_;
  std::vector<ColumnEntry> columns_;
  std::vector<RowEntry> rows_;
  double lowest_m_;
  double cell_deg_ = 0, cell_m_ = 0;
  std::vector<std::int8_t>& out_;

  int west_ = 0, south_ = 0, side_ = 0;  // of the block
  bool by_rows_ = true;                  // a step along a line is a row, else a column
  bool steps_down_ = true;               // the sun's side is the northern or eastern one
  std::vector<ProfilePoint> far_;
};

/// How many columns and rows a metre towards the sun is.
glm::dvec2 BlockShadow::cells_per_metre(double column, double row) const {
  const LonLat at = place(column, std::min(row, (90 - bounds_.south) / cell_deg_));
  const LocalFrame frame = local_frame(at);
  const double f = ellipsoid_.flattening(), e2 = f * (2 - f);
  const double sine = std::sin(glm::radians(at.lat));
  const double w = 1 - e2 * sine * sine;
  const double across = ellipsoid_.semi_major_m / std::sqrt(w), along = across * (1 - e2) / w;
  const double cosine = std::max(std::cos(glm::radians(at.lat)), 1e-6);
  const double per_cell = glm::radians(cell_deg_);
  return {glm::dot(to_sun_, frame.east) / (across * cosine * per_cell),
          glm::dot(to_sun_, frame.north) / (along * per_cell)};
}

/// How far a line's minor coordinate moves in a step away from the sun's side.
double BlockShadow::slope_at(double minor, double k) const {
  const glm::dvec2 at = in_tile(minor, k);
  const glm::dvec2 d = cells_per_metre(at.x, at.y);
  const double major = by_rows_ ? d.y : d.x, aside = by_rows_ ? d.x : d.y;
  return std::clamp(-aside / std::max(std::abs(major), 1e-12), -4.0, 4.0);
}

double BlockShadow::height_m(double minor, int k) const {
  const double within = std::clamp(minor, 0.0, static_cast<double>(side_));
  const int first = std::min(static_cast<int>(within), side_ - 1);
  const double part = within - first;
  const glm::dvec2 a = in_tile(first, k), b = in_tile(first + 1, k);
  const auto sample = [&](const glm::dvec2& at) {
    const int column = static_cast<int>(at.x), row = static_cast<int>(at.y);
    return heights_.is_void(column, row) ? std::numeric_limits<double>::quiet_NaN()
                                         : heights_.at(column, row) * quantum_m_;
  };
  if (part == 0) return sample(a);
  return sample(a) * (1 - part) + sample(b) * part;
}

ProfilePoint BlockShadow::profile_point(const SunPlane& sun, double minor, int k, double height) const {
  const double within = std::clamp(minor, 0.0, static_cast<double>(side_));
  const int first = std::min(static_cast<int>(within), side_ - 1);
  const double part = within - first;
  const glm::dvec2 a = in_tile(first, k), b = in_tile(first + 1, k);
  const ColumnEntry column =
      columns_[static_cast<std::size_t>(a.x)] * (1 - part) + columns_[static_cast<std::size_t>(b.x)] * part;
  const RowEntry row =
      rows_[static_cast<std::size_t>(a.y)] * (1 - part) + rows_[static_cast<std::size_t>(b.y)] * part;
  const glm::dvec3 position = position_of(column, row, height);
  const double along = glm::dot(position, to_sun_);
  return sun.point(along, std::sqrt(std::max(glm::dot(position, position) - along * along, 0.0)));
}

/// Walks along the light from the block's side, and adds the ground beneath it from far to near.
void BlockShadow::add_far_ground(const SunPlane& sun, const glm::dvec2& start, Hull& hull) {
  far_.clear();
  const glm::dvec3 origin = to_geocentric(place(start.x, start.y), lowest_m_, ellipsoid_);
  const double begin = glm::dot(origin, to_sun_);
  const glm::dvec3 aside = origin - begin * to_sun_;
  const double from_axis = glm::length(aside);
  const glm::dvec3 outwards = aside / from_axis;
  const double level = std::max(sun.cosine, 0.15);
  struct Node {
    double lon = 0, lat = 0, height = 0, up_along = 0, up_outwards = 0;
  };
  const auto node_at = [&](double distance) {
    const Geodetic at = to_geodetic(origin + to_sun_ * (distance / level), ellipsoid_);
    const glm::dvec3 up = local_frame(at.place).up;
    return Node{at.place.lon, at.place.lat, at.height_m, glm::dot(up, to_sun_), glm::dot(up, outwards)};
  };
  double distance = cell_m_;
  Node node = node_at(distance);
  while (distance < kFarthest_m && !(node.height > highest_m_ && node.up_along > 0)) {
    const double step = std::max(cell_m_, kStepShare * distance);
    const int count = std::clamp(static_cast<int>(4000 / step), 1, 8);
    Node next = node_at(distance + step * count);
    next.lon = node.lon + std::remainder(next.lon - node.lon, 360.0);
    const int coarser = std::max(static_cast<int>(std::log2(step / cell_m_)), 0);
    for (int i = 0; i < count; ++i) {
      const double part = static_cast<double>(i) / count, rest = 1 - part;
      const double height =
          reader_.height_m({node.lon * rest + next.lon * part, node.lat * rest + next.lat * part},
                           std::max(id_.level - coarser, kMinLevel));
      if (std::isnan(height)) continue;
      const double above = height - (node.height * rest + next.height * part);
      const double t = (distance + step * i) / level;
      far_.push_back(sun.point(begin + t + above * (node.up_along * rest + next.up_along * part),
                               from_axis + above * (node.up_outwards * rest + next.up_outwards * part)));
    }
    distance += step * count;
    node = next;
  }
  for (auto point = far_.rbegin(); point != far_.rend(); ++point) hull.add(*point);
}

void BlockShadow::fill(std::int8_t value) {
  for (int k = 0; k <= side_; ++k) {
    for (int minor = 0; minor <= side_; ++minor) out(minor, k) = value;
  }
}

std::int8_t texel_of(double angle_deg) {
  return static_cast<std::int8_t>(std::lround(std::clamp(angle_deg / kShadowRange_deg, -1.0, 1.0) * 127));
}

void BlockShadow::run(int west, int south, int side) {
  west_ = west;
  south_ = south;
  side_ = side;
  const SunPlane sun(to_sun_, place(west + side / 2.0, south + side / 2.0));
  const double height_deg = glm::degrees(sun.height_rad), reach_deg = side * cell_deg_;
  if (height_deg - reach_deg > kLit_deg) return fill(-127);
  if (reach_deg > kShareOfZenith * (90 - height_deg)) {
    if (side > kLeastBlockAtZenith) {
      for (int quarter = 0; quarter < 4; ++quarter) {
        run(west + (quarter & 1) * side / 2, south + (quarter >> 1) * side / 2, side / 2);
      }
      return;
    }
    if (height_deg > kLit_deg) return fill(-127);
  }
  if (height_deg + reach_deg < kDark_deg) return fill(127);
  const glm::dvec2 towards = cells_per_metre(west + side / 2.0, south + side / 2.0);
  by_rows_ = std::abs(towards.y) >= std::abs(towards.x);
  steps_down_ = (by_rows_ ? towards.y : towards.x) > 0;
  // Lines begin on the sun's side or beyond its ends, a cell apart, until all of the block is covered.
  const double slopes[] = {slope_at(0, 0), slope_at(side, 0), slope_at(0, side), slope_at(side, side)};
  const double steepest = *std::max_element(std::begin(slopes), std::end(slopes));
  const double least = *std::min_element(std::begin(slopes), std::end(slopes));
  const int first = static_cast<int>(std::floor(std::min(0.0, -steepest * side))) - 1;
  const int last = static_cast<int>(std::ceil(side + std::max(0.0, -least * side))) + 1;
  const auto count = static_cast<std::size_t>(side) + 1;
  std::vector<double> before_at(count, -1e9), before(count, -kShadowRange_deg);
  Hull hull;
  for (int start = first; start <= last; ++start) {
    const double a = slope_at(start, 0), b = slope_at(start + a * side, side);
    const Line line{static_cast<double>(start), a, (b - a) / (2 * side)};
    hull.clear();
    bool has_begun = false;
    for (int k = 0; k <= side; ++k) {
      const double x = line.at(k);
      const auto index = static_cast<std::size_t>(k);
      if (x < -2 || x > side + 2) {
        before_at[index] = x;
        before[index] = -kShadowRange_deg;
        continue;
      }
      if (!has_begun) {
        add_far_ground(sun, in_tile(std::clamp(x, 0.0, static_cast<double>(side)), k), hull);
        has_begun = true;
      }
      const double height = height_m(x, k);
      double angle_deg = -kShadowRange_deg;
      if (!std::isnan(height)) {
        const double slope = hull.add(profile_point(sun, x, k, height));
        angle_deg =
            std::clamp(glm::degrees(std::atan(slope) - sun.height_rad), -kShadowRange_deg, kShadowRange_deg);
      }
      const double from = before_at[index];
      for (int i = std::max(static_cast<int>(std::floor(from)) + 1, 0); i <= side && i <= x; ++i) {
        const double part = from < -2 ? 1 : (i - from) / (x - from);
        out(i, k) = texel_of(before[index] * (1 - part) + angle_deg * part);
      }
      before_at[index] = x;
      before[index] = angle_deg;
    }
  }
}

}  // namespace

std::vector<std::int8_t> tile_shadow(ShadowGround& ground, const TileId& id, const HeightTile& heights,
                                     const glm::dvec3& to_sun) {
  const auto samples = static_cast<std::size_t>(heights.size) * static_cast<std::size_t>(heights.size);
  std::vector<std::int8_t> out(samples, -127);
  BlockShadow block(ground, id, heights, to_sun, out);
  // In a wide tile lines towards the sun are not straight: it is done in blocks.
  const int cells = heights.size - 1;
  int side = cells;
  while (side > kLeastBlock && tile_width_degrees(id.level) * side / cells > kWidestBlock_deg) side /= 2;
  for (int south = 0; south < cells; south += side) {
    for (int west = 0; west < cells; west += side) block.run(west, south, side);
  }
  return out;
}

}  // namespace cairn
