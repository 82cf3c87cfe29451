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

Result<TextureLeaf> ImageryLayer::sample_leaf(const TileId& id) const {
  auto padded = mosaic_.sample(texels_of(id, size_, EdgeTexels::kRim));
  if (!padded) return padded.error();
  return TextureLeaf{id, std::move(*padded)};
}

TextureNode ImageryLayer::measure_leaf(TextureLeaf leaf) const {
  TextureNode node;
  node.id = leaf.id;
  if (is_empty(leaf.padded)) return node;
  LinearImage half = halved(leaf.padded);
  node.rim = EdgeTexels::cut(leaf.padded, half);
  node.image = std::move(leaf.padded);
  node.image.drop_margin(EdgeTexels::kRim);
  node.half = std::move(half);
  node.half.drop_margin(EdgeTexels::kRim / 2);
  if (!is_empty(node.image)) return node;
  TextureNode empty;
  empty.id = leaf.id;
  return empty;
}

TextureNode ImageryLayer::begin_parent(const TileId& id) const {
  TextureNode parent;
  parent.id = id;
  return parent;
}

void ImageryLayer::merge_child(const TextureNode& child, TextureNode& parent) const {
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

void ImageryLayer::finish_parent(TextureNode& parent) const {
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

bool ImageryLayer::can_prune(const TextureNode& node) const {
  if (mosaic_.native_level(node.id).value_or(kMinLevel) < node.id.level) return true;
  return !node.has_stored && (!node.image.is_set() || is_empty(node.image));
}

void ImageryLayer::prune(TextureNode& node) const {
  node.image = {};
}

void ImageryLayer::keep(TextureNode& node) const {
  node.has_stored = true;
}

TileBlock ImageryLayer::encode(TextureNode& node) const {
  LinearImage image = std::exchange(node.image, {});
  // Where the covered share is too small for a texel, the tile still leads to its descendants.
  if (!image.is_set()) image = LinearImage(size_, size_);
  if (!node.half.is_set()) node.half = LinearImage(size_ / 2, size_ / 2);
  return encode_texture_tile(node.id, {std::move(image), node.half, node.rim}, options_,
                             std::exchange(node.child_mips, {}), node.mips);
}

// The mips are not journalled: the parent can encode them again.
void ImageryLayer::save_state(const TextureNode& tile, std::vector<std::byte>& out) const {
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

Result<TextureNode> ImageryLayer::load_state(ByteReader& in) const {
  TextureNode tile;
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
