#pragma once

#include <cstdint>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "cairn/pack_reader.h"

namespace cairn {

/// The metadata of a pack as JSON; bad_data where it is no JSON object.
Result<nlohmann::json> parse_metadata(const PackReader& pack);

/// What a level of a layer holds, from the index.
struct LevelSummary {
  int level = 0;
  std::uint64_t tiles = 0;
  std::uint64_t constant_tiles = 0;
  std::uint64_t bytes = 0;  ///< of its blocks, shared ones once
  double max_error_m = 0;   ///< the largest geometric error of its tiles
};
std::vector<LevelSummary> summarise_levels(const PackReader& pack, Layer layer);

/// What `cairn info` says of a pack, and `cairn bake --report` of the pack it made: header and index in
/// numbers, and what the metadata promise.
nlohmann::ordered_json describe_pack_file(const PackReader& pack, const nlohmann::json& metadata);

}  // namespace cairn
