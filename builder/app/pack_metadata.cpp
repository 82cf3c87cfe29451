#include "builder/app/pack_metadata.h"

#include <algorithm>
#include <string>
#include <unordered_set>

#include <nlohmann/json.hpp>

namespace cairn {

Result<nlohmann::json> parse_metadata(const PackReader& pack) {
  nlohmann::json metadata = nlohmann::json::parse(pack.metadata_json(), nullptr, false);
  if (metadata.is_object()) return metadata;
  return bad_data(pack.path().string() + ": metadata: expected a JSON object, found " +
                  (metadata.is_discarded() ? "no JSON" : metadata.type_name()));
}

std::vector<LevelSummary> summarise_levels(const PackReader& pack, Layer layer) {
  std::vector<LevelSummary> levels;
  std::unordered_set<std::uint64_t> seen;  // offsets of the level's blocks
  for (std::size_t i = 0; i < pack.entry_count(); ++i) {
    const IndexEntry entry = pack.entry(i);
    if (entry.layer != layer) continue;
    if (levels.empty() || levels.back().level != entry.id.level) {
      levels.push_back({entry.id.level});
      seen.clear();
    }
    LevelSummary& level = levels.back();
    ++level.tiles;
    if ((entry.flags & kConstant) != 0) ++level.constant_tiles;
    if (entry.bytes != 0 && seen.insert(entry.offset).second) level.bytes += entry.bytes;
    level.max_error_m = std::max(level.max_error_m, static_cast<double>(entry.geometric_error_m));
  }
  return levels;
}

}  // namespace cairn
