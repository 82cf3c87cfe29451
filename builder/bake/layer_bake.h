#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "builder/bake/bake_session.h"
#include "builder/bake/pipeline.h"
#include "cairn/progress.h"
#include "builder/bake/pyramid.h"
#include "builder/bake/tile_tree.h"
#include "format/bytes.h"

namespace cairn {

/// A unit's subtree: its tiles, and the root on its way up.
template <class TileLayer>
struct UnitResult {
  std::vector<TileBlock> blocks;
  typename TileLayer::Tile root;
  std::uint64_t leaves = 0;
};

template <class TileLayer>
Result<UnitResult<TileLayer>> bake_unit(const TileLayer& layer, const TileTree& tree, const TileId& unit) {
  UnitResult<TileLayer> result;
  Pyramid<TileLayer> pyramid(layer, tree, unit.level, [&](TileBlock&& block) -> Status {
    result.blocks.push_back(std::move(block));
    return {};
  });
  for (const TileId& leaf : tree.leaves(unit)) {
    auto baked = layer.bake_leaf(leaf);
    if (!baked) return baked.error();
    ++result.leaves;
    if (auto status = pyramid.settle(*baked); !status) return status.error();
    auto root = pyramid.add(std::move(*baked));
    if (!root) return root.error();
    if (*root) result.root = std::move(**root);
  }
  return result;
}

/// The serial end of the pipeline: writes the units' tiles, puts the tiles above them together, keeps the
/// journal.
template <class TileLayer>
class LayerSink {
 public:
  LayerSink(TileLayer& layer, const TileTree& tree, BakeSession& session)
      : layer_(layer),
        session_(session),
        above_(layer, tree, tree.top(), [this](TileBlock&& block) { return emit(block); }) {}

  Status take(UnitResult<TileLayer>&& unit) {
    record_ = {};
    for (const TileBlock& block : unit.blocks) {
      if (auto status = emit(block); !status) return status;
    }
    layer_.append(unit.root, record_.root);
    if (auto status = go_up(std::move(unit.root)); !status) return status;
    // The journal must not speak of blocks that a killed process would still hold.
    if (auto status = session_.writer.flush(); !status) return status;
    return session_.journal.append(record_);
  }

  /// Runs a journalled unit again without writing what the pack has.
  Status replay(const UnitRecord& done) {
    const auto bytes = session_.journal.read_root(done);
    if (!bytes) return bytes.error();
    ByteReader reader(*bytes);
    auto root = layer_.read(reader);
    if (!root) return root.error();
    replaying_ = true;
    auto status = go_up(std::move(*root));
    replaying_ = false;
    return status;
  }

 private:
  Status emit(const TileBlock& block) {
    if (replaying_) return {};
    auto entry = session_.writer.add(block.entry, block.block);
    if (!entry) return entry.error();
    record_.entries.push_back(*entry);
    return {};
  }

  Status go_up(typename TileLayer::Tile&& unit_root) {
    auto root = above_.add(std::move(unit_root));
    if (!root) return root.error();
    if (*root) layer_.summarise(**root);
    return {};
  }

  TileLayer& layer_;
  BakeSession& session_;
  Pyramid<TileLayer> above_;
  UnitRecord record_;
  bool replaying_ = false;
};

/// Makes every tile of a layer and adds it to the pack; returns how many samples its leaves have. Units that
/// were done before an interruption (the first records of session.done, which are used up) are in the pack
/// already. Uses all threads of the caller's arena. Beyond what Pyramid asks for, the layer has
///   Result<Tile> bake_leaf(const TileId&) const     safe to call from several threads,
///   append(), read()                                a settled tile in the journal,
///   void summarise(const Tile&)                     takes what a settled root of the whole tree knows,
///   stage(), samples_a_tile()                       for the progress.
template <class TileLayer>
Result<std::uint64_t> bake_layer(TileLayer& layer, const TileTree& tree, int threads, BakeSession& session,
                                 const ProgressCallback& progress) {
  const std::vector<TileId> units = tree.units();
  Progress now{TileLayer::stage(), 0, tree.leaf_count() * layer.samples_a_tile(), 0};
  LayerSink<TileLayer> sink(layer, tree, session);
  const std::size_t done = std::min(units.size(), session.done.size());
  for (std::size_t i = 0; i < done; ++i) {
    now.done += tree.leaves(units[i]).size() * layer.samples_a_tile();
    if (auto status = sink.replay(session.done[i]); !status) return status.error();
  }
  session.done.erase(session.done.begin(), session.done.begin() + static_cast<std::ptrdiff_t>(done));
  const auto status = run_in_order<UnitResult<TileLayer>>(
      done, units.size(), static_cast<std::size_t>(threads) + 1,
      [&](std::size_t i) { return bake_unit(layer, tree, units[i]); },
      [&](std::size_t, UnitResult<TileLayer>&& unit) {
        now.done += unit.leaves * layer.samples_a_tile();
        auto taken = sink.take(std::move(unit));
        now.bytes_written = session.writer.position();
        progress(now);
        return taken;
      });
  if (!status) return status.error();
  return now.done;
}

}  // namespace cairn
