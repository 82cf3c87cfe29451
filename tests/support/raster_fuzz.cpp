#include "tests/support/raster_fuzz.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <vector>

#include <catch2/catch.hpp>

#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

const RasterFormat* format_named(const std::string& name) {
  for (const RasterFormat* format : raster_formats())
    if (name == format->name) return format;
  return nullptr;
}

/// An error must be one line that names the file.
void check(const Status& status, const std::string& name) {
  if (status) return;
  REQUIRE(status.error().message.find('\n') == std::string::npos);
  REQUIRE(status.error().message.find(name) != std::string::npos);
}

}  // namespace

void open_and_read(const char* format, const std::string& name, std::span<const std::byte> bytes,
                   const std::optional<GeoBounds>& bounds) {
  const TempDir folder;
  const auto path = folder.path() / name;
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  const RasterFormat* reader = format_named(format);
  REQUIRE(reader != nullptr);
  auto source = reader->open(path, {.bounds = bounds, .cache_bytes = 64 * 1024});
  if (!source) return check(source.error(), name);
  const RasterInfo& info = (*source)->info();
  const std::int64_t columns = std::min<std::int64_t>(info.columns, 64),
                     rows = std::min<std::int64_t>(info.rows, 64);
  std::vector<float> heights(static_cast<std::size_t>(columns * rows));
  std::vector<std::uint8_t> rgba(heights.size() * 4);
  for (const PostWindow window :
       {PostWindow{0, 0, columns, rows}, {info.columns - columns, info.rows - rows, columns, rows}}) {
    check((*source)->read_heights(window, heights), name);
    check((*source)->read_colours(window, rgba), name);
  }
}

}  // namespace cairn::test
