#include "builder/imagery/imagery_layer.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "builder/imagery/texture_tile_encode.h"

namespace cairn {

namespace {

// Row r of a quarter of the image; bit 0 of the quadrant is east, bit 1 north.
LinearTexel* quadrant_row(LinearImage& image, int quadrant, int r) {
  return image.row((quadrant & 2 ? 0 : image.rows / 2) + r) + (quadrant & 1) * (image.columns / 2);
}

}  // namespace

Result<BakedTexture> ImageryLayer::bake_leaf(const TileId& id) const {
  auto padded = mosaic_.sample(texels_of(id, size_, EdgeTexels::kRim));
  if (!padded) return padded.error();
  BakedTexture baked;
  baked.id = id;
  if (is_empty(*padded)) return baked;
  LinearImage half = halved(*padded);
  baked.rim = EdgeTexels::cut(*padded, half);
  baked.image = std::move(*padded);
  baked.image.drop_margin(EdgeTexels::kRim);
  baked.half = std::move(half);
  baked.half.drop_margin(EdgeTexels::kRim / 2);
  if (!is_empty(baked.image)) return baked;
  BakedTexture empty;
  empty.id = id;
  return empty;
}

BakedTexture ImageryLayer::open_parent(const TileId& id) const {
  BakedTexture parent;
  parent.id = id;
  return parent;
}

void ImageryLayer::take(const BakedTexture& child, BakedTexture& parent) const {
  parent.has_stored = parent.has_stored || child.has_stored;
  const LinearImage& half = child.half;
  if (!half.is_set()) return;
  if (!parent.image.is_set()) parent.image = LinearImage::unset(size_, size_);
  const int q = quadrant_of(child.id);
  for (int r = 0; r < half.rows; ++r)
    std::copy_n(half.row(r), half.columns, quadrant_row(parent.image, q, r));
  parent.child_rims[static_cast<std::size_t>(q)] = child.rim;
  parent.child_mips[static_cast<std::size_t>(q)] = child.mips;
}

void ImageryLayer::close_parent(BakedTexture& parent) const {
  if (!parent.image.is_set()) return;
  for (int q = 0; q < 4; ++q) {
    if (!parent.child_rims[static_cast<std::size_t>(q)].is_empty()) continue;
    for (int r = 0; r < size_ / 2; ++r)
      std::fill_n(quadrant_row(parent.image, q, r), size_ / 2, LinearTexel{});
  }
  parent.half = halved(parent.image);
  std::array<const EdgeTexels*, 4> rims{};
  for (std::size_t q = 0; q < 4; ++q) rims[q] = &parent.child_rims[q];
  parent.rim = EdgeTexels::join(rims, size_);
  parent.child_rims = {};
}

// A tile finer than all images that touch it serves its ancestors only: the runtime draws those.
Result<std::optional<TileBlock>> ImageryLayer::settle(BakedTexture& tile) const {
  const bool too_fine = mosaic_.native_level(tile.id).value_or(kMinLevel) < tile.id.level;
  LinearImage image = std::exchange(tile.image, {});
  const bool is_bare = !image.is_set() || is_empty(image);
  if (too_fine || (is_bare && !tile.has_stored)) return std::optional<TileBlock>{};
  tile.has_stored = true;
  // Where the covered share is too small for a texel, the tile still leads to its descendants.
  if (!image.is_set()) image = LinearImage(size_, size_);
  if (!tile.half.is_set()) tile.half = LinearImage(size_ / 2, size_ / 2);
  return std::optional<TileBlock>(encode_texture_tile(tile.id, {std::move(image), tile.half, tile.rim},
                                                      options_, std::exchange(tile.child_mips, {}),
                                                      tile.mips));
}

// Its mips are left out: they save its parent work, no more.
void ImageryLayer::append(const BakedTexture& tile, std::vector<std::byte>& out) const {
  const LinearImage& half = tile.half;
  const auto row_texels = static_cast<std::size_t>(half.columns);
  out.reserve(out.size() + 2 * row_texels * static_cast<std::size_t>(half.rows) * sizeof(LinearTexel));
  ByteWriter writer(out);
  writer.write(std::int32_t{tile.id.level});
  writer.write(tile.id.x);
  writer.write(tile.id.y);
  writer.write(static_cast<std::uint8_t>(tile.has_stored));
  writer.write(static_cast<std::uint8_t>(half.is_set()));
  writer.write(static_cast<std::uint8_t>(!tile.rim.is_empty()));
  for (int r = 0; r < half.rows; ++r) writer.append(std::as_bytes(std::span(half.row(r), row_texels)));
  tile.rim.append_to(out);
}

Result<BakedTexture> ImageryLayer::read(ByteReader& in) const {
  BakedTexture tile;
  tile.id.level = in.read<std::int32_t>();
  tile.id.x = in.read<std::int32_t>();
  tile.id.y = in.read<std::int32_t>();
  tile.has_stored = in.read<std::uint8_t>() != 0;
  const bool has_half = in.read<std::uint8_t>() != 0, has_rim = in.read<std::uint8_t>() != 0;
  if (has_half) {
    tile.half = LinearImage(size_ / 2, size_ / 2);
    for (int r = 0; r < tile.half.rows && in.ok(); ++r) {
      const auto bytes = in.take(static_cast<std::size_t>(tile.half.columns) * sizeof(LinearTexel));
      if (in.ok()) std::memcpy(tile.half.row(r), bytes.data(), bytes.size());
    }
  }
  if (has_rim) tile.rim = EdgeTexels::read_from(in, size_);
  if (!in.ok() || !is_valid(tile.id)) return bad_data("journal: a finished subtree: expected more bytes");
  return tile;
}

}  // namespace cairn
