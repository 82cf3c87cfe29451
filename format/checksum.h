#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace cairn {

/// XXH3, 64 bits, seed 0: the checksum of every block, the index, the metadata and the header of a pack.
std::uint64_t checksum(std::span<const std::byte> bytes);

}  // namespace cairn
