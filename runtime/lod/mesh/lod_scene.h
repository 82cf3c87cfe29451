#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "cairn/bounding_volume.h"
#include "cairn/height_tile.h"
#include "cairn/view_state.h"
#include "runtime/view/sample_lattice.h"

namespace cairn {

/// An area of a body, and the tile whose heights are drawn there.
struct LodTile {
  TileId area;                                ///< inside the world, without overhang
  TileId source;                              ///< the area or an ancestor, with samples at the area's corners
  std::shared_ptr<const HeightTile> heights;  ///< of the source; never null
  double min_m = 0;                           ///< over the source, voids not counted
  double max_m = 0;
  double error_m = 0;     ///< bound of the distance of the source's surface from the finest samples under the
                          ///< area; 0 where these are the source's own
  BoundingVolume volume;  ///< of the area between min_m and max_m
  std::shared_ptr<const std::vector<std::byte>> flags;  ///< the source's block of Layer::rqt, if there is one
};

/// The areas that are drawn; they do not overlap. Where two sources have a sample, its heights agree.
struct LodScene {
  int tile_size = 513;
  double quantum_m = 0.25;
  double lowest_m = 0;  ///< no height of the pack is below
  std::vector<LodTile> tiles;
  Ellipsoid ellipsoid = {};  ///< of the body
};

struct LodView {
  ViewState view;
  double tolerance_px = 1;  ///< > 0
  bool cull = false;        ///< what is certainly outside the viewport or below the horizon may be left out
};

/// A sample. Equal points are equal places, whichever tile they come from; so are x and x + kLatticeAround.
struct LodVertex {
  LatticePoint point;
  double height_m = 0;  ///< quanta · quantum_m; at a void sample the filler's
  friend bool operator==(const LodVertex&, const LodVertex&) = default;
};

/// Three vertex numbers, anticlockwise as seen from above.
using LodTriangle = std::array<std::uint32_t, 3>;

/// The mesh of one tile of the scene.
struct LodTileMesh {
  std::size_t tile = 0;  ///< in LodScene::tiles
  std::vector<LodVertex> vertices;
  std::vector<LodTriangle> triangles;
};

/// The forms of an index buffer (Vaněk & Ježek 2004, table 1). One draw call draws one part.
enum class IndexForm : std::uint8_t { list, fan, strip, degenerate_strip };
inline constexpr std::array kIndexForms{IndexForm::list, IndexForm::fan, IndexForm::strip,
                                        IndexForm::degenerate_strip};
struct IndexCount {
  std::uint64_t indices = 0;
  std::uint64_t parts = 0;
};

/// A watertight mesh: triangles meet along whole edges, within and between tiles of any levels.
/// Void samples are part of the mesh; a renderer masks them.
struct LodMesh {
  std::vector<LodTileMesh> tiles;
  /// Upright triangles between rims that do not share their vertices, either way round; of no tile.
  LodTileMesh walls;
  /// Index counts of the method's own triangulation, in the forms that its paper has; every method has
  /// `list`.
  std::array<std::optional<IndexCount>, 4> forms;
  double selection_s = 0;  ///< CPU seconds for choosing what is drawn
  double building_s = 0;   ///< CPU seconds for vertices, indices and joining tiles

  std::size_t triangle_count() const {
    std::size_t count = walls.triangles.size();
    for (const LodTileMesh& tile : tiles) count += tile.triangles.size();
    return count;
  }
  const std::optional<IndexCount>& form(IndexForm f) const { return forms[static_cast<std::size_t>(f)]; }
  /// Adds to the form's count.
  void count(IndexForm f, IndexCount more) {
    std::optional<IndexCount>& sum = forms[static_cast<std::size_t>(f)];
    if (!sum) sum.emplace();
    sum->indices += more.indices;
    sum->parts += more.parts;
  }
};

}  // namespace cairn
