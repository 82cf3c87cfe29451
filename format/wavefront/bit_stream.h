#pragma once

#include <bit>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace cairn {

/// Rice codes of values below 2^17: quotients from here on are written as this many ones and the whole value.
inline constexpr unsigned kRiceLongest = 20;
inline constexpr unsigned kRiceWhole = 17;

inline unsigned rice_length(std::uint32_t value, unsigned low_bits) {
  const std::uint32_t quotient = value >> low_bits;
  return quotient >= kRiceLongest ? kRiceLongest + kRiceWhole : quotient + 1 + low_bits;
}

/// Appends bits to a vector, lowest first.
class BitWriter {
 public:
  explicit BitWriter(std::vector<std::byte>& out) : out_(out) {}

  /// REQUIRES: count <= 32, value < 2^count.
  void write(std::uint32_t value, unsigned count) {
    assert(count <= 32 && (count == 32 || value >> count == 0));
    held_ |= std::uint64_t{value} << count_;
    for (count_ += count; count_ >= 8; count_ -= 8, held_ >>= 8)
      out_.push_back(static_cast<std::byte>(held_));
  }

  /// REQUIRES: value < 2^17, low_bits <= 16.
  void write_rice(std::uint32_t value, unsigned low_bits) {
    const std::uint32_t quotient = value >> low_bits;
    if (quotient >= kRiceLongest) {
      write((1u << kRiceLongest) - 1, kRiceLongest);
      write(value, kRiceWhole);
    } else {
      write((1u << quotient) - 1, quotient + 1);
      write(value & ((1u << low_bits) - 1), low_bits);
    }
  }

  /// Fills the last byte with zeros.
  void finish() { write(0, (8 - count_) % 8); }

 private:
  std::vector<std::byte>& out_;
  std::uint64_t held_ = 0;
  unsigned count_ = 0;
};

/// Reads what BitWriter wrote. Past the end it reads zeros and ok() is false for good.
class BitReader {
 public:
  explicit BitReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  /// REQUIRES: count <= 32.
  std::uint32_t read(unsigned count) {
    while (count_ < count) {
      if (at_ == bytes_.size()) {
        ok_ = false;
        return 0;
      }
      held_ |= std::uint64_t{static_cast<std::uint8_t>(bytes_[at_++])} << count_;
      count_ += 8;
    }
    const auto value = static_cast<std::uint32_t>(held_ & ((std::uint64_t{1} << count) - 1));
    held_ >>= count;
    count_ -= count;
    return value;
  }

  std::uint32_t read_rice(unsigned low_bits) {
    std::uint32_t quotient = 0;
    while (quotient < kRiceLongest && read(1) != 0) ++quotient;
    return quotient == kRiceLongest ? read(kRiceWhole) : quotient << low_bits | read(low_bits);
  }

  bool ok() const { return ok_; }
  /// All read, but for the zeros that fill the last byte.
  bool finished() const { return ok_ && at_ == bytes_.size() && count_ < 8 && held_ == 0; }

 private:
  std::span<const std::byte> bytes_;
  std::uint64_t held_ = 0;
  std::size_t at_ = 0;
  unsigned count_ = 0;
  bool ok_ = true;
};

}  // namespace cairn
