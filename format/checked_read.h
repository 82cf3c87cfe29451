#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cairn/byte_source.h"
#include "cairn/status.h"

namespace cairn {

/// A part of a pack that has a checksum: a block, a page of the index, the metadata.
struct CheckedRange {
  ByteRange range;
  std::uint64_t checksum = 0;
};

/// Reads a part and compares its checksum; a slow source is asked again, twice, where its copy was wrong.
/// Errors begin with the source's name, then `place`. REQUIRES: the range lies in the file.
Result<std::vector<std::byte>> read_checked(const ByteSource& source, const CheckedRange& part,
                                            std::string_view place,
                                            std::span<const ByteRange> likely_next = {});

/// "NAME: PLACE: message", without the place where that is empty.
Error in_file(const ByteSource& source, std::string_view place, const Error& error);

}  // namespace cairn
