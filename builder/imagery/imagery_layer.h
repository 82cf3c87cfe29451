#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "builder/bake/tile_layer.h"
#include "builder/imagery/edge_texels.h"
#include "builder/imagery/encoded_mips.h"
#include "builder/imagery/imagery_mosaic.h"
#include "builder/imagery/linear_image.h"
#include "cairn/imagery_options.h"
#include "format/bytes.h"

namespace cairn {

/// A texture tile on its way up the tree, its descendants done.
struct TextureNode {
  TileId id;
  LinearImage image;  ///< as the mosaic or the children have it; gone once the tile is pruned or encoded
  LinearImage half;   ///< its halved(), for mips and parent; no texels where nothing covers the tile
  EdgeTexels rim;
  EncodedMips mips;                      ///< once it is encoded, for its parent
  std::array<EdgeTexels, 4> child_rims;  ///< by quadrant, while the tile waits for its children
  std::array<EncodedMips, 4> child_mips;
  bool has_stored = false;  ///< this tile or a descendant is stored
};

/// A finest tile as the mosaic gives it, with EdgeTexels::kRim texels around it.
struct TextureLeaf {
  TileId id;
  LinearImage padded;
};

/// The imagery layer of a bake, a TileLayer. A tile is pruned where it is finer than all images that touch it
/// (the runtime draws its ancestor), and where it is empty and none of its descendants is stored.
class ImageryLayer {
 public:
  using Leaf = TextureLeaf;
  using Node = TextureNode;

  /// Tiles have `size` texels along a side. REQUIRES: mosaic and options outlive the layer.
  ImageryLayer(const ImageryMosaic& mosaic, const ImageryOptions& options, int size)
      : mosaic_(mosaic), options_(options), size_(size) {}

  Result<TextureLeaf> sample_leaf(const TileId& id) const;
  /// What the mips, the parent and the neighbours take of a leaf; encode() measures the error.
  TextureNode measure_leaf(TextureLeaf leaf) const;

  TextureNode begin_parent(const TileId& id) const;
  void merge_child(const TextureNode& child, TextureNode& parent) const;
  void finish_parent(TextureNode& parent) const;

  bool can_prune(const TextureNode& node) const;
  void prune(TextureNode& node) const;
  void keep(TextureNode& node) const;
  TileBlock encode(TextureNode& node) const;

  void save_state(const TextureNode& node, std::vector<std::byte>& out) const;
  Result<TextureNode> load_state(ByteReader& in) const;

  void finish_root(const TextureNode&) {}

 private:
  const ImageryMosaic& mosaic_;
  const ImageryOptions& options_;
  int size_;
};

}  // namespace cairn
