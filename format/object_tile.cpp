#include "cairn/object_tile.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <string>
#include <tuple>

#include "cairn/object_model.h"
#include "format/column_codec.h"
#include "format/tile_number.h"
#include "format/zstd_frame.h"

namespace cairn {
namespace {

constexpr int kObjectZstdLevel = 9;  // it decides bytes, so it never changes
constexpr double kPlaces = 65536;    // along a tile's side
constexpr double kTilePerSize = 512;
constexpr std::size_t kHeaderBytes = 20;
constexpr std::size_t kMostObjectBytes = 14;  // in the columns: LEB128 of 32 and 33 bits, and two u16
constexpr std::size_t kMostRunBytes = 8;      // of a model: its number and its objects

Error object_error(const std::string& what, const std::string& expected, const std::string& found) {
  return bad_data("objects block: " + what + ": expected " + expected + ", found " + found);
}

auto order_of(const PlacedObject& o) {
  return std::tuple(o.model, z_curve(o.x, o.y), o.height_quanta, o.heading, o.scale);
}

/// The objects of one model, which lie together.
struct Run {
  std::uint16_t model = 0;
  std::size_t first = 0;
  std::size_t count = 0;
};

std::vector<Run> runs_of(std::span<const PlacedObject> objects) {
  std::vector<Run> runs;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    if (runs.empty() || runs.back().model != objects[i].model) runs.push_back({objects[i].model, i, 0});
    ++runs.back().count;
  }
  return runs;
}

Result<std::vector<Run>> decode_runs(ColumnReader& in, std::size_t models, std::size_t objects) {
  std::vector<Run> runs(models);
  std::uint64_t model = 0;
  for (std::size_t i = 0; i < models; ++i) {
    const std::uint64_t step = in.number();
    if (i > 0 && in.ok() && step == 0) return object_error("models", "numbers that ascend", "one twice");
    model += step;
    if (step > UINT16_MAX || model > UINT16_MAX)
      return object_error("model", "a number below 65536", std::to_string(model));
    runs[i].model = static_cast<std::uint16_t>(model);
  }
  std::size_t first = 0;
  for (Run& run : runs) {
    const std::uint64_t count = in.number();
    if (!in.ok()) break;  // the caller says so
    if (count == 0 || count > objects - first)
      return object_error("objects of a model", "1 to " + std::to_string(objects - first),
                          std::to_string(count));
    run.first = first;
    run.count = static_cast<std::size_t>(count);
    first += run.count;
  }
  if (in.ok() && first != objects)
    return object_error("objects of all models", std::to_string(objects), std::to_string(first));
  return runs;
}

/// The inverse of z_curve() for 16 bits each.
std::uint16_t every_second_bit(std::uint64_t place) {
  std::uint32_t v = static_cast<std::uint32_t>(place) & 0x55555555;
  v = (v | v >> 1) & 0x33333333;
  v = (v | v >> 2) & 0x0F0F0F0F;
  v = (v | v >> 4) & 0x00FF00FF;
  return static_cast<std::uint16_t>(v | v >> 8);
}

Status decode_places(ColumnReader& in, const Run& run, std::span<PlacedObject> objects) {
  std::uint64_t place = 0;
  for (PlacedObject& object : objects) {
    const std::uint64_t step = in.number();
    place += step;
    if (step > UINT32_MAX || place > UINT32_MAX)
      return object_error("place", "one below 2^32 along the Z curve", std::to_string(place));
    object.model = run.model;
    object.x = every_second_bit(place);
    object.y = every_second_bit(place >> 1);
  }
  return {};
}

Status decode_columns(std::span<const std::byte> columns, std::size_t models, ObjectTile& tile) {
  ColumnReader in(columns);
  const auto runs = decode_runs(in, models, tile.objects.size());
  if (!runs) return runs.error();
  for (const Run& run : *runs) {
    const auto objects = std::span(tile.objects).subspan(run.first, run.count);
    if (const Status status = decode_places(in, run, objects); !status) return status;
  }
  std::int32_t height = 0;
  for (PlacedObject& object : tile.objects) object.height_quanta = height = in.near(height);
  for (PlacedObject& object : tile.objects) object.heading = in.half();
  for (PlacedObject& object : tile.objects) object.scale = in.half();
  if (!in.finished())
    return object_error("columns", "one number for each field", in.ok() ? "bytes left over" : "fewer");
  for (std::size_t i = 0; i < tile.objects.size(); ++i) {
    if (tile.objects[i].scale == 0)
      return object_error("object " + std::to_string(i), "a scale above 0", "0");
    if (i > 0 && order_of(tile.objects[i]) < order_of(tile.objects[i - 1]))
      return object_error("object " + std::to_string(i), "objects in order", "one before another");
  }
  return {};
}

}  // namespace

LonLat place_of(const TileId& tile, const PlacedObject& object) {
  const GeoBounds bounds = tile_bounds(tile);
  const double step = tile_width_degrees(tile.level) / kPlaces;
  return {bounds.west + (object.x + 0.5) * step, bounds.south + (object.y + 0.5) * step};
}

int object_level(double size_m, const Body& body) {
  const double degree = body.shape.equator_degree_m();
  for (int level = kMinLevel; level < kMaxLevel; ++level) {
    if (size_m * kTilePerSize >= tile_width_degrees(level) * degree) return level;
  }
  return kMaxLevel;
}

std::int64_t foot_quanta(const PlacedObject& object, double ground_m, double quantum_m) {
  return std::llround(ground_m / quantum_m) + object.height_quanta;
}

void sort_objects(std::vector<PlacedObject>& objects) {
  std::sort(objects.begin(), objects.end(),
            [](const PlacedObject& a, const PlacedObject& b) { return order_of(a) < order_of(b); });
}

std::vector<std::byte> encode_object_block(const ObjectTile& tile) {
  assert(!tile.objects.empty() && tile.objects.size() <= kMostObjects);
  assert(tile.lowest_quanta <= tile.highest_quanta);
  const std::vector<Run> runs = runs_of(tile.objects);
  ColumnWriter columns;
  std::uint16_t model = 0;
  for (const Run& run : runs) {
    columns.number(static_cast<std::uint64_t>(run.model - model));
    model = run.model;
  }
  for (const Run& run : runs) columns.number(run.count);
  for (const Run& run : runs) {
    std::uint64_t before = 0;
    for (const PlacedObject& object : std::span(tile.objects).subspan(run.first, run.count)) {
      const std::uint64_t place = z_curve(object.x, object.y);
      assert(place >= before);
      columns.number(place - before);
      before = place;
    }
  }
  std::int64_t height = 0;
  for (const PlacedObject& object : tile.objects) {
    columns.difference(object.height_quanta - height);
    height = object.height_quanta;
  }
  for (const PlacedObject& object : tile.objects) columns.half(object.heading);
  for (const PlacedObject& object : tile.objects) columns.half(object.scale);

  std::vector<std::byte> block;
  ByteWriter out(block);
  out.write(static_cast<std::uint32_t>(tile.objects.size()));
  out.write(static_cast<std::uint32_t>(runs.size()));
  out.write(tile.lowest_quanta);
  out.write(tile.highest_quanta);
  out.write(static_cast<std::uint32_t>(columns.bytes().size()));
  append_zstd_frame(columns.bytes(), {.level = kObjectZstdLevel}, block);
  return block;
}

Result<ObjectTile> decode_object_block(std::span<const std::byte> block) {
  ByteReader in(block);
  const auto objects = in.read<std::uint32_t>();
  const auto models = in.read<std::uint32_t>();
  ObjectTile tile;
  tile.lowest_quanta = in.read<std::int32_t>();
  tile.highest_quanta = in.read<std::int32_t>();
  const auto column_bytes = in.read<std::uint32_t>();
  if (!in.ok())
    return object_error("size", std::to_string(kHeaderBytes) + " bytes or more",
                        std::to_string(block.size()));
  if (objects == 0 || objects > kMostObjects)
    return object_error("objects", "1 to " + std::to_string(kMostObjects), std::to_string(objects));
  if (models == 0 || models > objects || models > kMostModels)
    return object_error("models", "1 to " + std::to_string(std::min<std::size_t>(objects, kMostModels)),
                        std::to_string(models));
  if (tile.lowest_quanta > tile.highest_quanta)
    return object_error("lowest foot", "at most the highest", std::to_string(tile.lowest_quanta));
  const std::uint64_t most =
      std::uint64_t{objects} * kMostObjectBytes + std::uint64_t{models} * kMostRunBytes;
  if (column_bytes > most)
    return object_error("column bytes", "at most " + std::to_string(most), std::to_string(column_bytes));
  std::vector<std::byte> columns(column_bytes);
  if (const Status status = decode_zstd_frame(in.take(in.remaining()), columns); !status)
    return bad_data("objects block: " + status.error().message);
  tile.objects.resize(objects);
  if (const Status status = decode_columns(columns, models, tile); !status) return status.error();
  return tile;
}

}  // namespace cairn
