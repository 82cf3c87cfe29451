#include "cairn/loaded_objects.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "format/tile_number.h"

namespace cairn {
namespace {

constexpr int kPlaceBits = 16;  // of x and of y

std::uint64_t z_order(const StandingObject& object) {
  return z_curve(object.placed.x, object.placed.y);
}

}  // namespace

LoadedObjects::LoadedObjects(const TileId& tile, const ObjectTile& objects,
                             std::span<const std::uint16_t> numbers,
                             std::vector<std::shared_ptr<const ObjectModel>> models)
    : tile_(tile), models_(std::move(models)) {
  objects_.reserve(objects.objects.size());
  for (const PlacedObject& placed : objects.objects) {
    const auto at = std::lower_bound(numbers.begin(), numbers.end(), placed.model);
    assert(at != numbers.end() && *at == placed.model);
    const auto slot = static_cast<std::uint16_t>(at - numbers.begin());
    const float size_m = models_[slot]->size_m() * static_cast<float>(placed.scale_factor());
    objects_.push_back({placed, slot, size_m});
    largest_m_ = std::max(largest_m_, size_m);
  }
  std::stable_sort(objects_.begin(), objects_.end(),
                   [](const StandingObject& a, const StandingObject& b) { return z_order(a) < z_order(b); });
}

std::span<const StandingObject> LoadedObjects::inside(const TileId& area) const {
  assert(ancestor_of(area, tile_.level) == tile_);
  const int deeper = std::min(area.level - tile_.level, kPlaceBits);
  const TileId part = ancestor_of(area, tile_.level + deeper);
  // All objects of so small a part stand in its middle: in the descendant that has its corner there.
  if (const int below = area.level - part.level; below > 0) {
    const std::int32_t half = std::int32_t{1} << (below - 1);
    if (area.x != (part.x << below) + half || area.y != (part.y << below) + half) return {};
  }
  const auto column = static_cast<std::uint32_t>(part.x - (tile_.x << deeper));
  const auto row = static_cast<std::uint32_t>(part.y - (tile_.y << deeper));
  const int free_bits = 2 * (kPlaceBits - deeper);
  const std::uint64_t first = z_curve(column, row) << free_bits;
  const std::uint64_t last = first + (std::uint64_t{1} << free_bits);
  const auto before = [](const StandingObject& object, std::uint64_t z) { return z_order(object) < z; };
  const auto from = std::lower_bound(objects_.begin(), objects_.end(), first, before);
  return {from, std::lower_bound(from, objects_.end(), last, before)};
}

std::uint64_t LoadedObjects::bytes() const {
  return sizeof *this + objects_.capacity() * sizeof(StandingObject) +
         models_.capacity() * sizeof(models_[0]);
}

std::uint64_t LoadedObjects::bytes_bound(std::size_t objects) {
  return sizeof(LoadedObjects) +
         objects * (sizeof(StandingObject) + sizeof(std::shared_ptr<const ObjectModel>));
}

}  // namespace cairn
