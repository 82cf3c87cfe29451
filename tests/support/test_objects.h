#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "cairn/object_model.h"
#include "cairn/object_tile.h"

namespace cairn::test {

/// A box of this width and height on its foot, in two levels of detail, with random texels.
ObjectModel box_model(const std::string& name, float width_m, float height_m);

/// A model of an image: one view, no triangles.
ObjectModel picture_model(const std::string& name, float width_m, float height_m);

/// Objects at random places of a tile, of models 0 to models - 1.
ObjectTile random_objects(std::size_t count, std::uint16_t models, unsigned seed);

}  // namespace cairn::test
