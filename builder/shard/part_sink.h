#pragma once

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "builder/bake/layer_bake.h"
#include "builder/shard/part_file.h"

namespace cairn {

/// The serial end of a shard's pipeline, where LayerSink is that of a whole bake's: puts the tiles of the
/// shard's subtrees together and notes what a merge has to write for each unit.
template <TileLayer L>
class PartSink {
 public:
  /// `subtrees`: those of the shard. REQUIRES: all else outlives the sink.
  PartSink(const L& layer, Layer kind, const TileTree& tree, const std::vector<TileId>& subtrees,
           PartWriter& part)
      : layer_(layer),
        kind_(kind),
        part_(part),
        above_(layer, tree, [roots = std::set<TileId>(subtrees.begin(), subtrees.end())](const TileId& id) {
          return roots.contains(id);
        }) {}

  Status take(UnitResult<L>&& unit) {
    PartRecord record;
    record.layer = kind_;
    record.unit = unit.root->id;
    record.blocks = std::move(unit.blocks);
    layer_.save_state(*unit.root, record.root);
    record.held = unit.root_block;
    const auto keep = [&record](const TileBlock& block) {
      record.blocks.push_back(block);
      return Status();
    };
    auto root = above_.merge(std::move(*unit.root), std::move(unit.root_block), keep);
    if (!root) return root.error();
    if (*root) {
      record.ends_subtree = true;
      if ((*root)->node.id != record.unit) {
        layer_.save_state((*root)->node, record.subtree_root);
        record.subtree_held = std::move((*root)->stored);
      }
    }
    const bool is_written =
        std::any_of(record.blocks.begin(), record.blocks.end(),
                    [&](const TileBlock& block) { return block.entry.id == record.unit; });
    if (is_written) record.held.reset();
    return part_.append(record);
  }

  /// Puts a unit that an interrupted part holds together with the others again.
  Status replay(const PartRecord& done) {
    ByteReader reader(done.root);
    auto node = layer_.load_state(reader);
    if (!node) return node.error();
    std::optional<TileBlock> stored = done.held;
    for (const TileBlock& block : done.blocks)
      if (block.entry.id == done.unit) stored = block;
    const auto root =
        above_.merge(std::move(*node), std::move(stored), [](const TileBlock&) { return Status(); });
    return root ? Status() : Status(root.error());
  }

 private:
  const L& layer_;
  Layer kind_;
  PartWriter& part_;
  Ascent<L> above_;
};

/// A subtree's root as a part holds it, once the record ends one.
template <TileLayer L>
Result<std::optional<typename Ascent<L>::Root>> subtree_of(const L& layer, PartRecord& record) {
  using Root = typename Ascent<L>::Root;
  if (!record.ends_subtree) return std::optional<Root>();
  const bool is_unit = record.subtree_root.empty();
  ByteReader reader(is_unit ? record.root : record.subtree_root);
  auto node = layer.load_state(reader);
  if (!node) return node.error();
  return std::optional<Root>(Root{std::move(*node), is_unit ? record.held : std::move(record.subtree_held)});
}

}  // namespace cairn
