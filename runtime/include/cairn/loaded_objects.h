#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "cairn/object_model.h"
#include "cairn/object_tile.h"
#include "cairn/tile_id.h"

namespace cairn {

/// How far an object of size 1 reaches from its foot, where that is between its lowest and highest point:
/// half its size aside, all of it upwards.
inline constexpr double kReachPerSize = 1.12;

/// An object of a tile in memory.
struct StandingObject {
  PlacedObject placed;
  std::uint16_t slot = 0;  ///< of LoadedObjects::models()
  float size_m = 0;        ///< of its model, times its scale

  float reach_m() const { return static_cast<float>(kReachPerSize) * size_m; }
};

/// The objects of one tile with their models, in the order of a Z curve, so that those of any square of the
/// quadtree below the tile follow each other. Immutable: any thread may read it for as long as it keeps the
/// pointer. While a tile is kept its models are.
class LoadedObjects {
 public:
  /// REQUIRES: `models` has, at place i, the model of number `numbers[i]`; the numbers ascend, and every
  /// object's model is one of them.
  LoadedObjects(const TileId& tile, const ObjectTile& objects, std::span<const std::uint16_t> numbers,
                std::vector<std::shared_ptr<const ObjectModel>> models);

  const TileId& tile() const { return tile_; }
  std::span<const StandingObject> all() const { return objects_; }
  const std::vector<std::shared_ptr<const ObjectModel>>& models() const { return models_; }
  float largest_m() const { return largest_m_; }  ///< of the sizes; 0 without objects

  /// Returns the objects whose feet are in an area. Each object is in one of the areas that divide a tile.
  /// REQUIRES: the tile covers the area.
  std::span<const StandingObject> inside(const TileId& area) const;

  /// Returns the bytes of memory that it takes, without the models.
  std::uint64_t bytes() const;
  /// Returns the most bytes that so many objects can take.
  static std::uint64_t bytes_bound(std::size_t objects);

 private:
  TileId tile_;
  std::vector<StandingObject> objects_;
  std::vector<std::shared_ptr<const ObjectModel>> models_;
  float largest_m_ = 0;
};

}  // namespace cairn
