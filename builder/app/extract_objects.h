#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "cairn/geo.h"
#include "cairn/pack_reader.h"
#include "cairn/status.h"

namespace cairn {

/// Writes the pack's objects as CSV, which a bake takes, in the order of the index; only those in the region
/// where there is one. Returns how many. An object that was placed by its absolute height has that above the
/// ground. REQUIRES: the whole index can be read.
Result<std::uint64_t> extract_objects(const PackReader& pack, const std::optional<GeoBounds>& region,
                                      const std::filesystem::path& output);

}  // namespace cairn
