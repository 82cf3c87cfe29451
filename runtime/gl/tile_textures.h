#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cairn/surface.h"
#include "cairn/texture_tile.h"
#include "runtime/gl/layer_array.h"
#include "runtime/gl/slot_pool.h"

namespace cairn::gl {

/// The heights, normals and shadows of tiles, a layer each of three array textures. A tile stays until it is
/// released.
class HeightTextures {
 public:
  /// Room for `first_layers` is made with the first tile, for twice as many when that is used up.
  HeightTextures(int tile_size, std::uint32_t first_layers);

  void release(const TileId& id) { slots_.release(id); }
  std::optional<std::uint32_t> find(const TileId& id) { return slots_.find(id); }
  /// REQUIRES: find() has said no. Grows where all layers are in use.
  std::uint32_t add(const TileId& id, const SurfaceTextures& upload);
  /// Gives a layer the shadow of its tile, as tile_shadow() has it; before, it has none.
  void set_shadow(std::uint32_t layer, const std::vector<std::int8_t>& texels);
  void bind(GLuint heights_unit, GLuint normals_unit, GLuint shadows_unit) const;
  std::uint64_t bytes() const;

 private:
  std::uint32_t first_layers_;
  SlotPool<TileId> slots_;
  LayerArray heights_;
  LayerArray normals_;
  LayerArray shadows_;  // without layers until the first shadow
};

/// The imagery of tiles in one block format, uploaded as the pack stores it. A tile stays until it is
/// released.
class ImageryTextures {
 public:
  ImageryTextures(TextureFormat format, int size, std::uint32_t first_layers);

  /// Whether this context can read the format.
  bool supported() const { return supported_; }
  TextureFormat format() const { return format_; }
  void release(const TileId& id) { slots_.release(id); }
  std::optional<std::uint32_t> find(const TileId& id) { return slots_.find(id); }
  /// REQUIRES: supported(), find() has said no, and the tile is of this format and size.
  std::uint32_t add(const TileId& id, const TextureTile& tile);
  void bind(GLuint unit) const;
  std::uint64_t bytes() const;

 private:
  TextureFormat format_;
  std::uint32_t first_layers_;
  bool supported_ = false;
  SlotPool<TileId> slots_;
  LayerArray layers_;
};

}  // namespace cairn::gl
