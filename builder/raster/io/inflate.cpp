#include "builder/raster/io/inflate.h"

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <zlib.h>

namespace cairn {
namespace {

constexpr std::size_t kStep = 256 * 1024;

class Inflater {
 public:
  explicit Inflater(DeflateWrapping wrapping) {
    constexpr int kGzipHeader = 16;
    const int bits = wrapping == DeflateWrapping::gzip ? MAX_WBITS + kGzipHeader : -MAX_WBITS;
    ready_ = ::inflateInit2(&stream_, bits) == Z_OK;
  }
  ~Inflater() { ::inflateEnd(&stream_); }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  bool ready() const { return ready_; }
  z_stream& stream() { return stream_; }
  const char* reason() const { return stream_.msg != nullptr ? stream_.msg : "a damaged stream"; }

 private:
  z_stream stream_{};
  bool ready_ = false;
};

/// Inflates what `input` holds. Returns whether the stream has ended.
Result<bool> inflate_step(Inflater& inflater, std::span<std::byte> input, std::uint64_t expected,
                          const std::string& name, ScratchBytes& out) {
  z_stream& stream = inflater.stream();
  std::vector<std::byte> output(kStep);
  stream.next_in = reinterpret_cast<Bytef*>(input.data());
  stream.avail_in = static_cast<uInt>(input.size());
  for (;;) {
    stream.next_out = reinterpret_cast<Bytef*>(output.data());
    stream.avail_out = static_cast<uInt>(output.size());
    const int state = ::inflate(&stream, Z_NO_FLUSH);
    const std::size_t made = output.size() - stream.avail_out;
    if (made > expected - out.size())
      return bad_data(fmt::format("{}: expected {} bytes inside, found more", name, expected));
    if (auto kept = out.append(std::span(output).first(made)); !kept) return kept.error();
    if (state == Z_STREAM_END) return true;
    if (state != Z_OK && state != Z_BUF_ERROR)
      return bad_data(fmt::format("{}: expected deflated data, found {} after {} bytes", name,
                                  inflater.reason(), out.size()));
    if (stream.avail_in == 0 && stream.avail_out != 0) return false;
  }
}

}  // namespace

Status inflate(const InputFile& file, std::uint64_t offset, std::uint64_t count, DeflateWrapping wrapping,
               std::uint64_t expected_bytes, ScratchBytes& out) {
  const std::string name = file.path().string();
  Inflater inflater(wrapping);
  if (!inflater.ready()) return failed(name + ": zlib cannot start");
  std::vector<std::byte> input;
  bool ended = false;
  for (std::uint64_t done = 0; done < count && !ended; done += input.size()) {
    input.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kStep, count - done)));
    if (auto read = file.read_at(offset + done, input); !read) return read;
    const auto step = inflate_step(inflater, input, expected_bytes, name, out);
    if (!step) return step.error();
    ended = *step;
  }
  if (!ended)
    return bad_data(fmt::format("{}: expected {} bytes inside, found a stream cut after {}", name,
                                expected_bytes, out.size()));
  if (out.size() != expected_bytes)
    return bad_data(fmt::format("{}: expected {} bytes inside, found {}", name, expected_bytes, out.size()));
  return {};
}

}  // namespace cairn
