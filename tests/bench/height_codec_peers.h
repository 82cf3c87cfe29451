#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace cairn::bench {

/// A way to code a tile, cairn's or another's. Encoding appends; decoding returns whether it succeeded.
struct Coder {
  std::string name;
  std::function<void(std::span<const std::int32_t>, int size, std::vector<std::byte>&)> encode;
  std::function<bool(std::span<const std::byte>, int size, std::span<std::int32_t>)> decode;
};

/// JPEG-LS (CharLS), JPEG 2000 lossless (OpenJPEG), each where it was there to build with, and GDAL's way:
/// horizontal differences under zstd. All store the tile's lowest value beside and need a range of 16 bits.
std::vector<Coder> peers();

}  // namespace cairn::bench
