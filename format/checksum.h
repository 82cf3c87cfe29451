#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace cairn {

/// Returns XXH3 of 64 bits with seed 0: the checksum of a pack's blocks, index, metadata and header.
std::uint64_t checksum(std::span<const std::byte> bytes);

/// Computes checksum() of bytes that come in pieces.
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
