#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "builder/bake_plan.h"
#include "builder/heights/height_layer.h"
#include "cairn/build_options.h"
#include "cairn/pack_layout.h"

namespace cairn {

/// The metadata of a pack: what it covers, what it promises, what was measured, where it comes from. JSON,
/// the keys as docs/pack-format.md lists them. Nothing in it depends on the machine, the time or the folder.
std::string describe_pack(const BakePlan& layers, const BuildOptions& options, const HeightSummary& heights,
                          const std::vector<std::uint64_t>& input_hashes,
                          const std::vector<IndexEntry>& entries);

}  // namespace cairn
