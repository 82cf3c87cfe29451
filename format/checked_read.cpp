#include "format/checked_read.h"

#include <new>

#include "format/checksum.h"

namespace cairn {

Error in_file(const ByteSource& source, std::string_view place, const Error& error) {
  std::string text = source.name().string() + ": ";
  if (!place.empty()) text.append(place).append(": ");
  return {error.code, text + error.message};
}

Result<std::vector<std::byte>> read_checked(const ByteSource& source, const CheckedRange& part,
                                            std::string_view place, std::span<const ByteRange> likely_next) {
  std::vector<std::byte> bytes;
  try {
    bytes.resize(part.range.bytes);
  } catch (const std::bad_alloc&) {
    return in_file(
        source, place,
        failed("expected memory for " + std::to_string(part.range.bytes) + " bytes, found too little"));
  }
  constexpr int kTries = 3;
  for (int tries = 1; tries <= kTries; ++tries) {
    if (const Status status = source.read(part.range.offset, bytes, likely_next); !status)
      return status.error();
    if (checksum(bytes) == part.checksum) return bytes;
    const Result<bool> may_differ = source.recheck(part.range);
    if (!may_differ) return may_differ.error();
    if (!*may_differ) break;
  }
  return in_file(source, place, bad_data("checksum: expected the one that the pack states, found another"));
}

}  // namespace cairn
