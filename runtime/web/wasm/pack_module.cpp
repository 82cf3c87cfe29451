// What @cairn/pack calls: checks and decoding of a pack's parts. Pointers are into the module's memory; each
// function returns 0 where cairn_error() has the reason.

#include <cstdint>
#include <cstring>
#include <span>
#include <string>

#include "cairn/pack_layout.h"
#include "format/block_texture.h"
#include "format/checksum.h"
#include "format/height_block.h"
#include "format/index_page.h"
#include "format/tile_number.h"

#define CAIRN_EXPORT extern "C" __attribute__((visibility("default"), used))

namespace {

using namespace cairn;

std::string last_error;

int fail(const Error& error) {
  last_error = error.message;
  return 0;
}

std::span<const std::byte> bytes_at(const std::byte* at, std::size_t count) {
  return {at, count};
}

/// A row of a page, as @cairn/pack reads it: 64 bytes, the fields at their natural places.
struct Row {
  std::uint64_t key;
  std::uint64_t offset;
  std::uint64_t checksum;
  std::uint64_t entries;  // of a child
  std::uint32_t bytes;
  std::uint32_t flags;
  std::int32_t minimum;
  std::int32_t maximum;
  float error_m;
  std::uint32_t filled;
  std::uint64_t reserved;
};
static_assert(sizeof(Row) == 64);

}  // namespace

/// Text and length of the last error.
CAIRN_EXPORT const char* cairn_error() {
  return last_error.c_str();
}
CAIRN_EXPORT std::size_t cairn_error_bytes() {
  return last_error.size();
}

/// Returns 1 where the bytes have the checksum, 8 bytes at `sum`.
CAIRN_EXPORT int cairn_has_checksum(const std::byte* at, std::size_t count, const std::byte* sum) {
  const std::uint64_t found = checksum(bytes_at(at, count));
  return std::memcmp(&found, sum, sizeof found) == 0 ? 1 : 0;
}

/// Checks header and root, the first 16 KiB of a pack.
CAIRN_EXPORT int cairn_check_start(const std::byte* at, std::size_t count) {
  if (count != kPackStartBytes)
    return fail(bad_data("header: expected 16384 bytes, found " + std::to_string(count)));
  const auto header = decode_header(bytes_at(at, kPackHeaderBytes));
  if (!header) return fail(header.error());
  const auto root = bytes_at(at + kPackHeaderBytes, kPackStartBytes - kPackHeaderBytes);
  if (checksum(root) != header->root_checksum)
    return fail(bad_data("root: expected its checksum, found another"));
  if (header->root_bytes > root.size())
    return fail(bad_data("root: expected at most 16128 bytes, found more"));
  const auto decoded = decode_root(root.first(header->root_bytes));
  return decoded ? 1 : fail(decoded.error());
}

/// Decodes a page of the index to `rows`, which has room for 1024; returns the number of rows plus 1, and the
/// page's height in `height`.
CAIRN_EXPORT int cairn_decode_page(const std::byte* at, std::size_t count, Row* rows, std::int32_t* height) {
  const auto page = decode_index_page(bytes_at(at, count));
  if (!page) return fail(page.error());
  *height = page->height;
  for (std::size_t i = 0; i < page->keys.size(); ++i) {
    Row& row = rows[i];
    row = {};
    row.key = page->keys[i];
    if (page->height == 0) {
      const IndexEntry& e = page->entries[i];
      row.offset = e.offset;
      row.checksum = e.checksum;
      row.bytes = e.bytes;
      row.flags = e.flags;
      row.minimum = e.min_quanta;
      row.maximum = e.max_quanta;
      row.error_m = e.geometric_error_m;
      row.filled = e.filled;
    } else {
      const ChildPage& c = page->children[i];
      row.offset = c.offset;
      row.checksum = c.checksum;
      row.entries = c.entries;
      row.bytes = c.bytes;
    }
  }
  return static_cast<int>(page->keys.size()) + 1;
}

/// Decodes a height block to size² samples, and where it has voids to as many bytes at `voids`; returns 1
/// without voids, 2 with them.
CAIRN_EXPORT int cairn_decode_heights(const std::byte* at, std::size_t count, int size, std::int32_t* samples,
                                      std::uint8_t* voids) {
  const auto tile = decode_height_block(bytes_at(at, count), size);
  if (!tile) return fail(tile.error());
  std::memcpy(samples, tile->samples.data(), tile->samples.size() * sizeof(std::int32_t));
  if (tile->voids.empty()) return 1;
  std::memcpy(voids, tile->voids.data(), tile->voids.size());
  return 2;
}

/// Decodes a block-compressed image, format 1, 3 or 7 as in a texture block, to width·height RGBA texels.
CAIRN_EXPORT int cairn_decode_image(int format, const std::byte* at, std::size_t count, int width, int height,
                                    std::uint8_t* rgba) {
  const std::size_t texels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  const Status status = decode_texture(static_cast<TextureFormat>(format), bytes_at(at, count), width, height,
                                       std::span(rgba, texels * 4));
  return status ? 1 : fail(status.error());
}
