#pragma once

#include <string>

#include "builder/serve/http_message.h"
#include "builder/serve/served_pack.h"

namespace cairn {

/// Answers requests for Terrarium tiles of a pack: `rest` is "tiles.json", a TileJSON, or "ZOOM/X/Y.png".
/// Tiles are those that an export as PMTiles writes, in Terrarium's steps of 1/256 m. 404 where the pack has
/// no heights.
HttpAnswer answer_terrarium(const HttpRequest& request, const std::string& pack_name, const OpenedPack& pack,
                            const std::string& rest);

/// Answers requests for quantized-mesh tiles: `rest` is "layer.json" or "LEVEL/X/Y.terrain". Tiles are those
/// of an export as quantized-mesh, each measured when it is made.
HttpAnswer answer_quantized_mesh(const HttpRequest& request, const std::string& pack_name,
                                 const OpenedPack& pack, const std::string& rest);

}  // namespace cairn
