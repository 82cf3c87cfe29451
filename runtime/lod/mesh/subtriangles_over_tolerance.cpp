#include "runtime/lod/mesh/subtriangles_over_tolerance.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <glm/geometric.hpp>

#include "format/simd_clones.h"

namespace cairn {
namespace {

// Loops over parts must read consecutive values, so that the compiler makes vectors of them. So each point
// where a triangle's lines meet is stored twice: once as a near corner of parts, row after row along p, and
// once as a far corner. Part m has the points m, m + 1, kFar + m and kFar + m + 1. Each row ends with a lane
// that is no part; a far corner beyond the base is moved onto the base.
constexpr std::size_t kSteps = SubtriangleErrorRanges::kSteps;
constexpr std::size_t kLanes = 16;
constexpr std::size_t kFar = 15;
constexpr std::size_t kPoints = 32;

/// Returns the first lane of row j.
constexpr std::size_t row_at(std::size_t j) {
  return j * (kSteps + 1) - j * (j - 1) / 2;
}
constexpr std::array<std::size_t, SubtriangleErrorRanges::kParts> kLaneOf{0, 1, 2, 3, 5, 6, 7, 9, 10, 12};
static_assert(kLaneOf[4] == row_at(1) && kLaneOf[7] == row_at(2) && kLaneOf[9] == row_at(3));
static_assert(row_at(kSteps) <= kFar && kFar + kLanes < kPoints);

using Points = std::array<float, kPoints>;

/// Multiplied with a negative depth, gives a negative headroom that no tolerance makes up for.
constexpr float kBehindPenalty = 1e20f;

/// Bound of the relative rounding error of a few operations in single precision.
constexpr float kRounding = 1e-6f;

/// For each point, the barycentric weights of p and q, and the values of the quadratics that are 1 at the
/// middle of one edge and 0 at the other middles and at the corners.
struct Weights {
  Points p{}, q{};
  Points base{}, along_q{}, along_p{};
};

constexpr Weights weights() {
  Weights w;
  const auto set = [&w](std::size_t n, std::size_t i, std::size_t j) {
    const float p = static_cast<float>(i) / kSteps, q = static_cast<float>(j) / kSteps, c = 1 - p - q;
    w.p[n] = p, w.q[n] = q;
    w.base[n] = 4 * p * q, w.along_q[n] = 4 * c * q, w.along_p[n] = 4 * c * p;
  };
  for (std::size_t j = 0; j < kSteps; ++j) {
    for (std::size_t i = 0; i + j <= kSteps; ++i) {
      set(row_at(j) + i, i, j);
      set(kFar + row_at(j) + i, i, std::min(j + 1, kSteps - i));
    }
  }
  return w;
}
constexpr Weights kWeights = weights();

struct Vec {
  float x, y, z;
};

Vec to_float(const glm::dvec3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

/// A triangle in single precision: values at the right angle, and their increments along p and q.
struct TriangleF32 {
  explicit TriangleF32(const FlatTriangle& t)
      : drawn{to_float(t.corners[2]), to_float(t.corners[0] - t.corners[2]),
              to_float(t.corners[1] - t.corners[2])},
        up{to_float(t.ups[2]), to_float(t.ups[0] - t.ups[2]), to_float(t.ups[1] - t.ups[2])},
        bulge{to_float(t.bulges[2]), to_float(t.bulges[0] - t.bulges[2]),
              to_float(t.bulges[1] - t.bulges[2])} {
    const std::array<glm::dvec3, 3> bends = quadratic_bulges(t);
    for (std::size_t i = 0; i < 3; ++i) bend[i] = to_float(bends[i]);
  }
  Vec drawn[3];
  Vec up[3];
  Vec bulge[3];
  Vec bend[3];  ///< quadratic_bulges()
};

/// Values at the points. "Across the ray", a displacement d is (dx − tx·dz, dy − ty·dz).
struct PointsAt {
  Points z;                          ///< Dz
  Points tx, ty;                     ///< D⊥/Dz
  Points rounding;                   ///< bound of the rounding error of tx and ty
  Points bulge_x, bulge_y, bulge_z;  ///< Q; x and y across the ray
  Points up_x, up_y, up_z;
  Points x, y, deep;             ///< S(h) in the camera
  Points headroom, headroom_up;  ///< the tolerance at S(h), and how much less it is per metre of e
};

float least(float a, float b) {
  return a < b ? a : b;
}
float most(float a, float b) {
  return a > b ? a : b;
}
float absolute(float a) {
  return std::abs(a);
}

float largest(const Vec& v) {
  return std::max(std::max(std::abs(v.x), std::abs(v.y)), std::abs(v.z));
}

[[gnu::always_inline]] inline void evaluate_points(const TriangleF32& t, float tolerance, float nearest,
                                                   PointsAt& at) {
  const float far = largest(t.drawn[0]) + largest(t.drawn[1]) + largest(t.drawn[2]);
  Points deep;  // an array of its own, or the compiler makes a branch of the maximum
  for (std::size_t n = 0; n < kPoints; ++n) {
    const float p = kWeights.p[n], q = kWeights.q[n];
    const float x = t.drawn[0].x + p * t.drawn[1].x + q * t.drawn[2].x;
    const float y = t.drawn[0].y + p * t.drawn[1].y + q * t.drawn[2].y;
    const float z = t.drawn[0].z + p * t.drawn[1].z + q * t.drawn[2].z;
    at.z[n] = z, at.tx[n] = x, at.ty[n] = y, deep[n] = most(z, nearest);
  }
  for (std::size_t n = 0; n < kPoints; ++n) {
    const float p = kWeights.p[n], q = kWeights.q[n];
    const float inverse = 1 / deep[n], tx = at.tx[n] * inverse, ty = at.ty[n] * inverse;
    const float b = kWeights.base[n], bq = kWeights.along_q[n], bp = kWeights.along_p[n];
    const float bx = t.bulge[0].x + p * t.bulge[1].x + q * t.bulge[2].x + b * t.bend[0].x + bq * t.bend[1].x +
                     bp * t.bend[2].x;
    const float by = t.bulge[0].y + p * t.bulge[1].y + q * t.bulge[2].y + b * t.bend[0].y + bq * t.bend[1].y +
                     bp * t.bend[2].y;
    const float bz = t.bulge[0].z + p * t.bulge[1].z + q * t.bulge[2].z + b * t.bend[0].z + bq * t.bend[1].z +
                     bp * t.bend[2].z;
    const float ux = t.up[0].x + p * t.up[1].x + q * t.up[2].x;
    const float uy = t.up[0].y + p * t.up[1].y + q * t.up[2].y;
    const float uz = t.up[0].z + p * t.up[1].z + q * t.up[2].z;
    at.tx[n] = tx, at.ty[n] = ty;
    at.rounding[n] = kRounding * far * inverse;
    at.bulge_x[n] = bx - tx * bz, at.bulge_y[n] = by - ty * bz, at.bulge_z[n] = bz;
    at.x[n] = tx * deep[n] - bx, at.y[n] = ty * deep[n] - by, at.deep[n] = at.z[n] - bz;
    at.headroom[n] = least(tolerance * at.deep[n], (at.z[n] - nearest) * kBehindPenalty),
    at.headroom_up[n] = tolerance * uz;
    at.up_x[n] = ux - tx * uz, at.up_y[n] = uy - ty * uz, at.up_z[n] = uz;
  }
}

/// Returns √(x²+y²) or up to a twelfth more.
float length_or_more(float x, float y) {
  const float a = absolute(x), b = absolute(y);
  return most(a, b) + 0.41422f * least(a, b);
}

struct Lanes {
  std::array<float, kLanes> low{}, high{};
  std::array<std::int32_t, kLanes> over{};
};

/// A part's own bulge, as a fraction of the whole triangle's: it falls with the square of the size.
constexpr float kPartBulgeShare = 1.0f / (kSteps * kSteps);

[[gnu::always_inline]] inline void mark_over_tolerance(const TriangleF32& t, const PointsAt& at,
                                                       float tolerance, float nearest, float slack,
                                                       Lanes& lanes) {
  const float bulge_z =
      kPartBulgeShare * most(most(absolute(t.bend[0].z), absolute(t.bend[1].z)), absolute(t.bend[2].z));
  for (std::size_t n = 0; n < kLanes; ++n) {
    const std::size_t a = n, b = n + 1, c = n + kFar, d = n + kFar + 1;
    const float low = lanes.low[n], high = lanes.high[n];
    const auto over_corners = [&](const Points& of, auto choose) {
      return choose(choose(of[a], of[b]), choose(of[c], of[d]));
    };
    const float least_x = over_corners(at.tx, least), most_x = over_corners(at.tx, most);
    const float least_y = over_corners(at.ty, least), most_y = over_corners(at.ty, most);
    const float spread = length_or_more(most_x - least_x, most_y - least_y) + over_corners(at.rounding, most);
    const float slanting = length_or_more(most(most_x, -least_x), most(most_y, -least_y));
    // √(1+x²) <= 1 + 0.4143x up to 1, and x + 0.4143 beyond.
    const float slant = most(1 + 0.4143f * slanting, slanting + 0.4143f);
    // As Σ wᵢDᵢz(tᵢ − t) = 0, any multiple of Dᵢz may be subtracted from dᵢz before ω is applied to it.
    const auto differs = [&](const Points& of) {
      const float mean =
          ((of[a] + of[b]) + (of[c] + of[d])) / most((at.z[a] + at.z[b]) + (at.z[c] + at.z[d]), nearest);
      const auto by = [&](std::size_t k) { return absolute(of[k] - mean * at.z[k]); };
      return most(most(by(a), by(b)), most(by(c), by(d)));
    };
    const float deep = differs(at.bulge_z) + most(absolute(low), absolute(high)) * differs(at.up_z);
    const auto bulge = [&](const Vec& v) {
      return length_or_more(v.x - at.tx[a] * v.z, v.y - at.ty[a] * v.z);
    };
    const float base = bulge(t.bend[0]), q = bulge(t.bend[1]), p = bulge(t.bend[2]);
    const float curved = kPartBulgeShare * most(p + q, 4.0f / 3 * most(base, most(p, q)));
    const float margin =
        spread * (deep + 2 * bulge_z) + curved + slack * (slant + tolerance) + 2 * bulge_z * tolerance;
    const auto exceeds = [&](std::size_t k, float e) {
      const float x = at.bulge_x[k] + e * at.up_x[k], y = at.bulge_y[k] + e * at.up_y[k];
      const float headroom = at.headroom[k] - e * at.headroom_up[k] - margin;
      return static_cast<int>(headroom < 0) | static_cast<int>(x * x + y * y > headroom * headroom);
    };
    lanes.over[n] = exceeds(a, low) | exceeds(a, high) | exceeds(b, low) | exceeds(b, high) |
                    exceeds(c, low) | exceeds(c, high) | exceeds(d, low) | exceeds(d, high);
  }
}

/// Clears the parts that are certainly outside the viewport.
[[gnu::always_inline]] inline void clear_outside_viewport(const TriangleF32& t, const PointsAt& at,
                                                          float half_width, float half_height, float slack,
                                                          Lanes& lanes) {
  const float wide = length_or_more(1, half_width), high = length_or_more(1, half_height);
  const float curved =
      2 * kPartBulgeShare * 1.7321f * most(most(largest(t.bend[0]), largest(t.bend[1])), largest(t.bend[2]));
  for (std::size_t n = 0; n < kLanes; ++n) {
    // The least distance of the part's corners beyond one side of the viewport.
    const auto beyond = [&](const Points& of, float sign, float half) {
      const auto by = [&](std::size_t k) { return sign * of[k] - half * at.deep[k]; };
      return least(least(by(n), by(n + 1)), least(by(n + kFar), by(n + kFar + 1)));
    };
    const float reach = most(absolute(lanes.low[n]), absolute(lanes.high[n])) + curved + slack;
    const int is_outside = static_cast<int>(beyond(at.x, 1, half_width) > reach * wide) |
                           static_cast<int>(beyond(at.x, -1, half_width) > reach * wide) |
                           static_cast<int>(beyond(at.y, 1, half_height) > reach * high) |
                           static_cast<int>(beyond(at.y, -1, half_height) > reach * high);
    lanes.over[n] &= ~is_outside;
  }
}

CAIRN_SIMD_CLONES_512 void test_subtriangles(const FlatTriangle& triangle,
                                             const SubtriangleErrorRanges::Ranges& ranges,
                                             const SubtriangleViewport& viewport, double tolerance,
                                             double beyond_m, Lanes& lanes) {
  const TriangleF32 t(triangle);
  const auto nearest = static_cast<float>(viewport.nearest_m), allowed = static_cast<float>(tolerance);
  PointsAt at;
  evaluate_points(t, allowed, nearest, at);
  const auto beyond = static_cast<float>(beyond_m), unit = ranges.unit_m;
  std::array<float, SubtriangleErrorRanges::kParts> low, high;
  for (std::size_t i = 0; i < SubtriangleErrorRanges::kParts; ++i) {
    low[i] = static_cast<float>(ranges.least[i]) * unit - beyond;
    high[i] = static_cast<float>(ranges.most[i]) * unit + beyond;
  }
  for (std::size_t part = 0; part < SubtriangleErrorRanges::kParts; ++part)
    lanes.low[kLaneOf[part]] = low[part], lanes.high[kLaneOf[part]] = high[part];
  float bulge = 0;
  for (std::size_t i = 0; i < 3; ++i) bulge += largest(t.bulge[i]) + largest(t.bend[i]);
  const float slack = static_cast<float>(triangle.slack_m) +
                      4 * kRounding * (static_cast<float>(ranges.largest_m() + beyond_m) + bulge);
  mark_over_tolerance(t, at, allowed, nearest, slack, lanes);
  if (!viewport.contains_triangle) {
    clear_outside_viewport(t, at, static_cast<float>(viewport.half_width),
                           static_cast<float>(viewport.half_height), slack, lanes);
  }
}

}  // namespace

std::array<glm::dvec3, 3> quadratic_bulges(const FlatTriangle& t) {
  return {t.middle_bulges[0] - (t.bulges[0] + t.bulges[1]) / 2.0,
          t.middle_bulges[1] - (t.bulges[1] + t.bulges[2]) / 2.0,
          t.middle_bulges[2] - (t.bulges[2] + t.bulges[0]) / 2.0};
}

std::uint32_t subtriangles_over_tolerance(const FlatTriangle& triangle,
                                          const SubtriangleErrorRanges::Ranges& ranges,
                                          const SubtriangleViewport& viewport, double tolerance,
                                          double beyond_m) {
  Lanes lanes;
  test_subtriangles(triangle, ranges, viewport, tolerance, beyond_m, lanes);
  std::uint32_t over = 0;
  for (std::size_t part = 0; part < SubtriangleErrorRanges::kParts; ++part)
    over |= static_cast<std::uint32_t>(lanes.over[kLaneOf[part]]) << part;
  return over;
}

}  // namespace cairn
