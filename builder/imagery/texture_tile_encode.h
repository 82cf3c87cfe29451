#pragma once

#include <array>
#include <vector>

#include "builder/bake/pyramid.h"
#include "builder/imagery/edge_texels.h"
#include "builder/imagery/encoded_mips.h"
#include "builder/imagery/linear_image.h"
#include "cairn/imagery_options.h"
#include "cairn/tile_id.h"

namespace cairn {

/// The PSNR that stands for no error at all, in 1/1000 dB.
inline constexpr std::int32_t kNoTextureError = 99'000;

/// What a texture tile shows.
struct TileTexels {
  LinearImage image;
  LinearImage& half;  ///< halved(image); the same afterwards
  const EdgeTexels& rim;
};

/// The mips of a tile as they are encoded: in sRGB, not premultiplied, RGBA, 512×512 (256×256) first, down to
/// 1×1. Their edges agree with the neighbours'. Texels without coverage have the colour of the next mip, so
/// that filtering between them and others bleeds nothing strange.
struct MipChain {
  std::vector<UninitializedVector<std::uint8_t>> mips;
  bool is_opaque = true;
};
MipChain mip_chain(TileTexels&& texels);

/// Encodes the tile and measures it: peak signal-to-noise ratio of the decoded finest mip's R, G, B (and
/// alpha where the tile has any) against the texels before compression, transparent ones not counted.
///
/// `encoded` becomes the tile's mips from the second on, for its parent, whose quarter they are: none where
/// the tile is not opaque, of one colour or not BC1. `children` are what the four children's became, by
/// quadrant. Where all have theirs, most of the tile's blocks are taken over; the bytes are the same as
/// without.
TileBlock encode_texture_tile(const TileId& id, TileTexels&& texels, const ImageryOptions& options,
                              const std::array<EncodedMips, 4>& children, EncodedMips& encoded);

}  // namespace cairn
