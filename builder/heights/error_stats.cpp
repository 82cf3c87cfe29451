#include "builder/heights/error_stats.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace cairn {

namespace {

constexpr int kFloatMantissaBits = 23;
constexpr int kFloatBias = 127;

}  // namespace

std::uint32_t ErrorStats::bin_of(double error) {
  const auto bits =
      std::bit_cast<std::uint32_t>(static_cast<float>(error)) >> (kFloatMantissaBits - kMantissaBits);
  constexpr std::uint32_t first = static_cast<std::uint32_t>(kFloatBias + kSmallestExponent) << kMantissaBits;
  return bits < first ? 0 : std::min<std::uint32_t>(bits - first, kBins - 1);
}

void ErrorStats::add(const ErrorStats& other) {
  count_ += other.count_;
  sum_of_squares_ += other.sum_of_squares_;
  for (std::size_t b = 0; b < bins_.size(); ++b) bins_[b] += other.bins_[b];
  if (other.max_ > max_) {
    max_ = other.max_;
    worst_ = other.worst_;
  }
  if (other.excess_) note_excess(*other.excess_);
}

void ErrorStats::hold_against(double bound_m) {
  if (max_ > bound_m) note_excess({bound_m, max_, worst_});
}

void ErrorStats::note_excess(const Excess& found) {
  if (!excess_ || found.error_m - found.bound_m > excess_->error_m - excess_->bound_m) excess_ = found;
}

double ErrorStats::rms() const {
  // Rounding in the sum would lift it above the largest where all errors are one.
  return count_ == 0 ? 0 : std::min(std::sqrt(sum_of_squares_ / static_cast<double>(count_)), max_);
}

double ErrorStats::percentile(double share) const {
  const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(count_)));
  std::uint64_t seen = 0;
  for (std::uint32_t b = 0; b < kBins; ++b) {
    seen += bins_[b];
    if (seen < wanted) continue;
    if (b == 0) return std::min(std::ldexp(1.0, kSmallestExponent), max_);
    const std::uint32_t next =
        b + 1 + (static_cast<std::uint32_t>(kFloatBias + kSmallestExponent) << kMantissaBits);
    const float edge = std::bit_cast<float>(next << (kFloatMantissaBits - kMantissaBits));
    return std::min(static_cast<double>(edge), max_);
  }
  return max_;
}

void ErrorStats::append_to(std::vector<std::byte>& out) const {
  ByteWriter writer(out);
  writer.write(count_);
  writer.write(sum_of_squares_);
  writer.write(max_);
  writer.write(worst_.lon);
  writer.write(worst_.lat);
  for (std::uint32_t b = 0; b < kBins; ++b) {
    if (bins_[b] == 0) continue;
    writer.write(b);
    writer.write(bins_[b]);
  }
  writer.write(std::uint32_t{kBins});  // the end of the bins
  writer.write(std::uint8_t{excess_.has_value()});
  if (!excess_) return;
  writer.write(excess_->bound_m);
  writer.write(excess_->error_m);
  writer.write(excess_->place.lon);
  writer.write(excess_->place.lat);
}

ErrorStats ErrorStats::read_from(ByteReader& in) {
  ErrorStats stats;
  stats.count_ = in.read<std::uint64_t>();
  stats.sum_of_squares_ = in.read<double>();
  stats.max_ = in.read<double>();
  stats.worst_.lon = in.read<double>();
  stats.worst_.lat = in.read<double>();
  for (auto b = in.read<std::uint32_t>(); in.ok() && b < kBins; b = in.read<std::uint32_t>()) {
    stats.bins_[b] = in.read<std::uint64_t>();
  }
  if (in.read<std::uint8_t>() == 0) return stats;
  Excess excess;
  excess.bound_m = in.read<double>();
  excess.error_m = in.read<double>();
  excess.place.lon = in.read<double>();
  excess.place.lat = in.read<double>();
  stats.excess_ = excess;
  return stats;
}

}  // namespace cairn
