#include "builder/imagery/texture_tile_encode.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <span>

#include "format/block_texture.h"
#include "cairn/texture_tile.h"

namespace cairn {
namespace {

using Rgba = UninitializedVector<std::uint8_t>;
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

std::int32_t psnr_of(const SquaredError& error) {
  if (error.sum == 0) return kNoTextureError;
  const double mse = static_cast<double>(error.sum) / static_cast<double>(error.count);
  return static_cast<std::int32_t>(std::lround(1000 * std::min(99.0, 10 * std::log10(255.0 * 255.0 / mse))));
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
  return psnr_of(error);
}

// A mip's outermost texels, which are put back where they were.
class Frame {
 public:
  explicit Frame(LinearImage& mip) : mip_(mip) {
    for_each_texel([&](LinearTexel& texel) { texels_.push_back(texel); });
  }
  ~Frame() {
    std::size_t i = 0;
    for_each_texel([&](LinearTexel& texel) { texel = texels_[i++]; });
  }
  Frame(const Frame&) = delete;
  Frame& operator=(const Frame&) = delete;

 private:
  template <class Use>
  void for_each_texel(const Use& use) {
    for (int r = 0; r < mip_.rows; ++r) {
      const bool whole = r == 0 || r == mip_.rows - 1;
      for (int c = 0; c < mip_.columns; c += whole ? 1 : std::max(1, mip_.columns - 1)) use(mip_.row(r)[c]);
    }
  }

  LinearImage& mip_;
  std::vector<LinearTexel> texels_;
};

// Gives `use` each mip of the tile in linear light, its edges agreed upon, the finest first. `half` is as
// before in the end.
template <class Use>
void for_each_mip(LinearImage& image, LinearImage& half, const EdgeTexels& rim, const Use& use) {
  int number = 0;
  const auto agreed = [&](LinearImage& mip) {
    rim.agree(number++, mip);
    use(mip);
  };
  agreed(image);
  LinearImage next = half.columns > 1 ? halved(half) : LinearImage();
  {
    const Frame frame(half);
    agreed(half);
  }
  while (next.is_set()) {
    LinearImage mip = std::move(next);
    next = mip.columns > 1 ? halved(mip) : LinearImage();
    agreed(mip);
  }
}

TileBlock block_of(const TileId& id, std::uint8_t flags, const TextureTile& tile, std::int32_t psnr) {
  TileBlock out;
  out.entry.layer = Layer::imagery;
  out.entry.id = id;
  out.entry.flags = flags;
  out.entry.max_quanta = psnr;
  out.block = encode_texture_block(tile);
  return out;
}

TileBlock constant_tile(const TileId& id, std::uint8_t flags, const std::uint8_t* colour) {
  TileBlock out;
  out.entry.layer = Layer::imagery;
  out.entry.id = id;
  out.entry.flags = static_cast<std::uint8_t>(flags | kConstant);
  std::memcpy(&out.entry.min_quanta, colour, 4);
  out.entry.max_quanta = kNoTextureError;
  return out;
}

// Leaves the first mip away.
TileBlock tile_of(const TileId& id, EncodedMips& mips) {
  TextureTile tile{TextureFormat::bc1, mips[0].size, {}};
  tile.texels.reserve(texture_chain_bytes(tile.format, tile.size));
  for (const EncodedMip& mip : mips)
    tile.texels.insert(tile.texels.end(), mip.blocks.begin(), mip.blocks.end());
  SquaredError error;
  for (const std::uint32_t squares : mips[0].errors) error.sum += squares;
  error.count = mips[0].errors.size() * 16 * 3;
  mips.erase(mips.begin());
  return block_of(id, 0, tile, psnr_of(error));
}

// Whether all blocks are like the first of `model`, which those of a tile of one colour are.
bool has_one_block(const EncodedMip& mip, const EncodedMip& model) {
  for (std::size_t i = 0; i < mip.blocks.size(); i += 8) {
    if (std::memcmp(&mip.blocks[i], model.blocks.data(), 8) != 0) return false;
  }
  return true;
}

bool may_be_one_colour(const EncodedMips& mips) {
  return std::all_of(mips.begin(), mips.end(), [&](const auto& mip) { return has_one_block(mip, mips[0]); });
}

// The same of a tile made of these children's mips.
bool may_be_one_colour(const std::array<EncodedMips, 4>& children) {
  return std::all_of(children.begin(), children.end(),
                     [&](const EncodedMips& child) { return has_one_block(child[0], children[0][0]); });
}

// None where a texel is not opaque.
EncodedMips opaque_mips(TileTexels& texels, TextureQuality quality) {
  EncodedMips mips;
  bool is_opaque = true;
  for_each_mip(texels.image, texels.half, texels.rim, [&](const LinearImage& mip) {
    auto encoded = is_opaque ? encode_opaque_mip(mip, quality) : std::nullopt;
    is_opaque = encoded.has_value();
    if (encoded) mips.push_back(std::move(*encoded));
  });
  return is_opaque ? mips : EncodedMips();
}

// The tile's mips from those of its children, where these are all there.
EncodedMips joined_mips(TileTexels& texels, const std::array<EncodedMips, 4>& children,
                        TextureQuality quality) {
  EncodedMips mips;
  for_each_mip(texels.image, texels.half, texels.rim, [&](const LinearImage& mip) {
    const std::size_t m = mips.size();
    std::array<const EncodedMip*, 4> quarters{};
    for (std::size_t q = 0; q < 4 && m < children[q].size(); ++q) quarters[q] = &children[q][m];
    mips.push_back(join_mips(quarters, mip, quality));
  });
  return mips;
}

}  // namespace

MipChain mip_chain(TileTexels&& texels) {
  MipChain chain;
  const int size = texels.image.columns;
  for_each_mip(texels.image, texels.half, texels.rim, [&](const LinearImage& mip) {
    SrgbImage srgb = to_srgb(mip);
    chain.is_opaque = chain.is_opaque && srgb.is_opaque;
    chain.mips.push_back(std::move(srgb.rgba));
  });
  if (chain.is_opaque) return chain;
  auto& mips = chain.mips;
  for (std::size_t m = mips.size() - 1; m-- > 0;) fill_from(mips[m + 1], size >> m, mips[m]);
  return chain;
}

TileBlock encode_texture_tile(const TileId& id, TileTexels&& texels, const ImageryOptions& options,
                              const std::array<EncodedMips, 4>& children, EncodedMips& encoded) {
  const bool have_all =
      std::none_of(children.begin(), children.end(), [](const auto& c) { return c.empty(); });
  if (have_all && !may_be_one_colour(children)) {
    encoded = joined_mips(texels, children, options.quality);
    return tile_of(id, encoded);
  }
  if (options.format == TextureFormat::bc1) {
    encoded = opaque_mips(texels, options.quality);
    if (!encoded.empty() && !may_be_one_colour(encoded)) return tile_of(id, encoded);
  }
  const int size = texels.image.columns;
  const MipChain chain = mip_chain(std::move(texels));
  std::uint8_t flags = 0;
  if (!chain.is_opaque) flags = kHasAlpha;
  if (is_one_colour(chain.mips)) {
    encoded.clear();
    return constant_tile(id, flags, chain.mips[0].data());
  }
  if (!encoded.empty()) return tile_of(id, encoded);
  const bool needs_alpha = !chain.is_opaque && options.format == TextureFormat::bc1;
  TextureTile tile{needs_alpha ? TextureFormat::bc3 : options.format, size, {}};
  tile.texels.reserve(texture_chain_bytes(tile.format, tile.size));
  for (std::size_t m = 0; m < chain.mips.size(); ++m)
    encode_texture(tile.format, options.quality, chain.mips[m], size >> m, size >> m, tile.texels);
  return block_of(id, flags, tile, psnr_of(chain.mips[0], tile, chain.is_opaque));
}

}  // namespace cairn
