#include "tests/support/test_pack.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <set>
#include <sstream>

#include <catch2/catch.hpp>

#include "format/height_block.h"
#include "format/pack_writer.h"

namespace cairn::test {

HeightTile TestSurface::tile(const TileId& id) const {
  const std::int64_t step = std::int64_t{1} << (finest - id.level);
  const std::int64_t intervals = tile_size - 1;
  // Samples around the Earth and from pole to pole at the finest level; finest >= 0, so both are exact.
  const std::int64_t around = (std::int64_t{360} << finest) * intervals;
  const std::int64_t to_pole = (std::int64_t{180} << finest) * intervals;
  HeightTile tile{tile_size, {}, {}};
  for (std::int64_t r = 0; r < tile_size; ++r) {
    for (std::int64_t c = 0; c < tile_size; ++c) {
      const std::int64_t column = (id.x * intervals + c) * step;
      const std::int64_t row = (id.y * intervals + r) * step;
      const bool outside = column > around || row > to_pole;
      const bool gone = outside || (is_void && is_void(column % around, row));
      tile.samples.push_back(outside ? 0 : height(column % around, row));
      tile.voids.push_back(gone ? 1 : 0);
    }
  }
  if (std::find(tile.voids.begin(), tile.voids.end(), 1) == tile.voids.end()) tile.voids.clear();
  return tile;
}

std::int32_t hills(std::int64_t column, std::int64_t row) {
  const double x = static_cast<double>(column), y = static_cast<double>(row);
  return static_cast<std::int32_t>(std::lround(
      4000 + 900 * std::sin(x / 97) + 700 * std::cos(y / 61 + x / 211) + std::fmod(x * 7 + y * 3, 11)));
}

IndexEntry describe(const TileId& id, const HeightTile& tile) {
  IndexEntry entry;
  entry.id = id;
  std::int32_t low = std::numeric_limits<std::int32_t>::max();
  std::int32_t high = std::numeric_limits<std::int32_t>::min();
  for (std::size_t i = 0; i < tile.samples.size(); ++i) {
    if (!tile.voids.empty() && tile.voids[i] != 0) continue;
    low = std::min(low, tile.samples[i]);
    high = std::max(high, tile.samples[i]);
  }
  if (low > high) low = high = 0;
  entry.min_quanta = low;
  entry.max_quanta = high;
  if (!tile.voids.empty()) {
    entry.flags = kHasVoids;
  } else if (low == high) {
    entry.flags = kConstant;
  }
  entry.geometric_error_m = static_cast<float>(std::ldexp(8.0, -id.level));
  return entry;
}

PackHeader test_header(int tile_size) {
  PackHeader header;
  header.tile_size = static_cast<std::uint16_t>(tile_size);
  header.vertical_datum = VerticalDatum::egm96;
  return header;
}

std::string test_metadata(const PackHeader& header, const std::vector<PackLevel>& levels) {
  std::map<int, float> errors;
  for (const PackLevel& level : levels) {
    if (level.layer == Layer::heights) errors[level.level] = level.max_error_m;
  }
  std::ostringstream out;
  out.precision(17);
  out << R"({"cairn":"test","grid":{"tile_size":)" << header.tile_size << R"(,"quantum_m":)"
      << header.quantum_m << R"(},"vertical_datum":")" << to_string(header.vertical_datum)
      << R"(","bounds":{"west":-178,"south":-89,"east":-177,"north":-88},"error_bound_m":0.5,)"
      << R"("accuracy":{"posts":9,"max_m":0.5,"rms_m":0.25,"p50_m":0.125,"p95_m":0.25,"p99_m":0.375,)"
      << R"("worst":{"lon":-177.5,"lat":-88.5}},"levels":[)";
  for (auto it = errors.begin(); it != errors.end(); ++it) {
    out << (it == errors.begin() ? "" : ",") << R"({"level":)" << it->first << R"(,"max_error_m":)"
        << it->second << "}";
  }
  out << R"(],"sources":[{"name":"made.hgt","format":"hgt","posts_used":9}],"options":{}})";
  return out.str();
}

void write_test_pack(const std::filesystem::path& path, const TestSurface& surface,
                     const std::vector<TileId>& tiles,
                     const std::function<void(IndexEntry&, HeightTile&)>& edit) {
  Result<PackWriter> writer = PackWriter::create(path, test_header(surface.tile_size));
  REQUIRE(writer.ok());
  for (const TileId& id : tiles) {
    HeightTile tile = surface.tile(id);
    IndexEntry entry = describe(id, tile);
    if (edit) edit(entry, tile);
    const bool constant = (entry.flags & kConstant) != 0;
    const auto block =
        constant ? std::vector<std::byte>() : encode_height_block(tile, *height_codecs().front());
    REQUIRE(writer->add(entry, block).ok());
  }
  REQUIRE(writer->finish(test_metadata(test_header(surface.tile_size), writer->levels())).ok());
}

std::vector<TileId> with_ancestors(const std::vector<TileId>& tiles, int coarsest) {
  std::set<TileId> all;
  for (const TileId& id : tiles) {
    for (int level = id.level; level >= coarsest; --level) all.insert(ancestor_of(id, level));
  }
  return {all.begin(), all.end()};
}

std::vector<std::byte> read_bytes(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  const std::vector<char> chars(std::istreambuf_iterator<char>(in), {});
  std::vector<std::byte> bytes(chars.size());
  std::transform(chars.begin(), chars.end(), bytes.begin(), [](char c) { return static_cast<std::byte>(c); });
  return bytes;
}

void write_bytes(const std::filesystem::path& path, const std::vector<std::byte>& bytes) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace cairn::test
