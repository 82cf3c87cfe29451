#include "runtime/gl/resident_tiles.h"

#include <algorithm>
#include <string>
#include <utility>

namespace cairn::gl {

namespace {

/// Making room later costs a copy of all there is; making too much of it costs memory.
std::uint32_t first_layers(std::size_t expected) {
  return static_cast<std::uint32_t>(std::clamp<std::size_t>(expected, 16, 128));
}

}  // namespace

ResidentTiles::ResidentTiles(int tile_size, std::size_t expected)
    : tile_size_(tile_size),
      heights_(tile_size, first_layers(expected)),
      imagery_{ImageryTextures(TextureFormat::bc1, tile_size - 1, first_layers(expected)),
               ImageryTextures(TextureFormat::bc3, tile_size - 1, first_layers(expected)),
               ImageryTextures(TextureFormat::bc7, tile_size - 1, first_layers(expected))} {}

void ResidentTiles::begin_frame(const SurfaceFrame& frame) {
  uploaded_ = 0;
  for (const TileKey& key : frame.released) release(key);
  for (const SurfaceTextures& fresh : frame.fresh) {
    const std::uint32_t layer = heights_.add(fresh.id, fresh);
    resident_.insert_or_assign(fresh.id,
                               ResidentHeights{fresh.id, layer, fresh.heights.base, fresh.heights.shift, {}});
    ++uploaded_;
  }
}

void ResidentTiles::release(const TileKey& key) {
  if (key.layer == Layer::imagery) {
    for (ImageryTextures& array : imagery_) array.release(key.id);
    return;
  }
  resident_.erase(key.id);
  heights_.release(key.id);
}

void ResidentTiles::set_shadow(const TileShadow& shadow) {
  const auto known = resident_.find(shadow.id);
  if (known == resident_.end()) return;
  heights_.set_shadow(known->second.layer, shadow.texels);
  known->second.shadow_sun = shadow.to_sun;
}

const ResidentHeights* ResidentTiles::heights_of(const RenderTile& tile) const {
  if (!tile.heights) return nullptr;
  const auto known = resident_.find(tile.heights_id);
  return known == resident_.end() ? nullptr : &known->second;
}

std::optional<std::size_t> ResidentTiles::array_for(TextureFormat format) {
  for (std::size_t i = 0; i < imagery_.size(); ++i) {
    if (imagery_[i].format() != format) continue;
    if (imagery_[i].supported()) return i;
    if (!std::exchange(refused_[i], true)) {
      errors_.push_back(failed("OpenGL: imagery: expected a context with BC" +
                               std::to_string(static_cast<int>(format)) + ", found none"));
    }
  }
  return std::nullopt;
}

std::optional<ImageryPlace> ResidentTiles::imagery_of(const RenderTile& tile) {
  if (!tile.imagery) return std::nullopt;
  const auto index = array_for(tile.imagery->format);
  if (!index) return std::nullopt;
  ImageryTextures& array = imagery_[*index];
  auto layer = array.find(tile.imagery_id);
  if (!layer) {
    layer = array.add(tile.imagery_id, *tile.imagery);
    ++uploaded_;
  }
  return ImageryPlace{static_cast<std::int32_t>(*index), *layer};
}

void ResidentTiles::bind() const {
  heights_.bind(0, 1, 5);
  for (std::size_t i = 0; i < imagery_.size(); ++i) imagery_[i].bind(static_cast<GLuint>(2 + i));
}

std::uint64_t ResidentTiles::bytes() const {
  std::uint64_t sum = heights_.bytes();
  for (const ImageryTextures& array : imagery_) sum += array.bytes();
  return sum;
}

std::vector<Error> ResidentTiles::take_errors() {
  return std::exchange(errors_, {});
}

}  // namespace cairn::gl
