#include "builder/imagery/encoded_mips.h"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <span>
#include <utility>

namespace cairn {
namespace {

constexpr std::size_t kBlockBytes = block_bytes(TextureFormat::bc1);

std::size_t blocks_along(int size) {
  return (static_cast<std::size_t>(size) + 3) / 4;
}

// Copies each child's blocks to its quarter.
void take_over(const std::array<const EncodedMip*, 4>& children, EncodedMip& mip) {
  const std::size_t along = blocks_along(mip.size), half = along / 2;
  for (std::size_t q = 0; q < 4; ++q) {
    const EncodedMip& child = *children[q];
    assert(2 * child.size == mip.size);
    for (std::size_t r = 0; r < half; ++r) {
      const std::size_t to = ((q & 2 ? 0 : half) + r) * along + (q & 1) * half;
      std::memcpy(&mip.blocks[to * kBlockBytes], &child.blocks[r * half * kBlockBytes], half * kBlockBytes);
      std::copy_n(child.errors.begin() + static_cast<std::ptrdiff_t>(r * half), half,
                  mip.errors.begin() + static_cast<std::ptrdiff_t>(to));
    }
  }
}

// The numbers of the blocks on both sides of the middle lines.
std::vector<std::size_t> blocks_beside_middle(std::size_t along) {
  std::vector<std::size_t> found;
  const auto is_beside = [&](std::size_t i) { return i == along / 2 - 1 || i == along / 2; };
  for (std::size_t i = 0; i < along * along; ++i)
    if (is_beside(i / along) || is_beside(i % along)) found.push_back(i);
  return found;
}

// Those blocks' texels side by side.
LinearImage strip_of(const std::vector<std::size_t>& blocks, const LinearImage& mip) {
  const std::size_t along = blocks_along(mip.columns);
  LinearImage strip = LinearImage::unset(static_cast<int>(4 * blocks.size()), 4);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const int top = static_cast<int>(4 * (blocks[i] / along));
    for (int r = 0; r < 4; ++r)
      std::copy_n(mip.row(top + r) + 4 * (blocks[i] % along), 4, strip.row(r) + 4 * i);
  }
  return strip;
}

}  // namespace

// A row of blocks at a time, which stays in the processor's nearest cache from texels to errors.
std::optional<EncodedMip> encode_opaque_mip(const LinearImage& mip, TextureQuality quality) {
  const int size = mip.columns, rows = std::min(32, size);
  const auto columns = static_cast<std::size_t>(size);
  const std::size_t along = blocks_along(size);
  EncodedMip encoded{size, {}, {}};
  encoded.blocks.reserve(along * along * kBlockBytes);
  encoded.errors.reserve(along * along);
  UninitializedVector<std::uint8_t> rgba(4 * columns * static_cast<std::size_t>(rows));
  for (int top = 0; top < size; top += rows) {
    for (int r = 0; r < rows; ++r) {
      if (!to_srgb({mip.row(top + r), columns}, &rgba[4 * columns * static_cast<std::size_t>(r)]))
        return std::nullopt;
    }
    encode_texture(TextureFormat::bc1, quality, rgba, size, rows, encoded.blocks);
    bc1_errors(rgba, size, rows, std::span(encoded.blocks).last(along * blocks_along(rows) * kBlockBytes),
               encoded.errors);
  }
  return encoded;
}

EncodedMip join_mips(const std::array<const EncodedMip*, 4>& children, const LinearImage& mip,
                     TextureQuality quality) {
  const std::size_t along = blocks_along(mip.columns);
  // Blocks of children this small lie on both sides of a middle line.
  if (mip.columns < 16) return *encode_opaque_mip(mip, quality);
  EncodedMip joined{mip.columns, {}, {}};
  joined.blocks.resize(along * along * kBlockBytes);
  joined.errors.resize(along * along);
  take_over(children, joined);

  const std::vector<std::size_t> own = blocks_beside_middle(along);
  const UninitializedVector<std::uint8_t> rgba = to_srgb(strip_of(own, mip)).rgba;
  std::vector<std::byte> blocks;
  std::vector<std::uint32_t> errors;
  const int width = static_cast<int>(4 * own.size());
  encode_texture(TextureFormat::bc1, quality, rgba, width, 4, blocks);
  bc1_errors(rgba, width, 4, blocks, errors);
  for (std::size_t i = 0; i < own.size(); ++i) {
    std::memcpy(&joined.blocks[own[i] * kBlockBytes], &blocks[i * kBlockBytes], kBlockBytes);
    joined.errors[own[i]] = errors[i];
  }
  return joined;
}

}  // namespace cairn
