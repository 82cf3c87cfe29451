#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cairn/pack_reader.h"
#include "cairn/status.h"

namespace cairn {

/// What two packs may have different besides their tiles, as JSON text: null where one lacks the key.
struct ValueDifference {
  std::string key;  ///< of the header its name, of the metadata its JSON pointer
  std::string a;
  std::string b;
};

/// How the heights of a tile differ, at the tile's own samples. Where a pack has no such tile, its heights
/// are those that PackSampler gives there from coarser tiles.
struct HeightDifference {
  std::uint64_t samples = 0;    ///< that differ in height
  std::uint64_t only_in_a = 0;  ///< samples with a height in A only: void, or covered by no tile, in B
  std::uint64_t only_in_b = 0;
  double max_m = 0;  ///< largest absolute difference
  double rms_m = 0;  ///< over all samples with a height in both
  LonLat worst;      ///< where max_m is, and the two heights there, in metres
  double a_m = 0;
  double b_m = 0;
};

/// How the finest texels of a tile differ. Only of tiles that both packs have.
struct TexelDifference {
  std::uint64_t texels = 0;  ///< that differ in any channel
  int max = 0;               ///< largest difference of a channel of R, G, B, A, of 255
};

enum class Presence : std::uint8_t { both, only_a, only_b };

/// A tile in which two packs differ.
struct TileDifference {
  Layer layer = Layer::heights;
  TileId id;
  Presence presence = Presence::both;
  std::optional<HeightDifference> heights;  ///< of the heights layer, where a sample differs
  std::optional<TexelDifference> texels;    ///< of the imagery layer, where a texel differs
  bool blocks_differ = false;               ///< of other layers, whose bytes are compared
  /// Geometric error and filled share, where they differ between two tiles that both packs have.
  std::vector<ValueDifference> values;
};

/// All tiles of a layer, counted.
struct LayerDifference {
  Layer layer = Layer::heights;
  std::uint64_t equal = 0;
  std::uint64_t differing = 0;
  std::uint64_t only_a = 0;
  std::uint64_t only_b = 0;
};

struct PackDifference {
  std::vector<ValueDifference> header;
  std::vector<ValueDifference> metadata;
  std::vector<LayerDifference> layers;  ///< those that a pack has
  std::vector<TileDifference> tiles;    ///< that differ, in the order of A's index; those only in B follow
  bool comparable = true;               ///< false where tile sizes differ: then no tile was compared

  bool is_empty() const { return header.empty() && metadata.empty() && tiles.empty() && comparable; }
};

/// Told how many tiles of how many are compared, from one thread.
using DiffProgress = std::function<void(std::uint64_t done, std::uint64_t total)>;

/// Compares the content of two packs, not how it is stored: an equal tile in another code is equal. The
/// result is independent of the number of threads. The error of a tile that cannot be read ends the
/// comparison.
Result<PackDifference> diff_packs(const PackReader& a, const PackReader& b, const DiffProgress& progress);

}  // namespace cairn
