#pragma once

#include <nlohmann/json.hpp>

#include "cairn/pack_reader.h"

namespace cairn {

/// What `cairn info` says of a pack, and `cairn bake --report` of the pack it made: header and index in
/// numbers, and what the metadata promise.
nlohmann::ordered_json describe_pack_file(const PackReader& pack, const nlohmann::json& metadata);

}  // namespace cairn
