#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "format/bytes.h"

namespace cairn {

inline constexpr unsigned kVarintGroup = 7;

/// Appends numbers as LEB128: seven bits a byte, the lowest first.
class ColumnWriter {
 public:
  void number(std::uint64_t value) {
    for (; value >> kVarintGroup != 0; value >>= kVarintGroup)
      bytes_.push_back(static_cast<std::byte>((value & 0x7F) | 0x80));
    bytes_.push_back(static_cast<std::byte>(value));
  }
  /// 0, -1, 1, -2 … become 0, 1, 2, 3 …
  void difference(std::int64_t value) {
    number(static_cast<std::uint64_t>(value) << 1 ^ static_cast<std::uint64_t>(value >> 63));
  }
  void word(std::uint32_t value) { ByteWriter(bytes_).write(value); }
  void half(std::uint16_t value) { ByteWriter(bytes_).write(value); }

  const std::vector<std::byte>& bytes() const { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
};

/// Reads what ColumnWriter writes. After the last column, or past 64 bits, ok() is false for good and every
/// number is 0.
class ColumnReader {
 public:
  explicit ColumnReader(std::span<const std::byte> bytes) : in_(bytes) {}

  std::uint64_t number() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 64; shift += kVarintGroup) {
      const auto byte = in_.read<std::uint8_t>();
      const std::uint64_t low = byte & 0x7F;
      fits_ = fits_ && low << shift >> shift == low;
      value |= low << shift;
      if (byte >> kVarintGroup == 0) return ok() ? value : 0;
    }
    fits_ = false;
    return 0;
  }
  std::int64_t difference() {
    const std::uint64_t value = number();
    return static_cast<std::int64_t>(value >> 1 ^ (~(value & 1) + 1));
  }
  std::uint32_t word() { return in_.read<std::uint32_t>(); }
  std::uint16_t half() { return in_.read<std::uint16_t>(); }

  template <class T>
  T number_of() {
    const std::uint64_t value = number();
    fits_ = fits_ && value <= std::numeric_limits<T>::max();
    return static_cast<T>(value);
  }
  /// base + difference, where that is a T.
  template <class T>
  T near(T base) {
    const std::uint64_t sum = static_cast<std::uint64_t>(base) + static_cast<std::uint64_t>(difference());
    const T value = static_cast<T>(sum);
    fits_ = fits_ && static_cast<std::uint64_t>(value) == sum;
    return value;
  }

  bool ok() const { return fits_ && in_.ok(); }
  bool finished() const { return ok() && in_.remaining() == 0; }

 private:
  ByteReader in_;
  bool fits_ = true;
};

}  // namespace cairn
