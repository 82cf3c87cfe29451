#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "cairn/status.h"
#include "runtime/gl/tile_textures.h"
#include "cairn/render_list.h"
#include "runtime/surface/height_preparation.h"
#include "runtime/surface/lod_transition.h"

namespace cairn::gl {

/// A tile of heights that is on the GPU.
struct ResidentHeights {
  SurfaceTile surface;
  std::int32_t base = 0;  ///< of HeightTexels
  int shift = 0;
};

/// Where a tile of imagery is on the GPU.
struct ImageryPlace {
  std::int32_t array = 0;  ///< of the three formats, BC1, BC3, BC7
  std::uint32_t layer = 0;
};

/// The tiles that frames show, uploaded when first asked for, and kept until they are evicted from memory: so
/// that a tile is prepared once, on a worker.
class ResidentTiles {
 public:
  /// `expected`: tiles of a layer that there will be at most, as far as is known.
  ResidentTiles(int tile_size, double quantum_m, std::size_t expected, PreparedHeights& uploads);

  /// `evicted` are no longer in memory: what was prepared for them is dropped, and their textures with
  /// the first frame that shows them no more, whose tiles are `shown`.
  void begin_frame(std::span<const TileKey> evicted, std::span<const ShownTile> shown);
  /// nullptr where the tile has none.
  const ResidentHeights* heights_of(const RenderTile& tile);
  std::uint32_t height_layer(const ResidentHeights& heights) { return *heights_.find(heights.surface.id); }
  /// nullopt where the tile has none or the context cannot read its format.
  std::optional<ImageryPlace> imagery_of(const RenderTile& tile);

  void bind() const;  ///< heights, normals and the three formats to the units 0…4
  int tile_size() const { return tile_size_; }
  std::size_t uploads() const { return uploaded_; }  ///< tiles of this frame
  std::uint64_t bytes() const;
  /// What this context cannot show, each once, since the last call.
  std::vector<Error> take_errors();

 private:
  void release(const TileKey& key);
  std::optional<std::size_t> array_for(TextureFormat format);

  int tile_size_;
  double quantum_m_;
  PreparedHeights& prepared_;
  HeightTextures heights_;
  std::array<ImageryTextures, 3> imagery_;
  std::unordered_map<TileId, ResidentHeights> surfaces_;
  std::vector<TileKey> evicted_;  // and shown on
  std::array<bool, 3> refused_{};
  std::vector<Error> errors_;
  std::size_t uploaded_ = 0;
};

}  // namespace cairn::gl
