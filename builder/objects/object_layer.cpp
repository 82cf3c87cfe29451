#include "builder/objects/object_layer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <system_error>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>

#include "builder/bake/pipeline.h"
#include "builder/objects/model_library.h"
#include "builder/objects/place_files.h"
#include "builder/objects/place_store.h"
#include "builder/objects/scatter.h"
#include "cairn/object_placing.h"
#include "format/ground_sampler.h"
#include "format/height_block.h"
#include "format/tile_number.h"

namespace cairn {
namespace {

constexpr std::size_t kFewestInMemory = std::size_t{1} << 16;
constexpr std::size_t kMostInMemory = std::size_t{1} << 21;
constexpr std::size_t kBatchPlaces = std::size_t{1} << 18;  // that are placed before more are read
constexpr std::uint64_t kPlacesBetweenReports = 1 << 16;
constexpr std::size_t kCachedTiles = 4;

using Entries = std::unordered_map<TileId, IndexEntry>;

/// The heights of the unfinished pack.
struct Ground {
  ObjectGround pack;
  const PackWriter* writer = nullptr;
  Entries heights;
  int coarsest = kMaxLevel;
  int finest = kMinLevel;

  Result<HeightTile> read(const IndexEntry& entry) const {
    if ((entry.flags & kConstant) != 0) {
      const auto side = static_cast<std::size_t>(pack.tile_size);
      return HeightTile{pack.tile_size, std::vector<std::int32_t>(side * side, entry.min_quanta), {}};
    }
    const auto block = writer->read_block(entry);
    if (!block) return block.error();
    return decode_height_block(*block, pack.tile_size);
  }

  GroundSampler sampler() const {
    return GroundSampler({[this](const TileId& id) -> std::optional<IndexEntry> {
                            const auto found = heights.find(id);
                            return found == heights.end() ? std::nullopt : std::optional(found->second);
                          },
                          [this](const IndexEntry& entry) { return read(entry); }, pack.tile_size},
                         kCachedTiles);
  }
};

Result<Ground> ground_of(const ObjectGround& pack, const PackWriter& writer) {
  Ground ground{pack, &writer, {}};
  const Status status = writer.visit_entries([&ground](const IndexEntry& entry) -> Status {
    if (entry.layer != Layer::heights) return {};
    ground.heights.emplace(entry.id, entry);
    ground.coarsest = std::min(ground.coarsest, entry.id.level);
    ground.finest = std::max(ground.finest, entry.id.level);
    return {};
  });
  if (!status) return status.error();
  if (ground.heights.empty())
    return usage_error("objects: expected DEMs, on whose ground they stand, found none");
  return ground;
}

/// Puts places into tiles. Models have the numbers of the library, until all are known.
class PlaceSorter {
 public:
  PlaceSorter(ModelLibrary& library, const Ground& ground, PlaceStore& store)
      : library_(library), ground_(ground), store_(store) {}

  /// `rule`: whose limits the ground beneath it has to keep; 0 is none.
  Status take(const ObjectPlace& place, std::uint32_t rule) {
    if (place.model != name_) {
      const auto found = library_.find(place.model);
      if (!found) return found.error();
      const auto model = library_.load(*found);
      if (!model) return model.error();
      name_ = place.model;
      number_ = *found;
      size_m_ = static_cast<double>((*model)->size_m);
    }
    const TileObject placed = tile_object({place.at, place.heading_degrees, place.scale, size_m_},
                                          ground_.pack.body, ground_.coarsest);
    StoredPlace stored;
    stored.tile = placed.tile;
    PlacedObject& object = stored.object = placed.object;
    object.model = static_cast<std::uint16_t>(number_);
    stored.is_absolute = place.is_absolute;
    if (place.is_absolute) stored.absolute_m = place.height_m;
    if (!place.is_absolute) {
      const double quanta = std::round(place.height_m / ground_.pack.quantum_m);
      if (std::abs(quanta) > kMostQuanta)
        return bad_data("height: expected fewer quanta of the pack, found more");
      object.height_quanta = static_cast<std::int32_t>(quanta);
    }
    stored.rule = rule;
    return store_.add(stored);
  }

  static constexpr double kMostQuanta = 1e9;

 private:
  ModelLibrary& library_;
  const Ground& ground_;
  PlaceStore& store_;
  std::string name_;
  std::size_t number_ = 0;
  double size_m_ = 0;
};

/// Tiles that lie over one tile of heights, or are larger than it.
struct Group {
  std::vector<std::pair<TileId, std::vector<StoredPlace>>> tiles;
  std::size_t places = 0;
};

/// A tile's block, and how many of its places have no ground.
struct BakedTile {
  TileId id;
  std::vector<PlacedObject> objects;
  std::int32_t lowest = std::numeric_limits<std::int32_t>::max();
  std::int32_t highest = std::numeric_limits<std::int32_t>::min();
  std::vector<std::byte> block;
  std::uint64_t scattered = 0;
  std::uint64_t outside_limits = 0;
  std::uint64_t left_out = 0;
  LonLat first_left_out;
};

class ObjectBaker {
 public:
  ObjectBaker(std::vector<std::uint16_t> numbers, std::vector<double> sizes, std::vector<GroundLimits> limits,
              const Ground& ground, int threads, PackWriter& writer)
      : numbers_(std::move(numbers)),
        sizes_(std::move(sizes)),
        limits_(std::move(limits)),
        ground_(ground),
        threads_(threads),
        writer_(writer) {}

  Status take(const TileId& id, std::vector<StoredPlace>&& places) {
    const TileId over = id.level > ground_.finest ? ancestor_of(id, ground_.finest) : id;
    if (groups_.empty() || over != over_) {
      groups_.emplace_back();
      over_ = over;
    }
    batch_places_ += places.size();
    groups_.back().places += places.size();
    groups_.back().tiles.emplace_back(id, std::move(places));
    return batch_places_ < kBatchPlaces ? Status() : bake_batch();
  }

  Status finish() {
    if (auto status = bake_batch(); !status) return status;
    while (level_ >= ground_.coarsest) {
      if (auto status = ascend(level_ - 1); !status) return status;
    }
    return {};
  }

  std::uint64_t left_out = 0;
  std::optional<LonLat> first_left_out;
  std::uint64_t scattered = 0;
  std::uint64_t outside_limits = 0;
  std::vector<std::uint64_t> counts = std::vector<std::uint64_t>(kMostModels);

 private:
  Status bake_batch() {
    const std::vector<Group> groups = std::exchange(groups_, {});
    batch_places_ = 0;
    return run_in_order<std::vector<BakedTile>>(
        0, groups.size(), static_cast<std::size_t>(threads_) + 1,
        [&](std::size_t g) { return bake_group(groups[g]); },
        [&](std::size_t, std::vector<BakedTile>&& tiles) -> Status {
          for (const BakedTile& tile : tiles) {
            if (auto status = write(tile); !status) return status;
          }
          return {};
        });
  }

  Result<std::vector<BakedTile>> bake_group(const Group& group) const {
    GroundSampler sampler = ground_.sampler();
    std::vector<BakedTile> baked;
    for (const auto& [id, places] : group.tiles) {
      auto tile = bake_tile(id, places, sampler);
      if (!tile) return tile.error();
      baked.push_back(std::move(*tile));
    }
    return baked;
  }

  Result<BakedTile> bake_tile(const TileId& id, const std::vector<StoredPlace>& places,
                              GroundSampler& sampler) const {
    // Along the Z curve, whatever the model, so that few tiles of heights are needed at a time.
    std::vector<std::size_t> order(places.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      const PlacedObject &left = places[a].object, &right = places[b].object;
      return z_curve(left.x, left.y) < z_curve(right.x, right.y);
    });
    BakedTile tile;
    tile.id = id;
    for (const std::size_t i : order) {
      const LonLat at = place_of(id, places[i].object);
      const auto height = sampler.height_at(at, ground_.finest, ground_.coarsest);
      if (!height) return height.error();
      if (!*height) {
        if (tile.left_out++ == 0) tile.first_left_out = at;
        continue;
      }
      if (places[i].rule != 0) {
        const auto kept = keeps(limits_[places[i].rule], at, (*height)->quanta, sampler);
        if (!kept) return kept.error();
        ++(*kept ? tile.scattered : tile.outside_limits);
        if (!*kept) continue;
      }
      if (auto status = add(places[i], (*height)->quanta * ground_.pack.quantum_m, tile); !status)
        return status.error();
    }
    if (tile.objects.empty()) return tile;
    sort_objects(tile.objects);
    ObjectTile content{tile.lowest, tile.highest, std::move(tile.objects)};
    tile.block = encode_object_block(content);
    tile.objects = std::move(content.objects);
    return tile;
  }

  /// Whether the ground at a place is within limits.
  Result<bool> keeps(const GroundLimits& limits, LonLat at, double quanta, GroundSampler& sampler) const {
    const double height = quanta * ground_.pack.quantum_m;
    if (height < limits.min_height_m || height > limits.max_height_m) return false;
    if (!limits.has_slope()) return true;
    const auto slope = slope_at(at, sampler);
    if (!slope) return slope.error();
    return *slope >= limits.min_slope_deg && *slope <= limits.max_slope_deg;
  }

  /// Returns the slope in degrees of the square between four of the finest samples that a place lies in. The
  /// ground is bilinear there, so that two places inside the square are enough along each axis.
  Result<double> slope_at(LonLat at, GroundSampler& sampler) const {
    const double step = std::ldexp(1.0 / (ground_.pack.tile_size - 1), -ground_.finest);
    const double west = std::floor(at.lon / step) * step, south = std::floor(at.lat / step) * step;
    const std::array<LonLat, 4> beside{LonLat{west + step / 4, at.lat}, LonLat{west + 3 * step / 4, at.lat},
                                       LonLat{at.lon, south + step / 4},
                                       LonLat{at.lon, south + 3 * step / 4}};
    std::array<double, 4> metres{};
    for (std::size_t i = 0; i < 4; ++i) {
      const auto height = sampler.height_at(beside[i], ground_.finest, ground_.coarsest);
      if (!height) return height.error();
      if (*height) metres[i] = (*height)->quanta * ground_.pack.quantum_m;
    }
    const Ellipsoid& shape = ground_.pack.body.shape;
    const double latitude = at.lat * (std::numbers::pi / 180), sine = std::sin(latitude);
    const double f = shape.flattening(), square = f * (2 - f);
    const double across = shape.equator_degree_m() / std::sqrt(1 - square * sine * sine);
    const double along = across * (1 - square) / (1 - square * sine * sine);
    const double east = (metres[1] - metres[0]) / (step / 2 * across * std::max(std::cos(latitude), 1e-9));
    const double north = (metres[3] - metres[2]) / (step / 2 * along);
    return std::atan(std::hypot(east, north)) * (180 / std::numbers::pi);
  }

  Status add(const StoredPlace& place, double ground_m, BakedTile& tile) const {
    PlacedObject object = place.object;
    object.model = numbers_[object.model];
    if (place.is_absolute) {
      const double quanta = std::round(place.absolute_m / ground_.pack.quantum_m);
      object.height_quanta =
          static_cast<std::int32_t>(static_cast<std::int64_t>(std::clamp(quanta, -1e9, 1e9)) -
                                    foot_quanta({}, ground_m, ground_.pack.quantum_m));
    }
    const std::int64_t foot = foot_quanta(object, ground_m, ground_.pack.quantum_m);
    if (foot != static_cast<std::int32_t>(foot))
      return bad_data("objects: tile " + to_string(tile.id) +
                      ": expected feet of 32 bits of quanta, found more");
    tile.lowest = std::min(tile.lowest, static_cast<std::int32_t>(foot));
    tile.highest = std::max(tile.highest, static_cast<std::int32_t>(foot));
    tile.objects.push_back(object);
    return {};
  }

  Status write(const BakedTile& tile) {
    if (tile.left_out != 0 && !first_left_out) first_left_out = tile.first_left_out;
    left_out += tile.left_out;
    scattered += tile.scattered;
    outside_limits += tile.outside_limits;
    if (tile.objects.empty()) return {};
    if (!begun_) level_ = tile.id.level;
    begun_ = true;
    while (level_ > tile.id.level) {
      if (auto status = ascend(level_ - 1); !status) return status;
    }
    float largest = 0;
    if (const auto beneath = beneath_.find(tile.id); beneath != beneath_.end()) largest = beneath->second;
    beneath_.erase(tile.id);
    for (const PlacedObject& object : tile.objects) {
      const double size = sizes_[object.model] * object.scale_factor();
      float rounded = static_cast<float>(size);
      if (static_cast<double>(rounded) < size)
        rounded = std::nextafter(rounded, std::numeric_limits<float>::max());
      largest = std::max(largest, rounded);
      ++counts[object.model];
    }
    IndexEntry entry;
    entry.layer = Layer::objects;
    entry.id = tile.id;
    entry.min_quanta = static_cast<std::int32_t>(tile.objects.size());
    entry.geometric_error_m = largest;
    note_above(entry);
    const auto added = writer_.add(entry, tile.block);
    return added ? Status() : Status(added.error());
  }

  void note_above(const IndexEntry& entry) {
    if (entry.id.level <= ground_.coarsest) return;
    float& largest = above_[parent_of(entry.id)];
    largest = std::max(largest, entry.geometric_error_m);
  }

  // The tiles of this level that only lead to finer ones are added now; those above wait for the next.
  Status ascend(int to) {
    std::vector<std::pair<TileId, float>> empty(beneath_.begin(), beneath_.end());
    for (const auto& [id, largest] : empty) {
      IndexEntry entry;
      entry.layer = Layer::objects;
      entry.id = id;
      entry.flags = kConstant;
      entry.geometric_error_m = largest;
      note_above(entry);
      if (const auto added = writer_.add(entry, {}); !added) return added.error();
    }
    beneath_ = std::exchange(above_, {});
    level_ = to;
    return {};
  }

  std::vector<std::uint16_t> numbers_;  // of the library's models in the pack
  std::vector<double> sizes_;           // by number
  std::vector<GroundLimits> limits_;    // by rule
  const Ground& ground_;
  int threads_;
  PackWriter& writer_;
  std::vector<Group> groups_;
  TileId over_;
  std::size_t batch_places_ = 0;
  bool begun_ = false;
  int level_ = kMinLevel;
  std::unordered_map<TileId, float> beneath_;  // of level_: the largest object beneath each tile
  std::unordered_map<TileId, float> above_;    // of the level above, so far
};

Status write_models(const std::vector<const ModelLibrary::Model*>& models, PackWriter& writer) {
  for (std::size_t m = 0; m < models.size(); ++m) {
    IndexEntry entry;
    entry.layer = Layer::models;
    entry.id = model_address(static_cast<std::uint32_t>(m));
    entry.min_quanta = static_cast<std::int32_t>(models[m]->triangles);
    entry.geometric_error_m = models[m]->size_m;
    if (const auto added = writer.add(entry, models[m]->block); !added) return added.error();
  }
  return {};
}

/// Reads all places, and scatters those of areas. Appends the limits of each area.
Status read_all_places(const ObjectOptions& options, const ObjectGround& pack, PlaceSorter& sorter,
                       PlaceStore& store, std::vector<GroundLimits>& limits, const ProgressCallback& progress,
                       std::uint64_t written) {
  const auto take = [&](const ObjectPlace& place, std::uint32_t rule) -> Status {
    if (store.size() % kPlacesBetweenReports == 0 && !progress({"places", store.size(), 0, written}))
      return failed("bake: cancelled");
    return sorter.take(place, rule);
  };
  const PlaceVisitor visitor{[&](const ObjectPlace& place) { return take(place, 0); },
                             [&](const ScatterArea& area) {
                               const auto rule = static_cast<std::uint32_t>(limits.size());
                               limits.push_back(area.rule.limits);
                               return scatter(area, pack.body, pack.bounds,
                                              [&](const ObjectPlace& place) { return take(place, rule); });
                             }};
  for (const auto& file : options.places) {
    if (auto status = read_places(file, visitor); !status) return status;
  }
  if (store.size() == 0)
    return bad_data(options.places.front().string() + ": expected places of objects on the DEMs, found none");
  return {};
}

}  // namespace

std::vector<std::filesystem::path> files_of(const ObjectOptions& options) {
  std::vector<std::filesystem::path> files = options.places;
  if (files.empty()) return files;
  for (const auto& place : options.places) {
    for (auto& file : files_of_places(place)) {
      std::error_code ignored;
      if (!std::filesystem::equivalent(file, place, ignored)) files.push_back(std::move(file));
    }
  }
  for (auto& file : files_of_models(options.models)) files.push_back(std::move(file));
  return files;
}

Result<ObjectSummary> bake_objects(const ObjectOptions& options, const ObjectGround& pack, int threads,
                                   BakeSession& session, const ProgressCallback& progress) {
  // 1. Read the places into tiles, and each model that one of them names.
  if (auto status = session.writer.flush(); !status) return status.error();
  const auto ground = ground_of(pack, session.writer);
  if (!ground) return ground.error();
  auto library = ModelLibrary::open(options.models);
  if (!library) return library.error();
  const std::size_t in_memory = std::clamp(session.options.memory_bytes / 4 / sizeof(PlaceStore::Record),
                                           kFewestInMemory, kMostInMemory);
  PlaceStore store(session.options.target.parent_path(), in_memory);
  PlaceSorter sorter(*library, *ground, store);
  std::vector<GroundLimits> limits(1);
  if (auto status =
          read_all_places(options, pack, sorter, store, limits, progress, session.writer.position());
      !status)
    return status.error();

  // 2. Number the models that are used, in the order of their names.
  const auto models = library->loaded();
  std::vector<std::uint16_t> numbers(library->size());
  std::vector<double> sizes;
  std::vector<const ModelLibrary::Model*> used;
  for (const auto& [place, model] : models) {
    numbers[place] = static_cast<std::uint16_t>(used.size());
    sizes.push_back(static_cast<double>(model->size_m));
    used.push_back(model);
  }

  // 3. Place every object on the ground, and write its tile, the finest first.
  ObjectBaker baker(std::move(numbers), std::move(sizes), std::move(limits), *ground, threads,
                    session.writer);
  Progress now{"objects", 0, store.size(), session.writer.position()};
  const auto placed = store.visit([&](const TileId& id, std::vector<StoredPlace>&& places) -> Status {
    now.done += places.size();
    now.bytes_written = session.writer.position();
    if (auto status = baker.take(id, std::move(places)); !status) return status;
    return progress(now) ? Status() : failed("bake: cancelled");
  });
  if (!placed) return placed.error();
  if (auto status = baker.finish(); !status) return status.error();
  if (auto status = write_models(used, session.writer); !status) return status.error();

  ObjectSummary summary;
  summary.left_out = baker.left_out;
  summary.first_left_out = baker.first_left_out.value_or(LonLat{});
  summary.scattered = baker.scattered;
  summary.outside_limits = baker.outside_limits;
  summary.objects = store.size() - baker.left_out - baker.outside_limits;
  if (summary.objects == 0)
    return bad_data(options.places.front().string() + ": expected a place with ground beneath it" +
                    (baker.outside_limits == 0 ? "" : " that is within its rule's limits") + ", found none");
  for (std::size_t m = 0; m < used.size(); ++m)
    summary.models.push_back(
        {used[m]->name, baker.counts[m], used[m]->triangles, used[m]->vertices, used[m]->levels});
  return summary;
}

}  // namespace cairn
