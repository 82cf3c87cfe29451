#include "runtime/gl/tile_textures.h"

#include <algorithm>
#include <bit>
#include <cassert>

#include "runtime/gl/software_driver.h"
#include "runtime/gl/texture_format.h"

namespace cairn::gl {
namespace {

constexpr float kAnisotropy = 4;

void clamp_to_edge(GLuint texture) {
  glTextureParameteri(texture, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

void filter_linear(GLuint texture) {
  clamp_to_edge(texture);
  glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
}

void filter_imagery(GLuint texture) {
  filter_linear(texture);
  // Mesa's software driver (22.3) reads wrong texels for single pixels when it filters anisotropically.
  if (draws_in_software()) return;
  if (epoxy_has_gl_extension("GL_ARB_texture_filter_anisotropic") ||
      epoxy_has_gl_extension("GL_EXT_texture_filter_anisotropic")) {
    glTextureParameterf(texture, GL_TEXTURE_MAX_ANISOTROPY, kAnisotropy);
  }
}

void filter_without_mips(GLuint texture) {
  clamp_to_edge(texture);
  glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
}

/// The layer for a tile; doubles the arrays where every layer is in use.
template <class Grow>
std::uint32_t layer_for(SlotPool<TileId>& slots, const TileId& id, std::uint32_t first, Grow grow) {
  if (const auto slot = slots.take_free(id)) return *slot;
  const std::uint32_t capacity = std::max(first, slots.capacity() * 2);
  grow(capacity);
  slots.grow(capacity);
  return *slots.take_free(id);
}

void upload_compressed(const LayerArray& array, std::uint32_t layer, int mip, std::size_t bytes,
                       const std::byte* texels) {
  const GLsizei size = std::max(array.size() >> mip, 1);
  glCompressedTextureSubImage3D(array.name(), mip, 0, 0, static_cast<GLint>(layer), size, size, 1,
                                array.format(), static_cast<GLsizei>(bytes), texels);
}

/// All lit.
void clear_shadow(const LayerArray& shadows, std::uint32_t first, std::uint32_t count) {
  const GLbyte lit = -127;
  glClearTexSubImage(shadows.name(), 0, 0, 0, static_cast<GLint>(first), shadows.size(), shadows.size(),
                     static_cast<GLsizei>(count), GL_RED, GL_BYTE, &lit);
}

}  // namespace

HeightTextures::HeightTextures(int tile_size, std::uint32_t first_layers)
    : first_layers_(first_layers),
      heights_(GL_R16, tile_size, 1),
      normals_(GL_COMPRESSED_SIGNED_RG_RGTC2, tile_size - 1, kNormalMips),
      shadows_(GL_R8_SNORM, tile_size, 1) {}

std::uint32_t HeightTextures::add(const TileId& id, const SurfaceTextures& upload) {
  const std::uint32_t layer = layer_for(slots_, id, first_layers_, [this](std::uint32_t capacity) {
    heights_.grow(capacity, filter_without_mips);
    normals_.grow(capacity, filter_linear);
  });
  if (layer < shadows_.layers()) clear_shadow(shadows_, layer, 1);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage3D(heights_.name(), 0, 0, 0, static_cast<GLint>(layer), heights_.size(), heights_.size(),
                      1, GL_RED, GL_UNSIGNED_SHORT, upload.heights.texels.data());
  const std::byte* texels = upload.normals.data();
  for (int mip = 0; mip < kNormalMips; ++mip) {
    const auto side = static_cast<std::size_t>(normals_.size() >> mip);
    upload_compressed(normals_, layer, mip, side * side, texels);
    texels += side * side;
  }
  return layer;
}

void HeightTextures::set_shadow(std::uint32_t layer, const std::vector<std::int8_t>& texels) {
  if (const std::uint32_t had = shadows_.layers(); had < slots_.capacity()) {
    shadows_.grow(slots_.capacity(), filter_without_mips);
    clear_shadow(shadows_, had, slots_.capacity() - had);
  }
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage3D(shadows_.name(), 0, 0, 0, static_cast<GLint>(layer), shadows_.size(), shadows_.size(),
                      1, GL_RED, GL_BYTE, texels.data());
}

void HeightTextures::bind(GLuint heights_unit, GLuint normals_unit, GLuint shadows_unit) const {
  glBindTextureUnit(heights_unit, heights_.name());
  glBindTextureUnit(normals_unit, normals_.name());
  glBindTextureUnit(shadows_unit, shadows_.name());
}

std::uint64_t HeightTextures::bytes() const {
  const auto samples =
      static_cast<std::uint64_t>(heights_.size()) * static_cast<std::uint64_t>(heights_.size());
  const auto cells =
      static_cast<std::uint64_t>(normals_.size()) * static_cast<std::uint64_t>(normals_.size());
  return slots_.capacity() * (samples * 2 + cells * 4 / 3) + shadows_.layers() * samples;
}

ImageryTextures::ImageryTextures(TextureFormat format, int size, std::uint32_t first_layers)
    : format_(format),
      first_layers_(first_layers),
      supported_(can_read(format)),
      layers_(srgb_format(format), size, std::bit_width(static_cast<unsigned>(size))) {}

std::uint32_t ImageryTextures::add(const TileId& id, const TextureTile& tile) {
  assert(supported_ && tile.format == format_ && tile.size == layers_.size());
  const std::uint32_t layer = layer_for(
      slots_, id, first_layers_, [this](std::uint32_t capacity) { layers_.grow(capacity, filter_imagery); });
  const std::byte* texels = tile.texels.data();
  for (int mip = 0; mip < layers_.mips(); ++mip) {
    const std::size_t bytes = texture_image_bytes(format_, std::max(layers_.size() >> mip, 1));
    upload_compressed(layers_, layer, mip, bytes, texels);
    texels += bytes;
  }
  return layer;
}

void ImageryTextures::bind(GLuint unit) const {
  glBindTextureUnit(unit, layers_.name());
}

std::uint64_t ImageryTextures::bytes() const {
  return slots_.capacity() * static_cast<std::uint64_t>(texture_chain_bytes(format_, layers_.size()));
}

}  // namespace cairn::gl
