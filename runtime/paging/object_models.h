#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <unordered_map>

#include "cairn/loaded_objects.h"
#include "cairn/loaded_tile.h"
#include "cairn/pack_reader.h"
#include "cairn/read_tile.h"
#include "cairn/status.h"

namespace cairn {

/// What the models in memory are and take.
struct ObjectModelCounts {
  std::size_t resident = 0;  ///< now
  std::uint64_t bytes = 0;   ///< of these, without what a renderer makes of them
  std::uint64_t loads = 0;   ///< since the pack was opened
};

/// The models of a pack that are in memory: each once, for as long as a tile is kept that has it.
///
/// A tile's models are there before the tile is, so that a model that an old tile and its successor share is
/// not read again (Agrawal et al. 2006, §4.2). Any thread may call; one reads at a time.
class ObjectModels {
 public:
  explicit ObjectModels(std::shared_ptr<const PackReader> pack);

  /// Puts what a read of Layer::objects returned together with its models. Other tiles are returned as they
  /// are. An error is that of reading a model.
  Result<LoadedTile> complete(const IndexEntry& entry, LoadedTile tile);

  ObjectModelCounts counts() const;

 private:
  struct Counters;
  Result<std::shared_ptr<const ObjectModel>> get(std::uint16_t number);

  std::shared_ptr<const PackReader> pack_;
  std::shared_ptr<Counters> counters_;  // lives as long as the last model
  std::mutex mutex_;
  std::unordered_map<std::uint16_t, std::weak_ptr<const ObjectModel>> models_;  // guarded by mutex_
};

/// Returns the source with the models added to its tiles of objects.
TileSource with_models(TileSource source, std::shared_ptr<ObjectModels> models);

}  // namespace cairn
