#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "builder/heights/height_layer.h"
#include "builder/objects/object_layer.h"
#include "builder/pack/bake_plan.h"
#include "cairn/build_options.h"
#include "cairn/geo.h"
#include "cairn/status.h"
#include "format/pack_writer.h"

namespace cairn {

/// Returns the part of the bounds that lies in the region, whatever turn of longitudes that has, in one piece
/// also across 180°. A pack covers this part, also where whole tiles around it were baked. Returns the bounds
/// where they do not meet.
GeoBounds cut_to(const std::optional<GeoBounds>& region, const GeoBounds& bounds);

/// The metadata of a pack: what it covers, what it promises, what was measured, where it comes from. JSON,
/// the keys as docs/pack-format.md lists them. Nothing in it depends on the machine, the time or the folder.
/// The error is why the entries that are in `pack` so far could not be read back.
Result<std::string> describe_pack(const BakePlan& layers, const BuildOptions& options,
                                  const HeightSummary& heights, const std::optional<ObjectSummary>& objects,
                                  const std::vector<std::uint64_t>& input_hashes, const PackWriter& pack);

}  // namespace cairn
