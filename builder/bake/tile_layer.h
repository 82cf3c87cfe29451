#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "cairn/pack_layout.h"
#include "cairn/status.h"
#include "format/bytes.h"

namespace cairn {

/// A tile to be stored; no block where it is constant.
struct TileBlock {
  IndexEntry entry;
  std::vector<std::byte> block;
};

/// What bake_layer() asks of a kind of tile. A Node is a tile on its way up the tree: what its parent takes
/// over from it, and what its own block is made of. All const members are safe to call from several threads.
template <class L>
concept TileLayer = requires(const L layer, L& whole, typename L::Leaf leaf, typename L::Node& node,
                             const typename L::Node& done, const TileId& id, std::vector<std::byte>& out,
                             ByteReader& in) {
  // A leaf from the sources: samples, then what is known of them.
  { layer.sample_leaf(id) } -> std::same_as<Result<typename L::Leaf>>;
  { layer.measure_leaf(std::move(leaf)) } -> std::same_as<typename L::Node>;

  // A parent from its children, each merged once it is pruned or encoded.
  { layer.begin_parent(id) } -> std::same_as<typename L::Node>;
  { layer.merge_child(done, node) } -> std::same_as<void>;
  { layer.finish_parent(node) } -> std::same_as<void>;

  // Whether a finished tile need not be stored; then one of prune() and keep() notes the choice in the node.
  { layer.can_prune(done) } -> std::same_as<bool>;
  { layer.prune(node) } -> std::same_as<void>;
  { layer.keep(node) } -> std::same_as<void>;
  { layer.encode(node) } -> std::same_as<TileBlock>;

  // A finished node in the journal, and again after an interruption.
  { layer.save_state(done, out) } -> std::same_as<void>;
  { layer.load_state(in) } -> std::same_as<Result<typename L::Node>>;

  // Takes over what a root of the whole tree knows.
  { whole.finish_root(done) } -> std::same_as<void>;

  { done.id } -> std::convertible_to<TileId>;
};

}  // namespace cairn
