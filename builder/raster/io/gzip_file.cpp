#include "builder/raster/io/gzip_file.h"

#include <cerrno>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include <zlib.h>

#include "builder/raster/io/input_file.h"

namespace cairn {
namespace {

constexpr std::size_t kGzipStep = 256 * 1024;

struct CloseGzip {
  void operator()(gzFile file) const { ::gzclose(file); }
};
using GzipPointer = std::unique_ptr<gzFile_s, CloseGzip>;

}  // namespace

Status unpack_gzip(const std::filesystem::path& path, const ByteSink& sink) {
  if (const auto regular = InputFile::open(path); !regular) return regular.error();
  const GzipPointer file(::gzopen(path.c_str(), "rb"));
  if (!file) return failed(path.string() + ": " + std::strerror(errno));
  ::gzbuffer(file.get(), kGzipStep);
  std::vector<std::byte> piece(kGzipStep);
  for (;;) {
    const int got = ::gzread(file.get(), piece.data(), static_cast<unsigned>(piece.size()));
    // Without gzip's mark zlib would hand the file's own bytes on.
    if (::gzdirect(file.get()) != 0) return bad_data(path.string() + ": expected a gzip file, found another");
    int state = Z_OK;
    const char* reason = ::gzerror(file.get(), &state);
    if (state == Z_ERRNO) return failed(path.string() + ": " + std::strerror(errno));
    // A stream that is cut off gives all it has, and then this state.
    if (got < 0 || state == Z_BUF_ERROR)
      return bad_data(path.string() + ": expected whole gzip data, found " +
                      (state == Z_BUF_ERROR ? "a stream that is cut off" : reason));
    if (got == 0) return {};
    if (auto taken = sink(std::span(piece).first(static_cast<std::size_t>(got))); !taken) return taken;
  }
}

}  // namespace cairn
