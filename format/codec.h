#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "cairn/status.h"

namespace cairn {

/// A lossless codec for one square of integers. Each file of format/codecs/ defines one; the folder is the
/// list. A codec needs no other tile to decode one, gives equal bytes on every x86-64 CPU, and is stateless:
/// any thread may call it at any time.
struct HeightCodec {
  std::uint8_t id;   ///< identifies the codec in a pack; never reused
  const char* name;  ///< as the bench and `cairn info` print it

  /// Appends the code of `size`×`size` samples, of any int32 values, to `out`. REQUIRES: 2 <= size <= 4097.
  void (*encode)(std::span<const std::int32_t> samples, int size, std::vector<std::byte>& out);

  /// Decodes all of `code` into `samples`, size·size of them. The error is bad_data if the code is truncated,
  /// too long, of another size, or damaged in a way that the codec can detect. Never reads or writes outside.
  Status (*decode)(std::span<const std::byte> code, int size, std::span<std::int32_t> samples);
};

/// Returns all codecs, in the order of their files' names.
std::span<const HeightCodec* const> height_codecs();

/// Returns the codec that a bake uses.
const HeightCodec& default_height_codec();

/// Returns the codec with this id, null if there is none.
const HeightCodec* find_height_codec(std::uint8_t id);

}  // namespace cairn
