#pragma once

#include <filesystem>

#include "cairn/pack_reader.h"
#include "cairn/status.h"
#include "cairn/texture_tile.h"

namespace cairn {

/// Reads a tile of the imagery layer; a constant one comes as a texture of that colour.
Result<TextureTile> read_texture_tile(const PackReader& pack, const IndexEntry& entry);

/// Writes the texture with its mips as a DirectDraw Surface: DXT1 or DXT5, BC7 with the header of
/// Direct3D 10.
Status write_texture_dds(const std::filesystem::path& target, const TextureTile& tile);

/// Writes the finest mip, decoded, as an RGBA PNG.
Status write_texture_png(const std::filesystem::path& target, const TextureTile& tile);

}  // namespace cairn
