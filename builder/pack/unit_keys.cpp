#include "builder/pack/unit_keys.h"

#include <algorithm>
#include <optional>
#include <set>
#include <span>
#include <string>

#include <nlohmann/json.hpp>
#include <tbb/parallel_for.h>

#include "builder/imagery/edge_texels.h"
#include "builder/mosaic/lattice.h"
#include "builder/mosaic/mosaic_reach.h"
#include "builder/pack/options_json.h"
#include "builder/raster/raster_info_json.h"
#include "format/bytes.h"
#include "format/checksum.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;
using Hash = std::array<std::byte, 16>;

Hash hash_of(const std::string& text) {
  return long_checksum(std::as_bytes(std::span(text)));
}

// Where a source lies, of what kind it is, and what is said of it; not its name and not its posts.
std::vector<Hash> places_of(const RasterPool& pool) {
  std::vector<Hash> places(pool.size());
  tbb::parallel_for(std::size_t{0}, places.size(), [&](std::size_t s) {
    nlohmann::json json = to_json(pool.info(s));
    json.erase("path");
    places[s] = hash_of(json.dump() + to_json(pool.info(s).overrides).dump());
  });
  return places;
}

void append_id(const TileId& id, ByteWriter& writer) {
  writer.write(std::int32_t{id.level});
  writer.write(id.x);
  writer.write(id.y);
}

void append_text(const std::string& text, ByteWriter& writer) {
  writer.write(static_cast<std::uint64_t>(text.size()));
  writer.append(std::as_bytes(std::span(text)));
}

/// The keys of one layer: what all units have in common, then each one's own.
class KeyMaker {
 public:
  KeyMaker(const RasterPool& pool, std::span<const std::uint64_t> hashes)
      : places_(places_of(pool)), hashes_(hashes) {}

  void append_common(const std::string& text) {
    ByteWriter writer(common_);
    append_text(CAIRN_VERSION, writer);
    append_text(text, writer);
  }

  void append_place(std::size_t source, ByteWriter& writer) const { writer.append(places_[source]); }

  void append_source(std::size_t source, ByteWriter& writer, UnitKey& key) const {
    writer.append(places_[source]);
    writer.write(hashes_[source]);
    key.sources.push_back(static_cast<std::uint32_t>(source));
  }

  // The tree beneath a unit: its leaves, and which tiles only lend their edges.
  static void append_tree(const TileTree& tree, const TileId& unit, ByteWriter& writer) {
    append_id(unit, writer);
    std::set<TileId> above;
    for (const TileId& leaf : tree.leaves(unit)) {
      append_id(leaf, writer);
      writer.write(std::uint8_t{tree.edge_only(leaf)});
      for (TileId id = leaf; id != unit && above.insert(parent_of(id)).second;) id = parent_of(id);
    }
    for (const TileId& id : above) writer.write(std::uint8_t{tree.edge_only(id)});
  }

  template <class AppendOwn>
  std::vector<UnitKey> keys_of(const TileTree& tree, const AppendOwn& append_own) const {
    const std::vector<TileId> units = tree.units();
    std::vector<UnitKey> keys(units.size());
    tbb::parallel_for(std::size_t{0}, units.size(), [&](std::size_t u) {
      keys[u].unit = units[u];
      std::vector<std::byte> bytes = common_;
      ByteWriter writer(bytes);
      append_tree(tree, units[u], writer);
      append_own(units[u], writer, keys[u]);
      keys[u].hash = long_checksum(bytes);
    });
    return keys;
  }

 private:
  std::vector<Hash> places_;
  std::span<const std::uint64_t> hashes_;
  std::vector<std::byte> common_;
};

void append_counting(const HeightPlan& plan, const TileId& unit, ByteWriter& writer) {
  for (const TileId& leaf : plan.tree().leaves(unit)) {
    const PostCounting counting = plan.counting(leaf);
    for (const bool counts :
         {counting.count_east, counting.count_north, counting.count_north_west, counting.count_north_east})
      writer.write(std::uint8_t{counts});
  }
}

// A projected group resamples on meshes over all of its grid, and has its footprint from all of its members:
// it counts as a whole where it lies. A lattice is known by its first member.
void append_group(const Mosaic& mosaic, std::size_t number, const KeyMaker& maker, ByteWriter& writer) {
  const SourceGroup& group = *mosaic.groups()[number];
  const GroupOverlay::Layer& layer = mosaic.overlaid()[number];
  writer.write(std::int32_t{group.native_level()});
  writer.write(group.spacing_degrees());
  writer.write(group.samples_per_post());
  writer.write(std::uint8_t{group.posts_on_samples()});
  writer.write(std::int32_t{layer.level});
  writer.write(layer.fade_degrees);
  const std::vector<std::size_t>& sources = group.sources();
  const bool is_lattice = place_on_lattice(mosaic.pool().info(sources.front())).has_value();
  const std::size_t count = is_lattice ? 1 : sources.size();
  writer.write(static_cast<std::uint64_t>(count));
  for (std::size_t m = 0; m < count; ++m) maker.append_place(sources[m], writer);
}

std::vector<UnitKey> height_keys(const BakePlan& layers, const BuildOptions& options,
                                 std::span<const std::uint64_t> hashes) {
  const Mosaic& mosaic = *layers.heights;
  const HeightPlan& plan = *layers.plan;
  Json common = to_json(options);
  common.erase("imagery");
  common.erase("rqt");
  common.erase("objects");
  common["with"] = {plan.quantum_m(), plan.error_bound_m(), plan.least_error_bound_m(), plan.top(),
                    plan.finest()};
  if (options.mosaic.geoid)
    common["geoid"] = hashes[options.mosaic.inputs.size() + options.imagery.inputs.size()];
  KeyMaker maker(mosaic.pool(), hashes);
  maker.append_common(common.dump());
  if (options.mosaic.fade_posts == 0) {
    // Whether anything lies beneath a group shows nowhere else then.
    std::vector<std::byte> all;
    ByteWriter writer(all);
    for (std::size_t s = 0; s < mosaic.pool().size(); ++s) maker.append_place(s, writer);
    maker.append_common(std::string(reinterpret_cast<const char*>(all.data()), all.size()));
  }
  const MosaicReach reach(mosaic);
  return maker.keys_of(plan.tree(), [&](const TileId& unit, ByteWriter& writer, UnitKey& key) {
    append_counting(plan, unit, writer);
    for (const MosaicReach::Members& members : reach.near(without_overhang(tile_bounds(unit)))) {
      append_group(mosaic, members.group, maker, writer);
      writer.write(std::uint8_t{members.has_voids});
      writer.write(static_cast<std::uint64_t>(members.sources.size()));
      for (const std::size_t source : members.sources) maker.append_source(source, writer, key);
    }
  });
}

std::vector<UnitKey> image_keys(const BakePlan& layers, const BuildOptions& options,
                                std::span<const std::uint64_t> hashes) {
  const ImageryMosaic& mosaic = *layers.imagery;
  const TileTree& tree = *layers.imagery_tree;
  Json common{{"imagery", to_json(options)["imagery"]}, {"tile_size", options.grid.tile_size}};
  KeyMaker maker(mosaic.pool(), hashes);
  maker.append_common(common.dump());
  return maker.keys_of(tree, [&](const TileId& unit, ByteWriter& writer, UnitKey& key) {
    for (const std::size_t source : mosaic.sources_near(texture_area(unit, options.grid.tile_size - 1)))
      maker.append_source(source, writer, key);
  });
}

}  // namespace

UnitKeys unit_keys(const BakePlan& layers, const BuildOptions& options,
                   const std::vector<std::uint64_t>& hashes) {
  UnitKeys keys;
  const std::span all(hashes);
  if (layers.heights) keys.heights = height_keys(layers, options, all);
  const std::size_t dems = layers.heights ? layers.heights->pool().size() : 0;
  if (layers.imagery) keys.imagery = image_keys(layers, options, all.subspan(dems));
  return keys;
}

GeoBounds texture_area(const TileId& unit, int tile_texels) {
  const GeoBounds b = without_overhang(tile_bounds(unit));
  const double rim = (EdgeTexels::kRim + 2.0) / tile_texels * tile_width_degrees(unit.level);
  return {b.west - rim, b.south - rim, b.east + rim, b.north + rim};
}

}  // namespace cairn
