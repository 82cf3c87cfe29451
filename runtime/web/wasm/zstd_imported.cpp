// zstd for WebAssembly: the decoder is a function that the page gives to the module. Debian has no zstd that
// is compiled for WebAssembly, and npm's zstddec is zstd itself, compiled by others.

#include <cstdlib>
#include <string>

#include "format/zstd_frame.h"
#include "runtime/web/wasm/zstd.h"

extern "C" {

/// Decodes one whole frame into exactly `out_bytes`; returns 0 where it is none of that content size.
__attribute__((import_module("env"), import_name("cairn_unzstd"))) int cairn_unzstd(const void* frame,
                                                                                    std::size_t frame_bytes,
                                                                                    void* out,
                                                                                    std::size_t out_bytes);

std::size_t ZSTD_decompress(void* out, std::size_t out_bytes, const void* frame, std::size_t frame_bytes) {
  return cairn_unzstd(frame, frame_bytes, out, out_bytes) != 0 ? out_bytes : static_cast<std::size_t>(-1);
}

unsigned ZSTD_isError(std::size_t result) {
  return result == static_cast<std::size_t>(-1) ? 1 : 0;
}

const char* ZSTD_getErrorName(std::size_t) {
  return "a damaged frame";
}

std::size_t ZSTD_compressBound(std::size_t bytes) {
  return bytes;
}

std::size_t ZSTD_compress(void*, std::size_t, const void*, std::size_t, int) {
  std::abort();
}
}

namespace cairn {

void append_zstd_frame(std::span<const std::byte>, const ZstdSearch&, std::vector<std::byte>&) {
  std::abort();
}

Status decode_zstd_frame(std::span<const std::byte> frame, std::span<std::byte> plain) {
  if (cairn_unzstd(frame.data(), frame.size(), plain.data(), plain.size()) != 0) return {};
  return bad_data("zstd frame: expected a whole one with content of " + std::to_string(plain.size()) +
                  " bytes, found another");
}

}  // namespace cairn
