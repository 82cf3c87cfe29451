#pragma once

#include "builder/imagery_options.h"
#include "builder/linear_image.h"
#include "builder/pyramid.h"
#include "builder/tile_rim.h"
#include "format/tile_id.h"

namespace cairn {

/// The PSNR that stands for no error at all, in 1/1000 dB.
inline constexpr std::int32_t kNoTextureError = 99'000;

/// The mips of a tile as they are encoded: in sRGB, not premultiplied, RGBA, 512×512 (256×256) first, down to
/// 1×1. Their edges agree with the neighbours'. Texels without coverage have the colour of the next mip, so
/// that filtering between them and others bleeds nothing strange. `half` is the image's halved().
std::vector<UnsetVector<std::uint8_t>> mip_chain(LinearImage&& image, const LinearImage& half,
                                                 const TileRim& rim);

/// Encodes the tile and measures it: peak signal-to-noise ratio of the decoded finest mip's R, G, B (and
/// alpha where the tile has any) against the texels before compression, transparent ones not counted.
TileBlock encode_texture_tile(const TileId& id, LinearImage&& image, const LinearImage& half,
                              const TileRim& rim, const ImageryOptions& options);

}  // namespace cairn
