#include "cairn/read_tile.h"

#include <string>
#include <utility>

#include "cairn/texture_tile.h"
#include "format/checksum.h"
#include "format/height_block.h"

namespace cairn {
namespace {

std::string place_of(const IndexEntry& entry) {
  return std::string(to_string(entry.layer)) + " tile " + to_string(entry.id) + ": ";
}

LoadedTile loaded(HeightTile tile) {
  return {std::make_shared<const HeightTile>(std::move(tile)), nullptr};
}

LoadedTile loaded(TextureTile tile) {
  return {nullptr, std::make_shared<const TextureTile>(std::move(tile))};
}

LoadedTile loaded(ObjectTile tile) {
  return {nullptr, nullptr, std::make_shared<const ObjectTile>(std::move(tile))};
}

/// The colour of a constant tile is the index's: R, G, B, A from the lowest byte.
TextureTile solid_texture(std::uint32_t rgba, int size) {
  TextureTile tile{TextureFormat::bc3, size, {}};
  tile.texels.resize(texture_chain_bytes(tile.format, size));
  const std::uint32_t r = rgba & 255, g = rgba >> 8 & 255, b = rgba >> 16 & 255, a = rgba >> 24;
  const std::uint32_t colour = (r * 31 + 127) / 255 << 11 | (g * 63 + 127) / 255 << 5 | (b * 31 + 127) / 255;
  for (std::size_t block = 0; block < tile.texels.size(); block += 16) {
    tile.texels[block] = static_cast<std::byte>(a);
    tile.texels[block + 8] = tile.texels[block + 10] = static_cast<std::byte>(colour & 255);
    tile.texels[block + 9] = tile.texels[block + 11] = static_cast<std::byte>(colour >> 8);
  }
  return tile;
}

LoadedTile constant_tile(const IndexEntry& entry, int tile_size) {
  if (entry.layer == Layer::imagery) {
    return loaded(solid_texture(static_cast<std::uint32_t>(entry.min_quanta), tile_size - 1));
  }
  if (entry.layer == Layer::objects) return loaded(ObjectTile());
  const auto side = static_cast<std::size_t>(tile_size);
  return loaded(HeightTile{tile_size, std::vector<std::int32_t>(side * side, entry.min_quanta), {}});
}

Error wrong_tile(const IndexEntry& entry, const std::string& expected, const std::string& found) {
  return bad_data(place_of(entry) + "expected " + expected + ", found " + found);
}

Status check_heights(const IndexEntry& entry, const HeightTile* tile, int tile_size) {
  const auto side = static_cast<std::size_t>(tile_size);
  const std::string expected = std::to_string(side * side) + " samples";
  if (tile == nullptr) return wrong_tile(entry, expected, "no heights");
  if (tile->size != tile_size || tile->samples.size() != side * side) {
    return wrong_tile(
        entry, expected,
        std::to_string(tile->samples.size()) + " of a tile of size " + std::to_string(tile->size));
  }
  if (tile->voids.empty() || tile->voids.size() == side * side) return {};
  return wrong_tile(entry, "no voids or " + std::to_string(side * side), std::to_string(tile->voids.size()));
}

Status check_texture(const IndexEntry& entry, const TextureTile* tile, int size) {
  if (tile == nullptr) return wrong_tile(entry, "a texture", "none");
  const bool is_known = tile->format == TextureFormat::bc1 || tile->format == TextureFormat::bc3 ||
                        tile->format == TextureFormat::bc7;
  if (!is_known) {
    return wrong_tile(entry, "BC1, BC3 or BC7",
                      "texture format " + std::to_string(static_cast<int>(tile->format)));
  }
  const std::size_t bytes = texture_chain_bytes(tile->format, size);
  if (tile->size == size && tile->texels.size() == bytes) return {};
  return wrong_tile(
      entry, std::to_string(bytes) + " bytes of texels",
      std::to_string(tile->texels.size()) + " of a texture of size " + std::to_string(tile->size));
}

Status check_objects(const IndexEntry& entry, const LoadedTile& tile) {
  if (!tile.objects && !tile.standing) return wrong_tile(entry, "objects", "none");
  const std::size_t objects = tile.objects ? tile.objects->objects.size() : tile.standing->all().size();
  if (std::cmp_equal(objects, entry.min_quanta)) return {};
  return wrong_tile(entry, std::to_string(entry.min_quanta) + " objects", std::to_string(objects));
}

Result<LoadedTile> decode_block(const IndexEntry& entry, std::span<const std::byte> block, int tile_size) {
  if (entry.layer == Layer::imagery) {
    Result<TextureTile> tile = decode_texture_block(block, tile_size - 1);
    if (!tile) return Error{tile.error().code, place_of(entry) + tile.error().message};
    return loaded(std::move(*tile));
  }
  if (entry.layer == Layer::objects) {
    Result<ObjectTile> tile = decode_object_block(block);
    if (!tile) return Error{tile.error().code, place_of(entry) + tile.error().message};
    return loaded(std::move(*tile));
  }
  Result<HeightTile> tile = decode_height_block(block, tile_size);
  if (!tile) return Error{tile.error().code, place_of(entry) + tile.error().message};
  return loaded(std::move(*tile));
}

}  // namespace

ReadTile read_from(std::shared_ptr<const PackReader> pack) {
  return [pack = std::move(pack)](const IndexEntry& entry) -> Result<LoadedTile> {
    const int tile_size = pack->header().tile_size;
    if ((entry.flags & kConstant) != 0) return constant_tile(entry, tile_size);
    const Result<std::vector<std::byte>> block = pack->read_block(entry);
    if (!block) return block.error();
    Result<LoadedTile> tile = decode_block(entry, *block, tile_size);
    if (!tile) return Error{tile.error().code, pack->path().string() + ": " + tile.error().message};
    return tile;
  };
}

Result<LoadedTile> decode_tile(const IndexEntry& entry, std::span<const std::byte> block, int tile_size) {
  if ((entry.flags & kConstant) != 0) return constant_tile(entry, tile_size);
  if (checksum(block) != entry.checksum) {
    return bad_data(place_of(entry) + "block: checksum: expected the index's, found another");
  }
  return decode_block(entry, block, tile_size);
}

Status check_tile(const IndexEntry& entry, const LoadedTile& tile, int tile_size) {
  if (entry.layer == Layer::objects) return check_objects(entry, tile);
  return entry.layer == Layer::imagery ? check_texture(entry, tile.texture.get(), tile_size - 1)
                                       : check_heights(entry, tile.heights.get(), tile_size);
}

}  // namespace cairn
