#include "runtime/gl/resident_tiles.h"

#include <algorithm>
#include <string>
#include <unordered_set>
#include <utility>

namespace cairn::gl {

namespace {

/// Making room later costs a copy of all there is; making too much of it costs memory.
std::uint32_t first_layers(std::size_t expected) {
  return static_cast<std::uint32_t>(std::clamp<std::size_t>(expected, 16, 128));
}

}  // namespace

ResidentTiles::ResidentTiles(int tile_size, double quantum_m, std::size_t expected, PreparedHeights& uploads)
    : tile_size_(tile_size),
      quantum_m_(quantum_m),
      prepared_(uploads),
      heights_(tile_size, first_layers(expected)),
      imagery_{ImageryTextures(TextureFormat::bc1, tile_size - 1, first_layers(expected)),
               ImageryTextures(TextureFormat::bc3, tile_size - 1, first_layers(expected)),
               ImageryTextures(TextureFormat::bc7, tile_size - 1, first_layers(expected))} {}

void ResidentTiles::begin_frame(std::span<const TileKey> evicted, std::span<const ShownTile> shown) {
  uploaded_ = 0;
  for (const TileKey& key : evicted) {
    if (key.layer == Layer::heights) prepared_.forget(key.id);
  }
  evicted_.insert(evicted_.end(), evicted.begin(), evicted.end());
  if (evicted_.empty()) return;
  std::unordered_set<TileKey> used;
  for (const ShownTile& each : shown) {
    used.insert({Layer::heights, each.tile.heights_id});
    used.insert({Layer::imagery, each.tile.imagery_id});
  }
  std::erase_if(evicted_, [&](const TileKey& key) {
    if (used.contains(key)) return false;
    release(key);
    return true;
  });
}

void ResidentTiles::release(const TileKey& key) {
  if (key.layer == Layer::imagery) {
    for (ImageryTextures& array : imagery_) array.release(key.id);
    return;
  }
  surfaces_.erase(key.id);
  heights_.release(key.id);
}

const ResidentHeights* ResidentTiles::heights_of(const RenderTile& tile) {
  if (!tile.heights) return nullptr;
  const auto known = surfaces_.find(tile.heights_id);
  if (known != surfaces_.end()) return &known->second;
  HeightUpload upload = prepared_.take(tile.heights_id, *tile.heights, quantum_m_);
  heights_.add(tile.heights_id, upload);
  ++uploaded_;
  const HeightTexels& texels = upload.heights;
  ResidentHeights resident{
      {tile.heights_id, tile.heights, quantum_m_, texels.shift == 0, std::move(upload.relief)},
      texels.base,
      texels.shift};
  return &surfaces_.insert_or_assign(tile.heights_id, std::move(resident)).first->second;
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
  heights_.bind(0, 1);
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
