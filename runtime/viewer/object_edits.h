#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cairn/body.h"
#include "cairn/geo.h"
#include "cairn/loaded_objects.h"
#include "cairn/status.h"
#include "cairn/surface.h"

namespace cairn::viewer {

/// An object that a user has placed on the ground.
struct Placement {
  LonLat at;
  std::string model;  ///< its name in the pack
  double heading_deg = 0;
  double scale = 1;
  std::string feature;  ///< the GeoJSON feature that it was read from, with all that is not said here
};

/// Returns the file beside a pack that keeps its placements: PACK.objects.json.
std::filesystem::path placements_path(const std::filesystem::path& pack);

/// The objects that are placed in the window, kept in a GeoJSON file that `cairn bake --objects` takes: each
/// change is on the disk when the call returns, written beside the file and renamed. Where that fails the
/// change is taken back. Properties that this program does not know are kept.
class ObjectEdits {
 public:
  /// Reads the file; none is no placements. bad_data where it is no collection of points with the name of a
  /// model: then it cannot be edited, so that nothing in it is lost.
  static Result<ObjectEdits> open(std::filesystem::path file);

  std::span<const Placement> all() const { return placements_; }
  bool can_undo() const { return !before_.empty(); }

  Status place(Placement placement);
  Status change(std::size_t index, Placement placement);  ///< REQUIRES: index < all().size()
  Status remove(std::size_t index);                       ///< likewise
  /// Takes the last change back, from the first of this session on.
  Status undo();

 private:
  explicit ObjectEdits(std::filesystem::path file) : file_(std::move(file)) {}
  Status become(std::vector<Placement> next);
  Status save(std::span<const Placement> placements) const;

  std::filesystem::path file_;
  std::vector<Placement> placements_;
  std::vector<std::vector<Placement>> before_;
};

/// Placements as tiles of objects that a frame can show.
struct PlacedTiles {
  std::vector<std::shared_ptr<const LoadedObjects>> tiles;
  std::vector<std::string> unknown;  ///< names of models that the pack does not have, each once

  /// Returns the number of the placement that an object of these tiles is.
  std::optional<std::size_t> placement_of(const ObjectHit& hit) const;

 private:
  struct Slot {
    TileId tile;
    PlacedObject object;
    std::size_t placement;
  };
  std::vector<Slot> slots_;
  friend PlacedTiles placed_tiles(std::span<const Placement> placements,
                                  std::span<const std::shared_ptr<const ObjectModel>> models,
                                  const Body& body);
};

/// `models`: of the pack, by number.
PlacedTiles placed_tiles(std::span<const Placement> placements,
                         std::span<const std::shared_ptr<const ObjectModel>> models, const Body& body);

}  // namespace cairn::viewer
