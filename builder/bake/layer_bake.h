#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <iterator>
#include <optional>
#include <span>
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

/// The parts of the tree above the units: takes finished subtrees in the order of the walk, and puts the
/// tiles above them together up to the roots, where it ends. Not thread-safe.
template <TileLayer L>
class Ascent {
 public:
  using Node = typename L::Node;
  /// Takes a tile that is stored now. The stored children of a tile are passed on together, once the last of
  /// them is there, so that one read takes them all.
  using Write = std::function<Status(const TileBlock&)>;

  /// `is_root` says where to end. REQUIRES: layer and tree outlive it.
  Ascent(const L& layer, const TileTree& tree, std::function<bool(const TileId&)> is_root)
      : layer_(layer), is_root_(std::move(is_root)), above_(layer, tree) {}

  /// A root and what is stored of it, if anything: not yet passed on.
  struct Root {
    Node node;
    std::optional<TileBlock> stored;
  };

  /// Returns the root where the subtree was the last one below it.
  Result<std::optional<Root>> merge(Node subtree, std::optional<TileBlock> stored, const Write& write) {
    Node node = std::move(subtree);
    while (!is_root_(node.id)) {
      auto finished = above_.merge(node, std::move(stored));
      if (!finished) return std::optional<Root>();
      for (const TileBlock& child : finished->children) {
        if (auto status = write(child); !status) return status.error();
      }
      node = std::move(finished->parent);
      stored = prune_or_encode(layer_, node);
    }
    return std::optional<Root>(Root{std::move(node), std::move(stored)});
  }

 private:
  const L& layer_;
  std::function<bool(const TileId&)> is_root_;
  Pyramid<L> above_;
};

/// The serial end of the pipeline: writes the units' tiles, puts the tiles above them together, keeps the
/// journal.
template <TileLayer L>
class LayerSink {
 public:
  using Node = typename L::Node;

  LayerSink(L& layer, const TileTree& tree, BakeSession& session)
      : layer_(layer),
        session_(session),
        above_(layer, tree, [top = tree.top()](const TileId& id) { return id.level <= top; }) {}

  Status take(UnitResult<L>&& unit) {
    UnitRecord record;
    for (const TileBlock& block : unit.blocks) {
      if (auto status = write(block, record); !status) return status;
    }
    layer_.save_state(*unit.root, record.root);
    record.held = unit.root_block;
    const TileId id = unit.root->id;
    if (auto status = rise(std::move(*unit.root), std::move(unit.root_block), record); !status) return status;
    return note(id, std::move(record));
  }

  /// Writes tiles that were baked elsewhere, in the order in which take() would. `unit` is the record of a
  /// unit without entries; `risen` the finished subtree that ends with this unit, if one does.
  Status take_over(const TileId& id, std::span<const TileBlock> blocks, UnitRecord unit,
                   std::optional<typename Ascent<L>::Root> risen) {
    for (const TileBlock& block : blocks) {
      if (auto status = write(block, unit); !status) return status;
    }
    if (risen) {
      if (auto status = rise(std::move(risen->node), std::move(risen->stored), unit); !status) return status;
    }
    return note(id, std::move(unit));
  }

  /// Merges a journalled unit again. What the unit wrote is in the pack already.
  Status replay(const RecordPlace& done) {
    auto record = session_.journal.read(done);
    if (!record) return record.error();
    ByteReader reader(record->root);
    auto node = layer_.load_state(reader);
    if (!node) return node.error();
    auto root =
        above_.merge(std::move(*node), std::move(record->held), [](const TileBlock&) { return Status(); });
    if (!root) return root.error();
    if (*root) layer_.finish_root((*root)->node);
    return {};
  }

 private:
  Status write(const TileBlock& block, UnitRecord& record) {
    auto entry = session_.writer.add(block.entry, block.block);
    if (!entry) return entry.error();
    record.entries.push_back(*entry);
    return {};
  }

  Status rise(Node subtree, std::optional<TileBlock> stored, UnitRecord& record) {
    const auto write_to_pack = [&](const TileBlock& block) { return write(block, record); };
    auto root = above_.merge(std::move(subtree), std::move(stored), write_to_pack);
    if (!root) return root.error();
    if (!*root) return {};
    if ((*root)->stored) {
      if (auto status = write(*(*root)->stored, record); !status) return status;
    }
    layer_.finish_root((*root)->node);
    return {};
  }

  // Blocks are flushed before they are journalled, or a kill leaves records of bytes that were never written.
  Status note(const TileId& unit, UnitRecord&& record) {
    const bool is_written = std::any_of(record.entries.begin(), record.entries.end(),
                                        [&](const IndexEntry& entry) { return entry.id == unit; });
    if (is_written) record.held.reset();
    if (auto status = session_.writer.flush(); !status) return status;
    return session_.journal.append(record);
  }

  L& layer_;
  BakeSession& session_;
  Ascent<L> above_;
};

/// Makes units number `first` and later of a layer, on all threads of the caller's arena, and hands them to
/// `sink` in their order. `bake(unit)` makes one. `written()` is how much has been written.
template <TileLayer L, class Bake, class Sink, class Written>
Status bake_units(const std::vector<TileId>& units, std::size_t first, std::uint64_t samples_per_leaf,
                  int threads, const Bake& bake, Sink& sink, const Written& written, Progress& now,
                  const ProgressCallback& progress) {
  return run_in_order<UnitResult<L>>(
      first, units.size(), static_cast<std::size_t>(threads) + 1,
      [&](std::size_t i) -> Result<UnitResult<L>> { return bake(units[i]); },
      [&](std::size_t, UnitResult<L>&& unit) -> Status {
        now.done += unit.leaves * samples_per_leaf;
        if (auto taken = sink.take(std::move(unit)); !taken) return taken;
        now.bytes_written = written();
        return progress(now) ? Status() : cancelled(now);
      });
}

/// Makes every tile of a layer and adds it to the pack, each unit by `bake`. Units that were done before an
/// interruption (the first records of session.done, which are used up) are in the pack already. Uses all
/// threads of the caller's arena. `now` is the progress so far, with the total set: a leaf counts for
/// `samples_per_leaf` samples.
template <TileLayer L, class Bake>
Status bake_layer_by(const Bake& bake, L& layer, const TileTree& tree, std::uint64_t samples_per_leaf,
                     int threads, BakeSession& session, Progress& now, const ProgressCallback& progress) {
  const std::vector<TileId> units = tree.units();
  LayerSink<L> sink(layer, tree, session);
  const std::size_t done = std::min(units.size(), session.done.size());
  for (std::size_t i = 0; i < done; ++i) {
    now.done += tree.leaves(units[i]).size() * samples_per_leaf;
    if (auto status = sink.replay(session.done[i]); !status) return status;
  }
  session.done.erase(session.done.begin(), session.done.begin() + static_cast<std::ptrdiff_t>(done));
  const auto written = [&session] { return session.writer.position(); };
  return bake_units<L>(units, done, samples_per_leaf, threads, bake, sink, written, now, progress);
}

/// bake_layer_by() where every unit is made from the sources.
template <TileLayer L>
Status bake_layer(L& layer, const TileTree& tree, std::uint64_t samples_per_leaf, int threads,
                  BakeSession& session, Progress& now, const ProgressCallback& progress) {
  return bake_layer_by([&](const TileId& unit) { return bake_unit(layer, tree, unit); }, layer, tree,
                       samples_per_leaf, threads, session, now, progress);
}

}  // namespace cairn
