#include "builder/texture_tile_bake.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <span>

#include "format/block_texture.h"
#include "format/texture_tile.h"

namespace cairn {
namespace {

using Rgba = UnsetVector<std::uint8_t>;
using Texels = std::span<const std::uint8_t>;  // RGBA

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
    std::uint32_t all = ~0u;
    for (std::size_t i = 0; i < mip.size(); i += 4) {
      std::uint32_t texel = 0;
      std::memcpy(&texel, &mip[i], sizeof texel);
      all &= texel;
    }
    return all >> 24 == 255;
  });
}

struct SquaredError {
  std::uint64_t sum = 0;
  std::uint64_t count = 0;
};

// Opaque texels' alphas are equal and add nothing.
void add_opaque_error(Texels before, Texels after, SquaredError& error) {
  constexpr std::size_t kRun = 2048;  // squares that fit a sum of 32 bits
  for (std::size_t at = 0; at < before.size(); at += kRun) {
    std::uint32_t sum = 0;
    for (std::size_t i = at; i < std::min(at + kRun, before.size()); ++i) {
      const int difference = before[i] - after[i];
      sum += static_cast<std::uint32_t>(difference * difference);
    }
    error.sum += sum;
  }
  error.count += before.size() / 4 * 3;
}

void add_visible_error(Texels before, Texels after, SquaredError& error) {
  for (std::size_t i = 0; i < before.size(); i += 4) {
    if (before[i + 3] == 0) continue;
    for (std::size_t k = 0; k < 4; ++k) {
      const int difference = before[i + k] - after[i + k];
      error.sum += static_cast<std::uint64_t>(difference * difference);
    }
    error.count += 4;
  }
}

// Of the finest mip, decoded a few rows of blocks at a time, which stay in the processor's cache.
std::int32_t psnr_of(const Rgba& image, const TextureTile& tile, bool opaque) {
  const int rows = std::min(tile.size, 32);
  const std::size_t bytes =
      texture_image_bytes(tile.format, tile.size) / static_cast<std::size_t>(tile.size / rows);
  Rgba decoded(static_cast<std::size_t>(4 * tile.size * rows));
  SquaredError error;
  for (int band = 0; band < tile.size / rows; ++band) {
    const auto i = static_cast<std::size_t>(band);
    const Status status = decode_texture(tile.format, std::span(tile.texels).subspan(i * bytes, bytes),
                                         tile.size, rows, decoded);
    assert(status.ok());
    const Texels before = Texels(image).subspan(i * decoded.size(), decoded.size());
    opaque ? add_opaque_error(before, decoded, error) : add_visible_error(before, decoded, error);
  }
  if (error.sum == 0) return kNoTextureError;
  const double mse = static_cast<double>(error.sum) / static_cast<double>(error.count);
  return static_cast<std::int32_t>(std::lround(1000 * std::min(99.0, 10 * std::log10(255.0 * 255.0 / mse))));
}

}  // namespace

std::vector<Rgba> mip_chain(LinearImage&& image, const LinearImage& half, const TileRim& rim) {
  const int size = image.columns;
  std::vector<Rgba> mips;
  const auto add = [&](LinearImage& mip) {
    rim.agree(static_cast<int>(mips.size()), mip);
    mips.push_back(to_srgb(mip));
  };
  add(image);
  for (LinearImage mip = half;;) {
    LinearImage next = mip.columns > 1 ? halved(mip) : LinearImage();
    add(mip);
    if (next.texels.empty()) break;
    mip = std::move(next);
  }
  if (is_opaque(mips)) return mips;
  for (std::size_t m = mips.size() - 1; m-- > 0;) fill_from(mips[m + 1], size >> m, mips[m]);
  return mips;
}

TileBlock encode_texture_tile(const TileId& id, LinearImage&& image, const LinearImage& half,
                              const TileRim& rim, const ImageryOptions& options) {
  const int size = image.columns;
  const std::vector<Rgba> mips = mip_chain(std::move(image), half, rim);
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
  TextureTile tile{needs_alpha ? TextureFormat::bc3 : options.format, size, {}};
  tile.texels.reserve(texture_chain_bytes(tile.format, tile.size));
  for (std::size_t m = 0; m < mips.size(); ++m)
    encode_texture(tile.format, options.quality, mips[m], tile.size >> m, tile.size >> m, tile.texels);

  out.entry.max_quanta = psnr_of(mips[0], tile, opaque);
  out.block = encode_texture_block(tile);
  return out;
}

}  // namespace cairn
