#include "format/rqt_rules.h"

#include <atomic>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "format/rqt_block.h"
#include "format/rqt_borders.h"
#include "format/rqt_triangulate.h"

namespace cairn {
namespace {

/// A tile of a level, and what was found wrong with it.
struct Checked {
  IndexEntry entry;
  std::optional<Finding> finding;
};

void find(Checked& tile, std::string what) {
  if (!tile.finding) tile.finding = {"rqt " + to_string(tile.entry.id), std::move(what)};
}

void for_each_on_threads(int threads, std::size_t count, const std::function<void(std::size_t)>& work) {
  std::atomic<std::size_t> next = 0;
  const auto run = [&] {
    for (std::size_t i = next++; i < count; i = next++) work(i);
  };
  std::vector<std::thread> others;
  for (int t = 1; t < threads; ++t) others.emplace_back(run);
  run();
  for (std::thread& other : others) other.join();
}

std::optional<RqtBlock> decode(const PackReader& pack, Checked& tile) {
  const auto bytes = pack.read_block(tile.entry);
  if (!bytes) return std::nullopt;  // check_content() says so
  auto block = decode_rqt_block(*bytes, pack.header().tile_size, root_rises(tile.entry.id));
  if (block) return std::move(*block);
  find(tile, block.error().message);
  return std::nullopt;
}

class LevelCheck {
 public:
  LevelCheck(const PackReader& pack, std::vector<Checked>& tiles)
      : pack_(pack), tiles_(tiles), borders_(pack.header().tile_size) {}

  void run(int threads) {
    for_each_on_threads(threads, tiles_.size(), [&](std::size_t i) {
      const auto own = triangulate_anew(tiles_[i]);
      const std::lock_guard lock(mutex_);
      if (own) borders_.add(tiles_[i].entry.id, *own);
    });
    borders_.settle();
    for_each_on_threads(threads, tiles_.size(), [&](std::size_t i) { compare(tiles_[i]); });
  }

 private:
  std::optional<RqtSteps> triangulate_anew(Checked& tile) const {
    const auto block = decode(pack_, tile);
    if (!block) return std::nullopt;
    const TileId& id = tile.entry.id;
    const auto entry = pack_.find(Layer::heights, id);
    if (!entry) return find(tile, "expected a height tile there, found none"), std::nullopt;
    const auto heights = pack_.read_height_tile(*entry);
    if (!heights) return std::nullopt;
    return triangulate(*heights, pack_.header().quantum_m, block->tolerance_m, block->steps, root_rises(id));
  }

  void compare(Checked& tile) const {
    const auto stored = decode(pack_, tile);
    auto anew = triangulate_anew(tile);
    if (!stored || !anew) return;
    borders_.apply(tile.entry.id, *anew);
    if (*anew != stored->vertices)
      find(tile, "expected the triangulations that the heights give, found others");
    const auto triangles = [&](int k) { return static_cast<std::int32_t>(anew->triangle_count(k)); };
    const IndexEntry& e = tile.entry;
    if (e.geometric_error_m != stored->tolerance_m || e.max_quanta != triangles(0) ||
        e.min_quanta != triangles(stored->steps - 1))
      find(tile, "expected the block's tolerance and numbers of triangles in the index, found others");
  }

  const PackReader& pack_;
  std::vector<Checked>& tiles_;
  RqtBorders borders_;
  std::mutex mutex_;
};

}  // namespace

void check_rqt_layer(const PackReader& pack, int threads, std::vector<Finding>& findings) {
  std::vector<Checked> level;
  const auto check_level = [&] {
    if (level.empty()) return;
    LevelCheck(pack, level).run(threads);
    for (Checked& tile : level) {
      if (tile.entry.geometric_error_m != level.front().entry.geometric_error_m)
        find(tile, "expected the tolerance of its level, found another");
      if (tile.finding) findings.push_back(std::move(*tile.finding));
    }
    level.clear();
  };
  for (std::size_t i = 0; i < pack.entry_count(); ++i) {
    const IndexEntry entry = pack.entry(i);
    if (entry.layer != Layer::rqt) continue;
    if (!level.empty() && level.front().entry.id.level != entry.id.level) check_level();
    level.push_back({entry, {}});
  }
  check_level();
}

}  // namespace cairn
