#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace cairn {

/// How near the surface comes to the posts.
struct FitTolerance {
  double interval_m =
      0;  ///< a surface within so much of a post is left as it is there: 0 for one through all
  double tolerance_m = 0;  ///< of the fit: by so much a post may be missed beyond the interval
};

/// Posts anywhere among the samples of a window, each in a square of four of them. The four weights of a
/// post's bilinear interpolant are its row of A: A times the samples is the surface at the posts.
class PostEquations {
 public:
  /// `columns`: samples in a row of the window.
  explicit PostEquations(std::int64_t columns) : columns_(columns) {}

  /// A post at fractions s, t in [0, 1) east and north of the sample at `corner`. REQUIRES: the samples east,
  /// north and northeast of it lie in the window.
  void add(std::int64_t corner, double s, double t, float height);

  void reserve(std::size_t posts) { rows_.reserve(posts); }
  std::size_t size() const { return rows_.size(); }

  struct Fit {
    int rounds = 0;
    double worst_residual_m = 0;  ///< the largest |surface - height| over the posts, beyond the interval
  };

  /// The least change of the samples, in the sum of squares, that brings the surface to within the interval
  /// of each post: what it misses a post by is taken back to the interval's end where it is beyond, and kept
  /// where it is not. Made until the tolerance holds: conjugate gradients on AAᵀ in Craig's form (Saad,
  /// Iterative Methods for Sparse Linear Systems, 2003, §8.3.2), the rows of A scaled to unit length, which
  /// leaves the solution as it is. Ends short of the tolerance after 300 rounds, or where single precision
  /// allows no progress.
  Fit fit(std::span<float> samples, const FitTolerance& tolerance) const;

 private:
  struct Row {
    std::int32_t corner = 0;
    float height = 0;
    float length = 0;
    std::array<float, 4> weights{};  // of unit length: south-west, south-east, north-west, north-east
  };
  float apply(const Row& row, const float* samples) const;
  void add_transposed(const Row& row, float factor, float* samples) const;
  double residuals(std::span<const float> samples, double interval_m, std::span<float> out) const;
  double advance(std::span<float> residuals, float step, const float* direction, float* gradient) const;
  int correct(std::span<float> residuals, double tolerance_m, int most_rounds,
              std::span<float> samples) const;

  std::int64_t columns_;
  std::vector<Row> rows_;
};

}  // namespace cairn
