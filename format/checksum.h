#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace cairn {

/// XXH3, 64 bits, seed 0: the checksum of every block, page, the metadata and the header of a pack.
std::uint64_t checksum(std::span<const std::byte> bytes);

/// XXH3, 128 bits, seed 0: the low 64 bits, then the high ones, each little-endian.
std::array<std::byte, 16> long_checksum(std::span<const std::byte> bytes);

/// checksum() of bytes that come in pieces.
class ChecksumStream {
 public:
  ChecksumStream();
  ~ChecksumStream();
  ChecksumStream(const ChecksumStream&) = delete;
  ChecksumStream& operator=(const ChecksumStream&) = delete;

  void add(std::span<const std::byte> bytes);
  std::uint64_t value() const;  ///< of all pieces so far

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cairn
