#include "builder/export/pmtiles_writer.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>

#include <zlib.h>

#include "format/checksum.h"

namespace cairn {
namespace {

constexpr std::size_t kHeaderBytes = 127;
constexpr std::size_t kRootEnd = 16384;  // header and root directory come in the first request
constexpr std::uint8_t kNoCompression = 1;
constexpr std::uint8_t kGzip = 2;

std::vector<std::byte> gzip(std::span<const std::byte> bytes) {
  z_stream stream{};
  constexpr int kGzipWindow = 15 + 16;
  deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, kGzipWindow, 8, Z_DEFAULT_STRATEGY);
  std::vector<std::byte> out(deflateBound(&stream, static_cast<uLong>(bytes.size())) + 32);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const int result = deflate(&stream, Z_FINISH);
  assert(result == Z_STREAM_END);
  (void)result;
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

void put_varint(std::vector<std::byte>& out, std::uint64_t value) {
  for (; value >= 0x80; value >>= 7) out.push_back(static_cast<std::byte>(value | 0x80));
  out.push_back(static_cast<std::byte>(value));
}

template <class T>
void put_at(std::array<std::byte, kHeaderBytes>& header, std::size_t at, T value) {
  std::memcpy(header.data() + at, &value, sizeof value);
}

std::int32_t e7(double degrees) {
  return static_cast<std::int32_t>(std::lround(degrees * 1e7));
}

}  // namespace

Result<PmtilesWriter> PmtilesWriter::create(const std::filesystem::path& path) {
  auto file = File::open_to_write(path);
  if (!file) return file.error();
  if (auto status = file->truncate(0); !status) return status.error();
  return PmtilesWriter(std::move(*file));
}

Status PmtilesWriter::add(std::uint64_t id, std::span<const std::byte> tile) {
  assert(entries_.empty() || entries_.back().id + entries_.back().run <= id);
  ++tiles_;
  const auto bytes = static_cast<std::uint32_t>(tile.size());
  const std::uint64_t hash = checksum(tile);
  const auto known = stored_.find(hash);
  if (known != stored_.end() && known->second.bytes == bytes) {
    Entry& last = entries_.back();
    if (last.offset == known->second.offset && last.id + last.run == id) {
      ++last.run;
    } else {
      entries_.push_back({id, known->second.offset, bytes, 1});
    }
    return {};
  }
  if (auto status = file_.write(kRootEnd + tile_bytes_, tile); !status) return status;
  stored_[hash] = {tile_bytes_, bytes};
  entries_.push_back({id, tile_bytes_, bytes, 1});
  tile_bytes_ += bytes;
  return {};
}

std::vector<std::byte> PmtilesWriter::encode(std::span<const Entry> entries) {
  std::vector<std::byte> out;
  put_varint(out, entries.size());
  std::uint64_t before = 0;
  for (const Entry& e : entries) {
    put_varint(out, e.id - before);
    before = e.id;
  }
  for (const Entry& e : entries) put_varint(out, e.run);
  for (const Entry& e : entries) put_varint(out, e.bytes);
  std::uint64_t next = 0;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    put_varint(out, i > 0 && entries[i].offset == next ? 0 : entries[i].offset + 1);
    next = entries[i].offset + entries[i].bytes;
  }
  return gzip(out);
}

Status PmtilesWriter::finish(const PmtilesInfo& info) {
  std::vector<std::byte> root = encode(entries_), leaves;
  for (std::size_t leaf_entries = 4096; kHeaderBytes + root.size() > kRootEnd; leaf_entries *= 2) {
    leaves.clear();
    std::vector<Entry> directory;
    for (std::size_t i = 0; i < entries_.size(); i += leaf_entries) {
      const auto part = std::span(entries_).subspan(i, std::min(leaf_entries, entries_.size() - i));
      const std::vector<std::byte> leaf = encode(part);
      directory.push_back({part.front().id, leaves.size(), static_cast<std::uint32_t>(leaf.size()), 0});
      leaves.insert(leaves.end(), leaf.begin(), leaf.end());
    }
    root = encode(directory);
  }
  const std::vector<std::byte> metadata =
      gzip(std::as_bytes(std::span(info.metadata.data(), info.metadata.size())));
  const std::uint64_t metadata_at = kRootEnd + tile_bytes_, leaves_at = metadata_at + metadata.size();
  std::array<std::byte, kHeaderBytes> header{};
  std::memcpy(header.data(), "PMTiles\x03", 8);
  const std::uint64_t numbers[] = {kHeaderBytes, root.size(),     metadata_at,   metadata.size(),
                                   leaves_at,    leaves.size(),   kRootEnd,      tile_bytes_,
                                   tiles_,       entries_.size(), stored_.size()};
  std::memcpy(header.data() + 8, numbers, sizeof numbers);
  put_at(header, 96, std::uint8_t{1});  // clustered
  put_at(header, 97, kGzip);
  put_at(header, 98, kNoCompression);
  put_at(header, 99, info.type);
  put_at(header, 100, static_cast<std::uint8_t>(info.min_zoom));
  put_at(header, 101, static_cast<std::uint8_t>(info.max_zoom));
  put_at(header, 102, e7(info.bounds.west));
  put_at(header, 106, e7(info.bounds.south));
  put_at(header, 110, e7(info.bounds.east));
  put_at(header, 114, e7(info.bounds.north));
  put_at(header, 118, static_cast<std::uint8_t>(info.min_zoom));
  put_at(header, 119, e7((info.bounds.west + info.bounds.east) / 2));
  put_at(header, 123, e7((info.bounds.south + info.bounds.north) / 2));
  if (auto status = file_.write(0, header); !status) return status;
  if (auto status = file_.write(kHeaderBytes, root); !status) return status;
  if (auto status = file_.write(metadata_at, metadata); !status) return status;
  if (auto status = file_.write(leaves_at, leaves); !status) return status;
  return file_.sync();
}

}  // namespace cairn
