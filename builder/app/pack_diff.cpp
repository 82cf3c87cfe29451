#include "builder/app/pack_diff.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <map>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/parallel_for.h>

#include "builder/app/pack_metadata.h"
#include "cairn/pack_sampler.h"
#include "format/imagery_tile.h"

namespace cairn {
namespace {

using SortedJson = nlohmann::json;

constexpr std::size_t kTilesATask = 32;
constexpr std::size_t kTasksAtATime = 64;
constexpr std::size_t kCachedTiles = 8;

struct TileKey {
  Layer layer;
  TileId id;
  Presence presence;
};

std::string text_of(const SortedJson& value) {
  return value.dump(-1, ' ', false, SortedJson::error_handler_t::replace);
}

void note(std::vector<ValueDifference>& out, const std::string& key, const SortedJson& a,
          const SortedJson& b) {
  if (a != b) out.push_back({key, text_of(a), text_of(b)});
}

std::vector<ValueDifference> diff_headers(const PackHeader& a, const PackHeader& b) {
  std::vector<ValueDifference> out;
  note(out, "tile_size", a.tile_size, b.tile_size);
  note(out, "quantum_m", a.quantum_m, b.quantum_m);
  note(out, "vertical_datum", a.datum_name(), b.datum_name());
  note(out, "body", a.body.name, b.body.name);
  note(out, "semi_major_m", a.body.shape.semi_major_m, b.body.shape.semi_major_m);
  note(out, "semi_minor_m", a.body.shape.semi_minor_m, b.body.shape.semi_minor_m);
  return out;
}

std::vector<ValueDifference> diff_metadata(const SortedJson& a, const SortedJson& b) {
  const SortedJson flat_a = a.flatten(), flat_b = b.flatten();
  std::vector<ValueDifference> out;
  for (const auto& [key, value] : flat_a.items())
    note(out, key, value, flat_b.contains(key) ? flat_b.at(key) : SortedJson());
  for (const auto& [key, value] : flat_b.items())
    if (!flat_a.contains(key)) out.push_back({key, "null", text_of(value)});
  return out;
}

std::vector<TileKey> all_tiles(const PackReader& a, const PackReader& b) {
  std::vector<TileKey> keys;
  for (std::size_t i = 0; i < a.entry_count(); ++i) {
    const IndexEntry entry = a.entry(i);
    keys.push_back(
        {entry.layer, entry.id, b.find(entry.layer, entry.id) ? Presence::both : Presence::only_a});
  }
  for (std::size_t i = 0; i < b.entry_count(); ++i) {
    const IndexEntry entry = b.entry(i);
    if (!a.find(entry.layer, entry.id)) keys.push_back({entry.layer, entry.id, Presence::only_b});
  }
  return keys;
}

/// Heights of one tile of one pack, sample by sample; NaN where there is none.
class TileHeights {
 public:
  explicit TileHeights(const PackReader& pack) : pack_(pack), sampler_(pack, kCachedTiles) {}

  /// Row-major, columns from west to east, rows from south to north.
  Result<std::vector<double>> read(const TileId& id) {
    const auto entry = pack_.find(Layer::heights, id);
    return entry ? read_tile(*entry) : sample(id);
  }

 private:
  Result<std::vector<double>> read_tile(const IndexEntry& entry) {
    const auto tile = pack_.read_height_tile(entry);
    if (!tile) return tile.error();
    std::vector<double> metres(tile->samples.size());
    for (std::size_t i = 0; i < metres.size(); ++i) {
      const bool is_void = !tile->voids.empty() && tile->voids[i] != 0;
      metres[i] = is_void ? std::nan("") : tile->samples[i] * pack_.header().quantum_m;
    }
    return metres;
  }

  Result<std::vector<double>> sample(const TileId& id) {
    const GeoBounds bounds = tile_bounds(id), inside = without_overhang(bounds);
    const int side = pack_.header().tile_size;
    const double spacing = tile_width_degrees(id.level) / (side - 1);
    std::vector<double> metres;
    metres.reserve(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
    for (int row = 0; row < side; ++row) {
      for (int column = 0; column < side; ++column) {
        const LonLat place{bounds.west + column * spacing, bounds.south + row * spacing};
        if (place.lon > inside.east || place.lat > inside.north) {
          metres.push_back(std::nan(""));
          continue;
        }
        const auto height = sampler_.height_at(place, id.level);
        if (!height) return height.error();
        metres.push_back(*height ? (*height)->metres : std::nan(""));
      }
    }
    return metres;
  }

  const PackReader& pack_;
  PackSampler sampler_;
};

/// Compares tiles one after the other, in one thread.
class TileComparer {
 public:
  TileComparer(const PackReader& a, const PackReader& b) : a_(a), b_(b), heights_a_(a), heights_b_(b) {}

  /// nullopt where the tile is equal.
  Result<std::optional<TileDifference>> compare(const TileKey& key) {
    TileDifference out{key.layer, key.id, key.presence, {}, {}, false, {}};
    if (key.presence != Presence::both) {
      if (key.layer == Layer::heights)
        if (auto status = compare_heights(key.id, out); !status) return status.error();
      return std::optional(std::move(out));
    }
    const IndexEntry a = *a_.find(key.layer, key.id), b = *b_.find(key.layer, key.id);
    note(out.values, "geometric_error_m", a.geometric_error_m, b.geometric_error_m);
    note(out.values, "filled", a.filled / 65535.0, b.filled / 65535.0);
    if (!has_equal_block(a, b))
      if (auto status = compare_blocks(key, a, b, out); !status) return status.error();
    const bool differs = out.heights || out.texels || out.blocks_differ || !out.values.empty();
    return differs ? std::optional(std::move(out)) : std::nullopt;
  }

 private:
  bool has_equal_block(const IndexEntry& a, const IndexEntry& b) const {
    if (a.layer == Layer::heights && a_.header().quantum_m != b_.header().quantum_m) return false;
    if (a.bytes == 0 && b.bytes == 0) return a.min_quanta == b.min_quanta;
    return a.bytes == b.bytes && a.checksum == b.checksum;
  }

  Status compare_blocks(const TileKey& key, const IndexEntry& a, const IndexEntry& b, TileDifference& out) {
    if (key.layer == Layer::heights) return compare_heights(key.id, out);
    if (key.layer == Layer::imagery) return compare_texels(a, b, out);
    out.blocks_differ = true;
    return {};
  }

  Status compare_heights(const TileId& id, TileDifference& out) {
    const auto a = heights_a_.read(id), b = heights_b_.read(id);
    if (!a) return a.error();
    if (!b) return b.error();
    HeightDifference d;
    double squares = 0;
    std::size_t both = 0, worst = 0;
    for (std::size_t i = 0; i < a->size(); ++i) {
      const double at_a = (*a)[i], at_b = (*b)[i];
      if (std::isnan(at_a) || std::isnan(at_b)) {
        d.only_in_a += !std::isnan(at_a);
        d.only_in_b += !std::isnan(at_b);
        continue;
      }
      ++both;
      const double off = std::abs(at_a - at_b);
      squares += off * off;
      d.samples += off != 0;
      if (off > d.max_m) d.max_m = off, worst = i;
    }
    if (d.samples + d.only_in_a + d.only_in_b == 0) return {};
    d.rms_m = both == 0 ? 0 : std::sqrt(squares / static_cast<double>(both));
    if (d.samples > 0) {
      const auto side = static_cast<std::size_t>(a_.header().tile_size);
      const GeoBounds bounds = tile_bounds(id);
      const double spacing = bounds.width() / static_cast<double>(side - 1);
      d.worst = {bounds.west + static_cast<double>(worst % side) * spacing,
                 bounds.south + static_cast<double>(worst / side) * spacing};
      d.a_m = (*a)[worst];
      d.b_m = (*b)[worst];
    }
    out.heights = d;
    return {};
  }

  Status compare_texels(const IndexEntry& a, const IndexEntry& b, TileDifference& out) const {
    const auto texels_a = read_imagery_tile(a_, a), texels_b = read_imagery_tile(b_, b);
    if (!texels_a) return texels_a.error();
    if (!texels_b) return texels_b.error();
    TexelDifference d;
    for (std::size_t i = 0; i < texels_a->size(); i += 4) {
      int most = 0;
      for (std::size_t c = i; c < i + 4; ++c)
        most = std::max(most, std::abs((*texels_a)[c] - (*texels_b)[c]));
      d.texels += most != 0;
      d.max = std::max(d.max, most);
    }
    if (d.texels > 0) out.texels = d;
    return {};
  }

  const PackReader& a_;
  const PackReader& b_;
  TileHeights heights_a_, heights_b_;
};

using TaskResult = Result<std::vector<TileDifference>>;

TaskResult compare_task(const PackReader& a, const PackReader& b, std::span<const TileKey> keys) {
  TileComparer comparer(a, b);
  std::vector<TileDifference> out;
  for (const TileKey& key : keys) {
    auto difference = comparer.compare(key);
    if (!difference) return difference.error();
    if (*difference) out.push_back(**std::move(difference));
  }
  return out;
}

Status diff_tiles(const PackReader& a, const PackReader& b, std::span<const TileKey> keys,
                  const DiffProgress& progress, std::vector<TileDifference>& out) {
  for (std::size_t first = 0; first < keys.size(); first += kTilesATask * kTasksAtATime) {
    const auto some = keys.subspan(first, std::min(keys.size() - first, kTilesATask * kTasksAtATime));
    const std::size_t tasks = (some.size() + kTilesATask - 1) / kTilesATask;
    std::vector<TaskResult> results(tasks, TaskResult(std::vector<TileDifference>()));
    tbb::parallel_for(std::size_t{0}, tasks, [&](std::size_t t) {
      const std::size_t begin = t * kTilesATask;
      results[t] = compare_task(a, b, some.subspan(begin, std::min(kTilesATask, some.size() - begin)));
    });
    for (TaskResult& result : results) {
      if (!result) return result.error();
      std::move(result->begin(), result->end(), std::back_inserter(out));
    }
    progress(first + some.size(), keys.size());
  }
  return {};
}

std::vector<LayerDifference> count_layers(std::span<const TileKey> keys,
                                          std::span<const TileDifference> differing) {
  std::map<Layer, LayerDifference> layers;
  for (const TileKey& key : keys) {
    LayerDifference& layer = layers[key.layer];
    layer.layer = key.layer;
    layer.equal += key.presence == Presence::both;
    layer.only_a += key.presence == Presence::only_a;
    layer.only_b += key.presence == Presence::only_b;
  }
  for (const TileDifference& tile : differing) {
    if (tile.presence != Presence::both) continue;
    --layers[tile.layer].equal;
    ++layers[tile.layer].differing;
  }
  std::vector<LayerDifference> out;
  for (const auto& [name, layer] : layers) out.push_back(layer);
  return out;
}

}  // namespace

Result<PackDifference> diff_packs(const PackReader& a, const PackReader& b, const DiffProgress& progress) {
  const auto metadata_a = parse_metadata(a), metadata_b = parse_metadata(b);
  if (!metadata_a) return metadata_a.error();
  if (!metadata_b) return metadata_b.error();
  PackDifference out;
  out.header = diff_headers(a.header(), b.header());
  out.metadata = diff_metadata(*metadata_a, *metadata_b);
  out.comparable = a.header().tile_size == b.header().tile_size;
  if (!out.comparable) return out;
  const std::vector<TileKey> keys = all_tiles(a, b);
  if (auto status = diff_tiles(a, b, keys, progress, out.tiles); !status) return status.error();
  out.layers = count_layers(keys, out.tiles);
  return out;
}

}  // namespace cairn
