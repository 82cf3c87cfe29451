#pragma once

// START HERE to draw with a renderer of your own: what a Terrain lists becomes vertices, triangles and
// texels.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "cairn/pack_layout.h"
#include "cairn/read_tile.h"
#include "cairn/render_list.h"
#include "cairn/surface_mesh.h"
#include "cairn/surface_objects.h"
#include "cairn/view_state.h"

namespace cairn {

/// Heights as a texture stores them: quanta = base + (texel << shift), rows from the south. 65535 is a void.
struct HeightTexels {
  std::int32_t base = 0;
  int shift = 0;  ///< 0 unless the tile spans more than 65534 quanta: 16 km at 0.25 m
  std::vector<std::uint16_t> texels;
};

/// What colours need of a tile of heights.
struct SurfaceTextures {
  TileId id;
  HeightTexels heights;            ///< tile_size × tile_size; for voids and tints
  std::vector<std::byte> normals;  ///< signed BC5, (tile_size − 1)², kNormalMips mips: the east and north
                                   ///< parts of the cells' normals, rows from the south
};
inline constexpr int kNormalMips = 4;
inline constexpr std::uint16_t kVoidTexel = 65535;

/// Where a patch lies in a tile that covers it, 0…1 from the tile's south-west corner.
struct SurfaceWindow {
  glm::dvec2 origin{0};
  double scale = 1;
};
SurfaceWindow window_in(const TileId& tile, const TileId& patch);

/// How a frame's surface is made.
struct SurfaceView {
  ViewState view;
  double tolerance_px = 1;    ///< screen error of mesh and tiles together, as TerrainOptions has it; > 0
  double frame_s = 1.0 / 60;  ///< since the last frame: what is exchanged glides with the clock
  double object_px = 2;       ///< objects that are not larger are not drawn, as TerrainOptions has it; > 0
  std::span<const std::shared_ptr<const LoadedObjects>> added = {};  ///< objects beside those of the list
};

/// One frame. Its buffers' rules are those of SurfaceMesh; it holds until the next call of Surface::frame().
struct SurfaceFrame {
  SurfaceMesh mesh;
  SurfaceObjects objects;  ///< they stand on the mesh
  /// What SurfaceDraw::tile numbers. Those of a frame that glide are of older lists, kept alive here.
  std::vector<const RenderTile*> tiles;
  std::vector<SurfaceTextures> fresh;  ///< of tiles that no frame since their release has shown
  std::vector<TileKey> released;       ///< tiles that are shown no more and no longer in memory
};

/// An object that a ray meets.
struct ObjectHit {
  TileId tile;
  PlacedObject object;
  std::shared_ptr<const ObjectModel> model;
  glm::dvec3 foot{0};     ///< geocentric metres, as it was drawn
  double distance_m = 0;  ///< along the ray
};

/// The surface of one pack for one eye: closed over tiles of any levels, missing tiles, the poles and ±180°,
/// and gliding from one level to the next. Knows no graphics.
///
/// Threads: a Surface belongs to one thread, that of Terrain::update(). What preparing() returns is called
/// on the workers, at the same time; it does there what takes long, some 20 ms a tile. A Surface has up to
/// four threads of its own, which share the making of triangles with frame() while it runs.
/// Lifetimes: a Surface may be destroyed before the Terrain. A draw's ranges stay where they are while a
/// frame shows it, and for eight frames after; then another draw may have them, which an upload says. Cost: a
/// frame chooses, and makes the triangles of what is new; docs/viewer.md has the figures.
class Surface {
 public:
  /// `header`: of the pack.
  explicit Surface(const PackHeader& header);
  Surface(Surface&&) noexcept;
  Surface& operator=(Surface&&) noexcept;
  ~Surface();

  /// Returns `read`, with each tile of heights prepared on the thread that reads it. For Terrain::open();
  /// without it tiles are prepared in frame(), which then takes as much longer.
  ReadTile preparing(ReadTile read) const;

  /// Call once a frame, with the list of the same eye.
  const SurfaceFrame& frame(const RenderList& list, const SurfaceView& view);

  /// Takes note of what a list that no frame is made of says is no longer in memory.
  void skip(const RenderList& list);

  /// The next frame has nothing to do with the last one: a cut in a film. Nothing glides into it.
  void cut();

  /// The height of the ground at a place as the last frame drew it, but for the tolerance; nullopt where
  /// there is none.
  std::optional<double> ground_m(LonLat place) const;

  /// Returns the nearest object of the last frame whose model a ray meets, the billboards of images apart;
  /// nullopt where it meets none. Both are geocentric, in metres; the direction is of any length but 0.
  std::optional<ObjectHit> pick(const glm::dvec3& origin, const glm::dvec3& direction) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cairn
