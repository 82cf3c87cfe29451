#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "format/texture_tile.h"
#include "runtime/gl/height_upload.h"
#include "runtime/gl/layer_array.h"
#include "runtime/gl/slot_pool.h"

namespace cairn::gl {

/// The heights and normals of tiles, a layer each of two array textures.
class HeightTextures {
 public:
  explicit HeightTextures(int tile_size);

  void begin_frame() { slots_.begin_frame(); }
  std::optional<std::uint32_t> find(const TileId& id) { return slots_.find(id); }
  /// REQUIRES: find() has said no. Grows where all layers are in use.
  std::uint32_t add(const TileId& id, const HeightUpload& upload);
  void bind(GLuint heights_unit, GLuint normals_unit) const;
  std::uint64_t bytes() const;

 private:
  SlotPool<TileId> slots_;
  LayerArray heights_;
  LayerArray normals_;
};

/// The imagery of tiles in one block format, uploaded as the pack stores it.
class ImageryTextures {
 public:
  ImageryTextures(TextureFormat format, int size);

  /// Whether this context can read the format.
  bool supported() const { return supported_; }
  TextureFormat format() const { return format_; }
  void begin_frame() { slots_.begin_frame(); }
  std::optional<std::uint32_t> find(const TileId& id) { return slots_.find(id); }
  /// REQUIRES: supported(), find() has said no, and the tile is of this format and size.
  std::uint32_t add(const TileId& id, const TextureTile& tile);
  void bind(GLuint unit) const;
  std::uint64_t bytes() const;

 private:
  TextureFormat format_;
  bool supported_ = false;
  SlotPool<TileId> slots_;
  LayerArray layers_;
};

}  // namespace cairn::gl
