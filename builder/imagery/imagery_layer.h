#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "builder/bake/pyramid.h"
#include "builder/imagery/edge_texels.h"
#include "builder/imagery/encoded_mips.h"
#include "builder/imagery/imagery_mosaic.h"
#include "builder/imagery/linear_image.h"
#include "format/bytes.h"

namespace cairn {

/// A texture tile on its way up the tree, its descendants done.
struct BakedTexture {
  TileId id;
  LinearImage image;  ///< as the mosaic or the children have it; gone once the tile is settled
  LinearImage half;   ///< its halved(), for mips and parent; no texels where nothing covers the tile
  EdgeTexels rim;
  EncodedMips mips;                      ///< once it is settled, for its parent
  std::array<EdgeTexels, 4> child_rims;  ///< by quadrant, while the tile waits for its children
  std::array<EncodedMips, 4> child_mips;
  bool has_stored = false;  ///< a descendant is stored
};

/// The imagery layer of a bake, see Pyramid and bake_layer().
class ImageryLayer {
 public:
  using Tile = BakedTexture;

  /// Tiles have `size` texels a side. REQUIRES: mosaic and options outlive the layer.
  ImageryLayer(const ImageryMosaic& mosaic, const ImageryOptions& options, int size)
      : mosaic_(mosaic), options_(options), size_(size) {}

  static constexpr const char* stage() { return "imagery"; }
  std::uint64_t samples_a_tile() const {
    return static_cast<std::uint64_t>(size_) * static_cast<std::uint64_t>(size_);
  }

  Result<BakedTexture> bake_leaf(const TileId& id) const;
  BakedTexture open_parent(const TileId& id) const;
  void take(const BakedTexture& child, BakedTexture& parent) const;
  void close_parent(BakedTexture& parent) const;
  Result<std::optional<TileBlock>> settle(BakedTexture& tile) const;

  void append(const BakedTexture& tile, std::vector<std::byte>& out) const;
  Result<BakedTexture> read(ByteReader& in) const;
  void summarise(const BakedTexture&) {}

 private:
  const ImageryMosaic& mosaic_;
  const ImageryOptions& options_;
  int size_;
};

}  // namespace cairn
