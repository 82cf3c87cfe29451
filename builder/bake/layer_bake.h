#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "builder/bake/bake_session.h"
#include "builder/bake/pipeline.h"
#include "builder/bake/pyramid.h"
#include "builder/bake/tile_layer.h"
#include "builder/bake/tile_tree.h"
#include "cairn/progress.h"
#include "format/bytes.h"

namespace cairn {

/// A unit's subtree: what is stored beneath its root, siblings together, and the root on the way up.
template <TileLayer L>
struct UnitResult {
  std::vector<TileBlock> blocks;
  std::optional<TileBlock> root_block;  ///< none where the root is pruned
  std::optional<typename L::Node> root;
  std::uint64_t leaves = 0;
};

/// What is stored of a finished tile: nothing where it can be pruned.
template <TileLayer L>
std::optional<TileBlock> prune_or_encode(const L& layer, typename L::Node& node) {
  if (layer.can_prune(node)) {
    layer.prune(node);
    return std::nullopt;
  }
  layer.keep(node);
  return layer.encode(node);
}

/// One task of a bake: samples and measures the leaves of a unit, reduces them to their parents, and encodes
/// every tile that is not pruned.
template <TileLayer L>
Result<UnitResult<L>> bake_unit(const L& layer, const TileTree& tree, const TileId& unit) {
  UnitResult<L> result;
  Pyramid<L> pyramid(layer, tree);
  for (const TileId& id : tree.leaves(unit)) {
    auto sampled = layer.sample_leaf(id);
    if (!sampled) return sampled.error();
    ++result.leaves;
    std::optional<typename L::Node> node = layer.measure_leaf(std::move(*sampled));
    while (node) {
      auto block = prune_or_encode(layer, *node);
      if (node->id == unit) {
        result.root_block = std::move(block);
        result.root = std::move(node);
        break;
      }
      auto finished = pyramid.merge(*node, std::move(block));
      node.reset();
      if (!finished) break;
      std::move(finished->children.begin(), finished->children.end(), std::back_inserter(result.blocks));
      node = std::move(finished->parent);
    }
  }
  return result;
}

/// The serial end of the pipeline: writes the units' tiles, puts the tiles above them together, keeps the
/// journal. The stored children of a tile are written together, once the last of them is there, so that one
/// read takes them all.
template <TileLayer L>
class LayerSink {
 public:
  LayerSink(L& layer, const TileTree& tree, BakeSession& session)
      : layer_(layer), top_(tree.top()), session_(session), above_(layer, tree) {}

  Status take(UnitResult<L>&& unit) {
    UnitRecord record;
    for (const TileBlock& block : unit.blocks) {
      if (auto status = write(block, &record); !status) return status;
    }
    layer_.save_state(*unit.root, record.root);
    const TileId root_id = unit.root->id;
    record.held = unit.root_block;
    if (auto status = merge_upwards(std::move(*unit.root), std::move(unit.root_block), &record); !status)
      return status;
    const bool is_written = std::any_of(record.entries.begin(), record.entries.end(),
                                        [&](const IndexEntry& entry) { return entry.id == root_id; });
    if (is_written) record.held.reset();
    // Blocks are flushed before they are journalled, or a kill leaves records of bytes that were never
    // written.
    if (auto status = session_.writer.flush(); !status) return status;
    return session_.journal.append(record);
  }

  /// Merges a journalled unit again. What the unit wrote is in the pack already.
  Status replay(const RecordPlace& done) {
    auto record = session_.journal.read(done);
    if (!record) return record.error();
    ByteReader reader(record->root);
    auto root = layer_.load_state(reader);
    if (!root) return root.error();
    return merge_upwards(std::move(*root), std::move(record->held), nullptr);
  }

 private:
  Status write(const TileBlock& block, UnitRecord* record) {
    if (record == nullptr) return {};
    auto entry = session_.writer.add(block.entry, block.block);
    if (!entry) return entry.error();
    record->entries.push_back(*entry);
    return {};
  }

  // Without a record, what would be written is in the pack already.
  Status merge_upwards(typename L::Node&& unit_root, std::optional<TileBlock> stored, UnitRecord* record) {
    typename L::Node node = std::move(unit_root);
    while (node.id.level > top_) {
      auto finished = above_.merge(node, std::move(stored));
      if (!finished) return {};
      for (const TileBlock& child : finished->children) {
        if (auto status = write(child, record); !status) return status;
      }
      node = std::move(finished->parent);
      stored = prune_or_encode(layer_, node);
    }
    if (stored) {
      if (auto status = write(*stored, record); !status) return status;
    }
    layer_.finish_root(node);
    return {};
  }

  L& layer_;
  int top_;
  BakeSession& session_;
  Pyramid<L> above_;
};

/// Makes every tile of a layer and adds it to the pack. Units that were done before an interruption (the
/// first records of session.done, which are used up) are in the pack already. Uses all threads of the
/// caller's arena. `now` is the progress so far, with the total set: a leaf counts for `samples_per_leaf`
/// samples.
template <TileLayer L>
Status bake_layer(L& layer, const TileTree& tree, std::uint64_t samples_per_leaf, int threads,
                  BakeSession& session, Progress& now, const ProgressCallback& progress) {
  const std::vector<TileId> units = tree.units();
  LayerSink<L> sink(layer, tree, session);
  const std::size_t done = std::min(units.size(), session.done.size());
  for (std::size_t i = 0; i < done; ++i) {
    now.done += tree.leaves(units[i]).size() * samples_per_leaf;
    if (auto status = sink.replay(session.done[i]); !status) return status;
  }
  session.done.erase(session.done.begin(), session.done.begin() + static_cast<std::ptrdiff_t>(done));
  return run_in_order<UnitResult<L>>(
      done, units.size(), static_cast<std::size_t>(threads) + 1,
      [&](std::size_t i) { return bake_unit(layer, tree, units[i]); },
      [&](std::size_t, UnitResult<L>&& unit) -> Status {
        now.done += unit.leaves * samples_per_leaf;
        if (auto taken = sink.take(std::move(unit)); !taken) return taken;
        now.bytes_written = session.writer.position();
        return progress(now) ? Status() : cancelled(now);
      });
}

}  // namespace cairn
