#include "tests/support/flight_pack.h"

#include <array>
#include <atomic>
#include <thread>

#include <catch2/catch.hpp>

#include "format/codec.h"
#include "format/height_block.h"
#include "format/pack_writer.h"

namespace cairn::test {
namespace {

constexpr int kTileSize = 257;
constexpr GeoBounds kDetailed{27, 36, 30, 38};
constexpr std::uint64_t kContents = 16;

std::uint64_t mix(const TileId& id) {
  std::uint64_t h = std::hash<TileId>{}(id)*0x9E3779B97F4A7C15u;
  return h ^ h >> 32;
}

std::uint64_t content_of(const TileId& id) {
  return mix(id) % kContents;
}

HeightTile content(std::uint64_t number) {
  HeightTile tile{kTileSize, {}, {}};
  for (int row = 0; row < kTileSize; ++row) {
    for (int column = 0; column < kTileSize; ++column) {
      const auto bumps =
          static_cast<std::int32_t>((static_cast<std::uint64_t>(row * column) * (number + 3)) % 97);
      tile.samples.push_back(static_cast<std::int32_t>(number) * 100 + (row + column == 0 ? 0 : bumps));
    }
  }
  return tile;
}

class Baker {
 public:
  Baker(PackWriter& writer, int coarsest) : writer_(writer), coarsest_(coarsest) {
    for (std::uint64_t n = 0; n < kContents; ++n) {
      blocks_[n] = encode_height_block(content(n), default_height_codec());
    }
  }

  void bake(const TileId& id) {
    IndexEntry entry;
    entry.id = id;
    entry.min_quanta = FlightPack::first_sample(id);
    entry.max_quanta = FlightPack::first_sample(id) + 96;
    entry.geometric_error_m = static_cast<float>(500 * tile_width_degrees(id.level));
    if (id.level >= coarsest_) REQUIRE(writer_.add(entry, blocks_[content_of(id)]).ok());
    for (int quadrant = 0; quadrant < 4 && id.level < FlightPack::kFinest; ++quadrant) {
      const TileId child = child_of(id, quadrant);
      if (is_valid(child) && is_wanted(child)) bake(child);
    }
  }

 private:
  static bool is_wanted(const TileId& id) {
    const GeoBounds b = tile_bounds(id);
    const bool detailed = b.west < kDetailed.east && b.east > kDetailed.west && b.south < kDetailed.north &&
                          b.north > kDetailed.south;
    return (id.level <= -4 || detailed) && (id.level <= 1 || mix(id) % 7 != 0);
  }

  PackWriter& writer_;
  int coarsest_;
  std::array<std::vector<std::byte>, kContents> blocks_;
};

}  // namespace

FlightPack::FlightPack(int coarsest) : path_(dir_.path() / "test.cairn") {
  PackHeader header;
  header.tile_size = kTileSize;
  Result<PackWriter> writer = PackWriter::create(path_, header);
  REQUIRE(writer.ok());
  Baker(*writer, coarsest).bake({kMinLevel, 0, 0});
  REQUIRE(writer->finish("{}").ok());
}

std::shared_ptr<const PackReader> FlightPack::open() const {
  Result<PackReader> pack = PackReader::open(path_);
  if (!pack) FAIL(pack.error().message);
  return std::make_shared<const PackReader>(std::move(*pack));
}

std::int32_t FlightPack::first_sample(const TileId& id) {
  return static_cast<std::int32_t>(content_of(id)) * 100;
}

void write_imagery_pack(const std::filesystem::path& path, LonLat place, int finest_heights,
                        int finest_imagery) {
  PackHeader header;
  header.tile_size = kTileSize;
  Result<PackWriter> writer = PackWriter::create(path, header);
  REQUIRE(writer.ok());
  const auto heights = encode_height_block(content(1), default_height_codec());
  TextureTile texture{TextureFormat::bc1, kTileSize - 1, {}};
  texture.texels.resize(texture_chain_bytes(texture.format, texture.size), std::byte{0x5a});
  const auto imagery = encode_texture_block(texture);
  const auto add = [&](const TileId& id) {
    IndexEntry entry;
    entry.id = id;
    entry.max_quanta = 200;
    entry.geometric_error_m = static_cast<float>(500 * tile_width_degrees(id.level));
    if (id.level <= finest_heights) REQUIRE(writer->add(entry, heights).ok());
    entry.layer = Layer::imagery;
    if (id.level <= finest_imagery) REQUIRE(writer->add(entry, imagery).ok());
  };
  add({kMinLevel, 0, 0});
  for (int level = kMinLevel; level < std::max(finest_heights, finest_imagery); ++level) {
    for (int quadrant = 0; quadrant < 4; ++quadrant) {
      const TileId child = child_of(tile_at(place, level), quadrant);
      if (is_valid(child)) add(child);
    }
  }
  REQUIRE(writer->finish("{}").ok());
}

bool Faults::is_damaged(const TileKey& key) const {
  return key.id.level > kMinLevel &&
         static_cast<double>(mix({key.id.level, key.id.y, key.id.x}) % 100000) < damaged_share * 100000;
}

ReadTile read_with(std::shared_ptr<const PackReader> pack, const Faults& faults) {
  auto reads = std::make_shared<std::atomic<std::uint64_t>>(0);
  return [read = read_from(std::move(pack)), faults, reads](const IndexEntry& entry) -> Result<LoadedTile> {
    const std::uint64_t number = (*reads)++ * 0x9E3779B97F4A7C15u >> 20;
    if (faults.longest_delay_ms > 0) {
      const auto delay = number % static_cast<std::uint64_t>(faults.longest_delay_ms + 1);
      std::this_thread::sleep_for(std::chrono::milliseconds(delay));
    }
    if (static_cast<double>(number % 10007) < faults.failing_share * 10007) return failed("disk: no answer");
    if (faults.is_damaged(key_of(entry))) return bad_data("tile " + to_string(entry.id) + ": damaged");
    return read(entry);
  };
}

}  // namespace cairn::test
