#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "cairn/geo.h"
#include "format/bytes.h"

namespace cairn {

/// Post errors in metres: how many, the largest and where, root mean square, percentiles. Sums of two are
/// what one would have been over both, so the result does not depend on how the work was divided, if the
/// order of the sums is kept.
class ErrorStats {
 public:
  /// `where()` is asked only for a new largest error. REQUIRES: error >= 0, not NaN.
  template <class Where>
  void add(double error, const Where& where) {
    ++count_;
    if (error == 0) {
      ++bins_[0];
      return;
    }
    sum_of_squares_ += error * error;
    ++bins_[bin_of(error)];
    if (error > max_) {
      max_ = error;
      worst_ = where();
    }
  }
  void add(const ErrorStats& other);  ///< its excess() counts, too
  /// Posts without an error.
  void add_exact(std::uint64_t posts) {
    count_ += posts;
    bins_[0] += posts;
  }

  std::uint64_t count() const { return count_; }
  double max() const { return max_; }
  double rms() const;
  LonLat worst() const { return worst_; }  ///< of the first post with the largest error; 0, 0 where all are 0

  /// A post that is farther off than its error bound.
  struct Excess {
    double bound_m = 0;
    double error_m = 0;
    LonLat place;
  };
  /// Adds the posts that measure(ErrorStats&) counts, whose error bound this is.
  template <class Measure>
  void add_bounded(double bound_m, const Measure& measure) {
    ErrorStats measured;
    measure(measured);
    measured.hold_against(bound_m);
    add(measured);
  }
  /// Of the posts of add_bounded(), the one that exceeds its error bound by most metres.
  const std::optional<Excess>& excess() const { return excess_; }

  /// An error that at least this share of the posts does not exceed, rounded up by less than 1 %.
  double percentile(double share) const;

  /// For the journal: the same statistics again after an interruption.
  void append_to(std::vector<std::byte>& out) const;
  static ErrorStats read_from(ByteReader& in);

 private:
  // A bin is an exponent and 7 bits of mantissa: from 2^-20 m (below is bin 0) to 2^15 m.
  static constexpr int kMantissaBits = 7;
  static constexpr int kSmallestExponent = -20;
  static constexpr int kExponents = 35;
  static constexpr int kBins = kExponents << kMantissaBits;
  static std::uint32_t bin_of(double error);
  void hold_against(double bound_m);
  void note_excess(const Excess& found);

  std::uint64_t count_ = 0;
  double sum_of_squares_ = 0;
  double max_ = 0;
  LonLat worst_;
  std::optional<Excess> excess_;
  std::array<std::uint64_t, kBins> bins_{};
};

}  // namespace cairn
