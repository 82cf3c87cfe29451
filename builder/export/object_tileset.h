#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "builder/export/export_folder.h"
#include "builder/export/vertical_shift.h"
#include "cairn/geo.h"
#include "cairn/pack_reader.h"
#include "cairn/status.h"

namespace cairn {

/// The root of a tileset of objects.
struct ObjectTileset {
  std::array<double, 6> region{};  ///< west, south, east, north in radians, lowest and highest in metres
  double error_m = 0;              ///< its geometricError
  std::uint64_t objects = 0;
  std::uint64_t models = 0;
  std::uint64_t bytes = 0;
};

/// Writes the pack's objects as tiles of 3D Tiles 1.1: objects/tileset.json, a GLB of instances per tile, and
/// the models that they share in objects/models. nullopt where none is in the region.
///
/// An object is in one tile, as in the pack, and a tile adds to those above it. Feet stand on the pack's
/// finest ground, shifted as the heights of the export are. A client draws the objects that are larger than a
/// quarter of the error in pixels that it allows: 4 pixels in CesiumJS.
Result<std::optional<ObjectTileset>> write_object_tileset(const PackReader& pack,
                                                          const std::optional<GeoBounds>& region,
                                                          const VerticalShift& shift,
                                                          const ExportFolder& folder);

}  // namespace cairn
