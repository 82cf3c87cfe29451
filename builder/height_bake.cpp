#include "builder/height_bake.h"

#include <algorithm>
#include <cassert>

#include "builder/leaf.h"
#include "builder/pipeline.h"
#include "builder/pyramid.h"

namespace cairn {
namespace {

// A unit's subtree: its tiles but for the root, and the root on its way up.
struct UnitResult {
  std::vector<TileBlock> blocks;
  BakedTile root;
  std::uint64_t tiles = 0;
};

Result<UnitResult> bake_unit(const Mosaic& mosaic, const BuildPlan& plan, VoidMode voids,
                             const TileId& unit) {
  UnitResult result;
  Pyramid pyramid(plan, unit.level, [&](TileBlock&& block) -> Status {
    result.blocks.push_back(std::move(block));
    return {};
  });
  for (const TileId& leaf : plan.leaves(unit)) {
    auto baked = bake_leaf(mosaic, plan, leaf, voids);
    if (!baked) return baked.error();
    ++result.tiles;
    auto root = pyramid.add(std::move(*baked));
    if (!root) return root.error();
    if (*root) result.root = std::move(**root);
  }
  return result;
}

// The serial end of the pipeline: writes the units' tiles, puts the tiles above them together, keeps the
// journal.
class HeightSink {
 public:
  HeightSink(const BuildPlan& plan, PackWriter& writer, Journal& journal)
      : writer_(writer),
        journal_(journal),
        above_(plan, plan.top(), [this](TileBlock&& block) { return emit(block); }) {}

  Status take(UnitResult&& unit) {
    record_.entries.clear();
    for (const TileBlock& block : unit.blocks) {
      if (auto status = emit(block); !status) return status;
    }
    record_.root = unit.root;
    if (auto status = go_up(std::move(unit.root)); !status) return status;
    // The journal must not speak of blocks that a killed process would still hold.
    if (auto status = writer_.flush(); !status) return status;
    return journal_.append(record_);
  }

  // Runs a journalled unit again without writing what the pack has.
  Status replay(UnitRecord&& done) {
    replaying_ = true;
    auto status = go_up(std::move(done.root));
    replaying_ = false;
    return status;
  }

  HeightSummary summary;

 private:
  Status emit(const TileBlock& block) {
    if (replaying_) return {};
    auto entry = writer_.add(block.entry, block.block);
    if (!entry) return entry.error();
    record_.entries.push_back(*entry);
    return {};
  }

  Status go_up(BakedTile&& unit_root) {
    auto root = above_.add(std::move(unit_root));
    if (!root) return root.error();
    if (!*root) return {};
    BakedTile& top = **root;
    if (auto status = above_.settle(top); !status) return status;
    summary.accuracy.add(top.settled);
    summary.posts_won.resize(top.posts_won.size());
    for (std::size_t s = 0; s < top.posts_won.size(); ++s) summary.posts_won[s] += top.posts_won[s];
    return {};
  }

  PackWriter& writer_;
  Journal& journal_;
  Pyramid above_;
  UnitRecord record_;
  bool replaying_ = false;
};

}  // namespace

Result<HeightSummary> bake_heights(const Mosaic& mosaic, const BuildPlan& plan, VoidMode voids, int threads,
                                   std::vector<UnitRecord> done, PackWriter& writer, Journal& journal,
                                   const ProgressCallback& progress) {
  const std::vector<TileId> units = plan.units();
  const auto samples_a_tile =
      static_cast<std::uint64_t>(plan.tile_size() - 1) * static_cast<std::uint64_t>(plan.tile_size() - 1);
  Progress now{"heights", 0, plan.leaf_count() * samples_a_tile, 0};
  HeightSink sink(plan, writer, journal);
  assert(done.size() <= units.size());
  for (std::size_t i = 0; i < done.size(); ++i) {
    now.done += plan.leaves(units[i]).size() * samples_a_tile;
    if (auto status = sink.replay(std::move(done[i])); !status) return status.error();
  }
  const auto status = run_in_order<UnitResult>(
      done.size(), units.size(), static_cast<std::size_t>(threads) + 1,
      [&](std::size_t i) { return bake_unit(mosaic, plan, voids, units[i]); },
      [&](std::size_t, UnitResult&& unit) {
        now.done += unit.tiles * samples_a_tile;
        auto taken = sink.take(std::move(unit));
        now.bytes_written = writer.position();
        progress(now);
        return taken;
      });
  if (!status) return status.error();
  sink.summary.samples = now.done;
  return sink.summary;
}

}  // namespace cairn
