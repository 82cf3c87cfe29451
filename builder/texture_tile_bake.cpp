#include "builder/texture_tile_bake.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>

#include "format/block_texture.h"
#include "format/texture_tile.h"

namespace cairn {
namespace {

using Rgba = std::vector<std::uint8_t>;

// Colours for transparent texels from the mip above, which has its own already.
void fill_from(const Rgba& above, int size, Rgba& image) {
  for (int r = 0; r < size; ++r) {
    for (int c = 0; c < size; ++c) {
      std::uint8_t* texel = &image[static_cast<std::size_t>(4 * (r * size + c))];
      if (texel[3] == 0)
        std::memcpy(texel, &above[static_cast<std::size_t>(4 * (r / 2 * (size / 2) + c / 2))], 3);
    }
  }
}

bool is_one_colour(const std::vector<Rgba>& mips) {
  return std::all_of(mips.begin(), mips.end(), [&](const Rgba& mip) {
    for (std::size_t i = 0; i < mip.size(); i += 4) {
      if (std::memcmp(&mip[i], mips[0].data(), 4) != 0) return false;
    }
    return true;
  });
}

bool is_opaque(const std::vector<Rgba>& mips) {
  return std::all_of(mips.begin(), mips.end(), [](const Rgba& mip) {
    std::uint8_t all = 255;
    for (std::size_t i = 3; i < mip.size(); i += 4) all &= mip[i];
    return all == 255;
  });
}

std::int32_t psnr_of(const Rgba& before, const Rgba& after, bool with_alpha) {
  const std::size_t channels = with_alpha ? 4 : 3;
  std::uint64_t sum = 0, count = 0;
  for (std::size_t i = 0; i < before.size(); i += 4) {
    if (before[i + 3] == 0) continue;
    for (std::size_t k = 0; k < channels; ++k) {
      const int error = before[i + k] - after[i + k];
      sum += static_cast<std::uint64_t>(error * error);
    }
    count += channels;
  }
  if (sum == 0) return kNoTextureError;
  const double mse = static_cast<double>(sum) / static_cast<double>(count);
  return static_cast<std::int32_t>(std::lround(1000 * std::min(99.0, 10 * std::log10(255.0 * 255.0 / mse))));
}

}  // namespace

std::vector<Rgba> mip_chain(const LinearImage& image, const TileRim& rim) {
  std::vector<Rgba> mips;
  LinearImage mip = image;
  for (int number = 0;; ++number) {
    LinearImage agreed = mip;
    rim.agree(number, agreed);
    mips.push_back(to_srgb(agreed));
    if (mip.columns == 1) break;
    mip = halved(mip);
  }
  for (std::size_t m = mips.size() - 1; m-- > 0;) fill_from(mips[m + 1], image.columns >> m, mips[m]);
  return mips;
}

TileBlock encode_texture_tile(const TileId& id, const LinearImage& image, const TileRim& rim,
                              const ImageryOptions& options) {
  const std::vector<Rgba> mips = mip_chain(image, rim);
  TileBlock out;
  out.entry.layer = Layer::imagery;
  out.entry.id = id;
  const bool opaque = is_opaque(mips);
  if (!opaque) out.entry.flags = kHasAlpha;
  if (is_one_colour(mips)) {
    out.entry.flags |= kConstant;
    std::memcpy(&out.entry.min_quanta, mips[0].data(), 4);
    out.entry.max_quanta = kNoTextureError;
    return out;
  }
  const bool needs_alpha = !opaque && options.format == TextureFormat::bc1;
  TextureTile tile{needs_alpha ? TextureFormat::bc3 : options.format, image.columns, {}};
  tile.texels.reserve(texture_chain_bytes(tile.format, tile.size));
  for (std::size_t m = 0; m < mips.size(); ++m)
    encode_texture(tile.format, options.quality, mips[m], tile.size >> m, tile.size >> m, tile.texels);

  Rgba decoded(mips[0].size());
  const auto first = std::span(tile.texels).first(texture_image_bytes(tile.format, tile.size));
  const Status status = decode_texture(tile.format, first, tile.size, tile.size, decoded);
  assert(status.ok());
  out.entry.max_quanta = status.ok() ? psnr_of(mips[0], decoded, !opaque) : 0;
  out.block = encode_texture_block(tile);
  return out;
}

}  // namespace cairn
