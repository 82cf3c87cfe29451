#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "cairn/status.h"

namespace cairn {

/// A lossless codec for one square of integers. Each file of format/codecs/ defines one; the folder is the
/// list. Every codec decodes alone, gives the same bytes on every x86-64 CPU, and holds no state between
/// calls, so that any thread may call it at any time.
struct HeightCodec {
  std::uint8_t id;   ///< the byte that names it in a pack; never reused
  const char* name;  ///< as the bench and `cairn info` print it

  /// Appends the code of `size`×`size` samples to `out`. Any int32 values are legal. REQUIRES: 2 <= size <=
  /// 4097.
  void (*encode)(std::span<const std::int32_t> samples, int size, std::vector<std::byte>& out);

  /// Fills `samples` (size·size) from exactly `code`. bad_data where the code is not one of this size:
  /// truncated, longer than it should be, or damaged in a way that the codec can see. Never reads or writes
  /// outside.
  Status (*decode)(std::span<const std::byte> code, int size, std::span<std::int32_t> samples);
};

/// All codecs, in the order of their file names.
std::span<const HeightCodec* const> height_codecs();

/// The codec that a bake uses: the smallest and fastest of them on terrain.
const HeightCodec& default_height_codec();

/// The codec with this id, or null.
const HeightCodec* find_height_codec(std::uint8_t id);

}  // namespace cairn
