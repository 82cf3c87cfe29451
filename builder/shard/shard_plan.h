#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "builder/raster/raster_source.h"
#include "cairn/status.h"
#include "cairn/tile_id.h"

namespace cairn {

/// A file that a bake reads, as it was when the plan was made.
struct PlannedFile {
  std::filesystem::path path;
  std::uint64_t bytes = 0;
  std::uint64_t hash = 0;           ///< XXH3, 64 bits
  std::vector<PlannedFile> beside;  ///< side-cars, which readers of the file look for
};

/// A shard's tiles of one layer: whole subtrees, in the order of the tree's walk.
struct ShardTiles {
  std::vector<TileId> subtrees;
  std::uint64_t leaves = 0;
};

/// What one process bakes.
struct Shard {
  ShardTiles heights;
  ShardTiles imagery;
  std::vector<std::size_t> files;  ///< by number in the plan: all that the shard reads
  std::uint64_t estimated_bytes = 0;
  double estimated_seconds = 0;
  std::uint64_t key = 0;  ///< a hash of all that decides the part's bytes: in two plans, equal where they are
};

/// A bake, divided into shards. Where the sources lie and what they are is in the plan, so a process needs
/// the files of its own shard alone.
struct ShardPlan {
  std::string version;     ///< of the program that made it
  nlohmann::json options;  ///< as the pack will state them
  bool allow_error = false;
  bool with_geoid = false;
  std::size_t places = 0;               ///< files of places of objects
  std::filesystem::path models;         ///< the folder of their models; empty where there are no objects
  std::vector<PlannedFile> files;       ///< of DEMs, images, the geoid, places, models, in this order
  std::vector<RasterInfo> dems;         ///< in the order of the command line
  std::vector<RasterInfo> images;       ///< likewise
  std::vector<std::uint8_t> has_voids;  ///< by DEM
  std::uint64_t memory_bytes = 0;       ///< that each shard stays under by default
  std::vector<Shard> shards;
  std::uint64_t id = 0;  ///< a hash of all of it but the folders of files

  /// The number of the first file of objects: those before are of DEMs, images and the geoid.
  std::size_t first_of_objects() const { return dems.size() + images.size() + (with_geoid ? 1 : 0); }
};

/// Writes the plan as JSON, beside the target and renamed at the end; sets its id and the keys of its shards.
Status write_shard_plan(ShardPlan& plan, const std::filesystem::path& target);

/// Reads a plan. The error is bad_data where it is none, was damaged, or is of another version of the
/// program; it begins with the file's name.
Result<ShardPlan> read_shard_plan(const std::filesystem::path& path);

/// Returns 16 hexadecimal digits.
std::string hex_of(std::uint64_t number);

}  // namespace cairn
