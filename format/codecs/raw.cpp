// The samples as they are, four bytes each: what the other codecs are compared with.

#include <cstring>

#include "format/codec.h"

namespace cairn {
namespace {

void encode(std::span<const std::int32_t> samples, int /*size*/, std::vector<std::byte>& out) {
  const auto bytes = std::as_bytes(samples);
  out.insert(out.end(), bytes.begin(), bytes.end());
}

Status decode(std::span<const std::byte> code, int /*size*/, std::span<std::int32_t> samples) {
  if (code.size() != samples.size_bytes()) {
    return bad_data("raw height code: expected " + std::to_string(samples.size_bytes()) + " bytes, found " +
                    std::to_string(code.size()));
  }
  std::memcpy(samples.data(), code.data(), code.size());
  return {};
}

}  // namespace

extern const HeightCodec raw_codec{0, "raw", encode, decode};

}  // namespace cairn
