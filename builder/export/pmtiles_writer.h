#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "cairn/geo.h"
#include "cairn/status.h"
#include "format/file.h"

namespace cairn {

/// What a PMTiles archive says of its tiles; the numbers are the format's.
struct PmtilesInfo {
  enum class TileType : std::uint8_t { png = 2, jpeg = 3, webp = 4 };
  TileType type = TileType::png;
  int min_zoom = 0;
  int max_zoom = 0;
  GeoBounds bounds;
  std::string metadata;  ///< JSON
};

/// A PMTiles archive, version 3 (protomaps/PMTiles, spec/v3/spec.md), clustered. Equal tiles are stored once.
class PmtilesWriter {
 public:
  static Result<PmtilesWriter> create(const std::filesystem::path& path);

  /// REQUIRES: ids ascend.
  Status add(std::uint64_t id, std::span<const std::byte> tile);

  Status finish(const PmtilesInfo& info);

 private:
  struct Entry {
    std::uint64_t id = 0;
    std::uint64_t offset = 0;
    std::uint32_t bytes = 0;
    std::uint32_t run = 0;  ///< 0: a leaf directory
  };
  struct Stored {
    std::uint64_t offset;
    std::uint32_t bytes;
  };

  explicit PmtilesWriter(File file) : file_(std::move(file)) {}
  static std::vector<std::byte> encode(std::span<const Entry> entries);

  File file_;
  std::uint64_t tile_bytes_ = 0;
  std::uint64_t tiles_ = 0;
  std::vector<Entry> entries_;
  std::unordered_map<std::uint64_t, Stored> stored_;  // by XXH3 of 64 bits of the tile
};

}  // namespace cairn
