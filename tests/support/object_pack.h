#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "cairn/object_model.h"
#include "cairn/object_tile.h"
#include "tests/support/test_pack.h"

namespace cairn::test {

/// A box without a floor, 2·radius_m wide and top_m high, in one colour, with a view of the same colour all
/// around. Each of its sides has 2·n² triangles; a second level has two, and a stated error.
ObjectModel box_model(const std::string& name, float radius_m, float top_m, std::array<std::uint8_t, 3> rgb,
                      int n = 1);

/// An object at a place, as PlacedObject has it.
struct TestObject {
  LonLat place;
  PlacedObject placed;
};

/// Writes a pack of these tiles of heights, the models, and the objects, each in its tile.
void write_object_pack(const std::filesystem::path& path, const TestSurface& surface,
                       const std::vector<TileId>& tiles, const std::vector<ObjectModel>& models,
                       const std::vector<TestObject>& objects);

}  // namespace cairn::test
