#include "format/zstd_frame.h"

#include <cassert>
#include <memory>
#include <string>

#include <zstd.h>

namespace cairn {

namespace {

struct FreeContext {
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
};

}  // namespace

void append_zstd_frame(std::span<const std::byte> plain, const ZstdSearch& search,
                       std::vector<std::byte>& out) {
  const std::unique_ptr<ZSTD_CCtx, FreeContext> context(ZSTD_createCCtx());
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, search.level);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_hashLog, search.hash_log);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_minMatch, search.min_match);
  const std::size_t start = out.size();
  out.resize(start + ZSTD_compressBound(plain.size()));
  const std::size_t used =
      ZSTD_compress2(context.get(), out.data() + start, out.size() - start, plain.data(), plain.size());
  assert(!ZSTD_isError(used));
  out.resize(start + used);
}

Status decode_zstd_frame(std::span<const std::byte> frame, std::span<std::byte> plain) {
  const std::size_t frame_bytes = ZSTD_findFrameCompressedSize(frame.data(), frame.size());
  if (ZSTD_isError(frame_bytes)) {
    return bad_data(std::string("zstd frame: expected a whole one, found ") + ZSTD_getErrorName(frame_bytes));
  }
  if (frame_bytes != frame.size()) {
    return bad_data("zstd frame: expected " + std::to_string(frame.size()) + " bytes, found " +
                    std::to_string(frame_bytes));
  }
  const unsigned long long content = ZSTD_getFrameContentSize(frame.data(), frame.size());
  if (content != plain.size()) {
    const bool known = content != ZSTD_CONTENTSIZE_UNKNOWN && content != ZSTD_CONTENTSIZE_ERROR;
    return bad_data("zstd frame: expected content of " + std::to_string(plain.size()) + " bytes, found " +
                    (known ? std::to_string(content) : "an unknown size"));
  }
  const std::size_t got = ZSTD_decompress(plain.data(), plain.size(), frame.data(), frame.size());
  if (ZSTD_isError(got)) return bad_data(std::string("zstd frame: ") + ZSTD_getErrorName(got));
  if (got != plain.size()) return bad_data("zstd frame: content shorter than it says");
  return {};
}

}  // namespace cairn
