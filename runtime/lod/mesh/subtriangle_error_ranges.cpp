#include "runtime/lod/mesh/subtriangle_error_ranges.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>

#include "format/rqt_steps.h"
#include "runtime/lod/mesh/sample_rows.h"

namespace cairn {
namespace {

using Corner = SubtriangleErrorRanges::Corner;
using Triangle = SubtriangleErrorRanges::Triangle;

struct Range {
  double low = HUGE_VAL;
  double high = -HUGE_VAL;
};

/// Measures how far flat triangles are above the samples of a tile, in quanta.
class TriangleResiduals {
 public:
  TriangleResiduals(const HeightTile& heights, bool between_samples)
      : heights_(heights), between_samples_(between_samples), rows_(static_cast<std::size_t>(heights.size)) {}

  std::array<Range, SubtriangleErrorRanges::kParts> measure(const Triangle& triangle) {
    lay_through(triangle);
    std::array<Range, SubtriangleErrorRanges::kParts> ranges;
    for (std::size_t part = 0; part < ranges.size(); ++part)
      ranges[part] = measure_part(SubtriangleErrorRanges::corners_of(triangle, part));
    return ranges;
  }

 private:
  /// Lays the plane h = at_origin + east·column + north·row through the corners.
  void lay_through(const Triangle& triangle) {
    const auto& [a, b, c] = triangle;
    const double px = a[0] - c[0], py = a[1] - c[1], qx = b[0] - c[0], qy = b[1] - c[1];
    const double area = px * qy - py * qx, p = height(a) - height(c), q = height(b) - height(c);
    east_ = (p * qy - q * py) / area;
    north_ = (q * px - p * qx) / area;
    at_origin_ = height(c) - east_ * c[0] - north_ * c[1];
  }

  Range measure_part(std::span<const Corner> corners) {
    Range range;
    for (const SampleRow& row : rows_of(corners, rows_)) {
      const std::int32_t* quanta =
          &heights_.samples[static_cast<std::size_t>(row.row) * static_cast<std::size_t>(heights_.size)];
      for (int column = row.column; column < row.column + row.count; ++column) {
        const double above = at_origin_ + east_ * column + north_ * row.row - quanta[column];
        range.low = std::min(range.low, above);
        range.high = std::max(range.high, above);
      }
    }
    if (between_samples_) widen_by_edges(corners, range);
    return range;
  }

  /// Widens the range so that it holds between samples. The plane is farther from the bilinear surface there
  /// only where the part ends on diagonals of cells, by at most a quarter of the twist of these cells.
  void widen_by_edges(std::span<const Corner> corners, Range& range) const {
    double twist = 0;
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const Corner &from = corners[k], &to = corners[(k + 1) % corners.size()];
      const int columns = to[0] - from[0], rows = to[1] - from[1];
      if (columns == 0 || rows == 0) continue;
      const int dc = columns > 0 ? 1 : -1, dr = rows > 0 ? 1 : -1;
      for (int i = 0; i < std::abs(columns); ++i) {
        const int c = from[0] + i * dc, r = from[1] + i * dr;
        twist = std::max(twist, std::abs(height({c, r}) + height({c + dc, r + dr}) - height({c + dc, r}) -
                                         height({c, r + dr})));
      }
    }
    range.low -= twist / 4;
    range.high += twist / 4;
  }

  double height(const Corner& at) const { return heights_.at(at[0], at[1]); }

  const HeightTile& heights_;
  bool between_samples_;
  std::vector<SampleRow> rows_;
  double at_origin_ = 0;
  double east_ = 0;
  double north_ = 0;
};

SubtriangleErrorRanges::Ranges encode(const std::array<Range, SubtriangleErrorRanges::kParts>& parts,
                                      double quantum_m) {
  double most = 0;
  for (const Range& part : parts) most = std::max({most, -part.low, part.high});
  SubtriangleErrorRanges::Ranges ranges;
  ranges.unit_m =
      std::nextafter(static_cast<float>(most * quantum_m / SubtriangleErrorRanges::kMaxCode), HUGE_VALF);
  const double per_quantum = quantum_m / static_cast<double>(ranges.unit_m);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    ranges.least[i] = static_cast<std::int16_t>(std::floor(parts[i].low * per_quantum));
    ranges.most[i] = static_cast<std::int16_t>(std::ceil(parts[i].high * per_quantum));
  }
  return ranges;
}

/// Returns the six triangles of a square of s cells, in the order of slot().
std::array<Triangle, 6> triangles_of(const Corner& south_west, int s, bool rises) {
  const auto [west, south] = south_west;
  const std::array<Corner, 4> corners{
      {{west, south}, {west + s, south}, {west + s, south + s}, {west, south + s}}};
  const Corner centre{west + s / 2, south + s / 2};
  // The right angle of a half is the corner that is not on the diagonal: the southern one, then the northern.
  const std::size_t lower = rises ? 1 : 0, upper = lower + 2;
  return {{{corners[lower + 1], corners[(lower + 3) % 4], corners[lower]},
           {corners[(upper + 1) % 4], corners[(upper + 3) % 4], corners[upper]},
           {corners[0], corners[1], centre},
           {corners[1], corners[2], centre},
           {corners[2], corners[3], centre},
           {corners[3], corners[0], centre}}};
}

}  // namespace

std::array<Corner, 4> SubtriangleErrorRanges::corners_of(const Triangle& triangle, std::size_t part) {
  int j = 0, i = static_cast<int>(part);
  for (; i >= kSteps - j; ++j) i -= kSteps - j;
  const Corner &a = triangle[0], &b = triangle[1], &c = triangle[2];
  const auto at = [&](int along_p, int along_q) {
    return Corner{c[0] + (along_p * (a[0] - c[0]) + along_q * (b[0] - c[0])) / kSteps,
                  c[1] + (along_p * (a[1] - c[1]) + along_q * (b[1] - c[1])) / kSteps};
  };
  return {at(i, j), at(i + 1, j), i + j + 1 < kSteps ? at(i + 1, j + 1) : at(i + 1, j), at(i, j + 1)};
}

SubtriangleErrorRanges::SubtriangleErrorRanges(const HeightTile& heights, const TileId& id, double quantum_m,
                                               bool between_samples)
    : levels_(std::bit_width(static_cast<unsigned>(heights.size - 1)) - 1) {
  TriangleResiduals residuals(heights, between_samples);
  constexpr int least = std::countr_zero(static_cast<unsigned>(kLeastSpan));
  for (int k = levels_; k >= least; --k) {
    first_[static_cast<std::size_t>(k)] = ranges_.size() / kTrianglesPerSquare;
    const int s = 1 << k;
    for (int row = 0; row + s < heights.size; row += s) {
      for (int column = 0; column + s < heights.size; column += s) {
        const bool rises = diagonal_rises(root_rises(id), heights.size, column, row, s);
        for (const Triangle& triangle : triangles_of({column, row}, s, rises)) {
          ranges_.push_back(encode(residuals.measure(triangle), quantum_m));
          std::transform(triangle.begin(), triangle.end(), ranges_.back().quanta.begin(),
                         [&](const Corner& at) { return heights.at(at[0], at[1]); });
        }
      }
    }
  }
}

std::size_t SubtriangleErrorRanges::slot(const Triangle& triangle) const {
  const auto& [a, b, c] = triangle;
  const int columns = std::abs(a[0] - b[0]), rows = std::abs(a[1] - b[1]);
  const int k = std::countr_zero(static_cast<unsigned>(std::max(columns, rows)));
  const auto square = [&](const Corner& inside) { return slot(k, inside[0] >> k, inside[1] >> k); };
  if (columns == rows)
    return square({(a[0] + b[0]) / 2, (a[1] + b[1]) / 2}) * kTrianglesPerSquare +
           (c[1] > (a[1] + b[1]) / 2 ? 1 : 0);
  const std::size_t side = rows == 0 ? (a[1] < c[1] ? 0 : 2) : (a[0] > c[0] ? 1 : 3);
  return square(c) * kTrianglesPerSquare + 2 + side;
}

}  // namespace cairn
