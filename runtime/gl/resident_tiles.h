#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include <glm/vec3.hpp>

#include "cairn/render_list.h"
#include "cairn/status.h"
#include "cairn/surface.h"
#include "runtime/gl/tile_textures.h"
#include "runtime/light/sun_shadows.h"

namespace cairn::gl {

/// Where a tile of heights is on the GPU, and how its texels are read.
struct ResidentHeights {
  TileId id;
  std::uint32_t layer = 0;
  std::int32_t base = 0;  ///< of HeightTexels
  int shift = 0;
  std::optional<glm::dvec3> shadow_sun;  ///< for which the layer has a shadow
};

/// Where a tile of imagery is on the GPU.
struct ImageryPlace {
  std::int32_t array = 0;  ///< of the three formats, BC1, BC3, BC7
  std::uint32_t layer = 0;
};

/// The tiles that frames show, uploaded when first shown, and kept until a frame releases them.
class ResidentTiles {
 public:
  /// `expected`: tiles of a layer that there will be at most, as far as is known.
  ResidentTiles(int tile_size, std::size_t expected);

  /// Takes the heights that a frame brings, and drops what it releases.
  void begin_frame(const SurfaceFrame& frame);
  /// nullptr where the tile has none.
  const ResidentHeights* heights_of(const RenderTile& tile) const;
  /// nullopt where the tile has none or the context cannot read its format.
  std::optional<ImageryPlace> imagery_of(const RenderTile& tile);

  /// Takes a shadow; that of a tile which is no longer here is dropped.
  void set_shadow(const TileShadow& shadow);

  void bind() const;  ///< heights, normals, the three formats of imagery and shadows to the units 0…5
  int cells_log2() const { return std::countr_zero(static_cast<unsigned>(tile_size_ - 1)); }
  int tile_size() const { return tile_size_; }
  std::size_t uploads() const { return uploaded_; }  ///< tiles of this frame
  std::uint64_t bytes() const;
  /// What this context cannot show, each once, since the last call.
  std::vector<Error> take_errors();

 private:
  void release(const TileKey& key);
  std::optional<std::size_t> array_for(TextureFormat format);

  int tile_size_;
  HeightTextures heights_;
  std::array<ImageryTextures, 3> imagery_;
  std::unordered_map<TileId, ResidentHeights> resident_;
  std::array<bool, 3> refused_{};
  std::vector<Error> errors_;
  std::size_t uploaded_ = 0;
};

}  // namespace cairn::gl
