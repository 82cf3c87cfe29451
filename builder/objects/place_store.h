#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "cairn/object_tile.h"
#include "cairn/status.h"
#include "format/file.h"

namespace cairn {

/// An object in its tile, before its ground is known.
struct StoredPlace {
  TileId tile;
  PlacedObject object;    ///< its height, too, where it is above the ground
  double absolute_m = 0;  ///< the foot where it is in the vertical datum
  bool is_absolute = false;
  std::uint32_t rule = 0;  ///< whose limits of the ground it keeps; 0 keeps none
};

/// Places that come in any order and go out by tile, in memory that does not grow with their number: sorted
/// runs of them lie in a scratch file, which has no name and is gone with the process.
class PlaceStore {
 public:
  /// The scratch file is made in `folder` when it is needed. `run_places` of them are in memory at most.
  PlaceStore(std::filesystem::path folder, std::size_t run_places);

  Status add(const StoredPlace& place);
  std::uint64_t size() const { return size_; }

  /// The places of one tile, sorted as a tile has them.
  using TakeTile = std::function<Status(const TileId&, std::vector<StoredPlace>&&)>;
  /// Calls `take` for each tile, finer levels first, within a level along the Z curve. Ends at the first
  /// error, also where a tile has more than kMostObjects.
  Status visit(const TakeTile& take);

  /// A place in the order of the store.
  struct Record {
    std::uint64_t key = 0;  ///< of the tile
    StoredPlace place;
  };

 private:
  struct Run {
    std::uint64_t offset = 0;
    std::uint64_t places = 0;
  };
  class RunReader;

  Status write_run();

  std::filesystem::path folder_;
  std::size_t run_places_;
  std::optional<File> scratch_;
  std::uint64_t scratch_bytes_ = 0;
  std::uint64_t size_ = 0;
  std::vector<Run> runs_;
  std::vector<Record> latest_;
};

}  // namespace cairn
