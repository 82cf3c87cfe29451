#pragma once

// What format/ uses of zstd, for WebAssembly, where no zstd is linked: frames are decoded by the page's own
// decoder (zstd_imported.cpp), and nothing is encoded.

#include <cstddef>

extern "C" {
std::size_t ZSTD_decompress(void* out, std::size_t out_bytes, const void* frame, std::size_t frame_bytes);
std::size_t ZSTD_compress(void* out, std::size_t out_bytes, const void* in, std::size_t in_bytes, int level);
std::size_t ZSTD_compressBound(std::size_t bytes);
unsigned ZSTD_isError(std::size_t result);
const char* ZSTD_getErrorName(std::size_t result);
}
