// Pyramid and bake_layer() with a layer whose tiles are numbers.

#include "builder/bake/layer_bake.h"

#include <atomic>
#include <cstring>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "builder/bake/thread_arena.h"
#include "cairn/pack_reader.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

// A leaf is its place as a number, a parent the sum of its children. Tiles with an odd number are pruned.
class SumLayer {
 public:
  struct Node {
    TileId id;
    std::int64_t sum = 0;
    int children = 0;
    bool is_finished = false;
  };
  using Leaf = Node;

  static std::int64_t number_of(const TileId& id) { return std::int64_t{1000} * id.x + id.y; }

  Result<Node> sample_leaf(const TileId& id) const { return Node{id, number_of(id), 0, false}; }
  Node measure_leaf(Node leaf) const {
    leaf.is_finished = true;
    return leaf;
  }
  Node begin_parent(const TileId& id) const { return {id, 0, 0, false}; }
  void merge_child(const Node& child, Node& parent) const {
    const bool is_right = child.is_finished && !parent.is_finished && parent_of(child.id) == parent.id;
    if (!is_right) ++faults;  // Catch's macros belong to one thread
    parent.sum += child.sum;
    ++parent.children;
  }
  void finish_parent(Node& parent) const { parent.is_finished = true; }
  bool can_prune(const Node& node) const { return node.sum % 2 != 0; }
  void prune(Node&) const {}
  void keep(Node&) const {}
  TileBlock encode(Node& node) const {
    TileBlock out;
    out.entry.layer = Layer::heights;
    out.entry.id = node.id;
    out.entry.min_quanta = out.entry.max_quanta = static_cast<std::int32_t>(node.sum);
    // Blocks of different lengths, no two of them equal; some tiles have none.
    if (node.sum % 6 == 0) {
      out.entry.flags = kConstant;
      return out;
    }
    out.block.resize(static_cast<std::size_t>(12 + node.sum % 50));
    const std::int32_t place[] = {node.id.level, node.id.x, node.id.y};
    std::memcpy(out.block.data(), place, sizeof place);
    return out;
  }
  void save_state(const Node& node, std::vector<std::byte>& out) const {
    ByteWriter writer(out);
    writer.write(std::int32_t{node.id.level});
    writer.write(node.id.x);
    writer.write(node.id.y);
    writer.write(node.sum);
  }
  Result<Node> load_state(ByteReader& in) const {
    Node node;
    node.id.level = in.read<std::int32_t>();
    node.id.x = in.read<std::int32_t>();
    node.id.y = in.read<std::int32_t>();
    node.sum = in.read<std::int64_t>();
    node.is_finished = true;
    return node;
  }
  void finish_root(const Node& root) { roots.push_back(root); }

  std::vector<Node> roots;
  mutable std::atomic<int> faults = 0;
};

// Twenty cells in two rows, one of which is four times as fine as the others.
TileTree small_tree() {
  return TileTree(-2, [](const TileId& id) -> std::optional<int> {
    const GeoBounds b = tile_bounds(id);
    if (b.west >= 10 || b.east <= 0 || b.south >= 2 || b.north <= 0) return std::nullopt;
    return b.west < 1 && b.south < 1 ? 2 : 0;
  });
}

std::map<TileId, std::int64_t> expected_sums(const TileTree& tree) {
  std::map<TileId, std::int64_t> sums;
  for (const TileId& unit : tree.units()) {
    for (const TileId& leaf : tree.leaves(unit)) {
      for (TileId id = leaf;; id = parent_of(id)) {
        sums[id] += SumLayer::number_of(leaf);
        if (id.level == tree.top()) break;
      }
    }
  }
  return sums;
}

struct Baked {
  Status status;
  std::vector<Progress> progress;
  bool resumed = false;
  std::vector<SumLayer::Node> roots;
};

Baked bake_sums(const fs::path& target, bool resume, int threads, std::size_t calls) {
  SessionOptions options;
  options.target = target;
  options.resume = resume;
  auto session = begin_session(options, {{}, "sums"}, test::test_header());
  REQUIRE(session.ok());
  return with_threads(threads, [&](int count) {
    InputHashing hashing(*session);
    Baked baked;
    baked.resumed = session->resumed;
    SumLayer layer;
    const TileTree tree = small_tree();
    Progress now{"sums", 0, tree.leaf_count(), 0};
    baked.status = bake_layer(layer, tree, 1, count, *session, now, [&](const Progress& p) {
      baked.progress.push_back(p);
      return baked.progress.size() < calls;
    });
    baked.roots = layer.roots;
    CHECK(layer.faults == 0);
    if (!baked.status) {
      (void)end_failed_bake(*session, hashing, baked.status.error());
      return baked;
    }
    REQUIRE(session->writer.finish("{}").ok());
    remove_journal(target);
    return baked;
  });
}

constexpr std::size_t kAllCalls = 1000;

}  // namespace

TEST_CASE("a pyramid merges every child once and hands out each parent after its last child") {
  const SumLayer layer;
  const TileTree tree = small_tree();
  const auto expected = expected_sums(tree);
  Pyramid<SumLayer> pyramid(layer, tree);
  std::set<TileId> finished;
  for (const TileId& unit : tree.units()) {
    for (const TileId& leaf : tree.leaves(unit)) {
      std::optional<SumLayer::Node> node = layer.measure_leaf(*layer.sample_leaf(leaf));
      while (node) {
        CHECK(finished.insert(node->id).second);
        CHECK(node->sum == expected.at(node->id));
        if (node->children > 0) CHECK(node->children == tree.children_of(node->id));
        if (node->id.level == tree.top()) break;
        auto merged = pyramid.merge(*node, std::nullopt);
        node.reset();
        if (merged) node = std::move(merged->parent);
      }
    }
  }
  CHECK(finished.size() == expected.size());
  CHECK(layer.faults == 0);
}

TEST_CASE("a layer's pack has every tile that is not pruned, children before parents, whatever the threads") {
  const test::TempDir dir;
  const auto expected = expected_sums(small_tree());
  std::vector<std::byte> first;
  for (const int threads : {1, 4}) {
    const fs::path target = dir.path() / "sums.cairn";
    const Baked baked = bake_sums(target, false, threads, kAllCalls);
    REQUIRE(baked.status.ok());
    CHECK(baked.progress.back().done == baked.progress.back().total);
    CHECK(baked.roots.size() == 3);  // ten degrees in tiles of four
    const auto bytes = test::read_bytes(target);
    if (first.empty()) first = bytes;
    CHECK(bytes == first);
    const auto pack = PackReader::open(target);
    REQUIRE(pack.ok());
    std::map<TileId, std::int64_t> stored;
    for (std::size_t i = 0; i < pack->entry_count(); ++i)
      stored[pack->entry(i).id] = pack->entry(i).min_quanta;
    std::map<TileId, std::int64_t> even;
    for (const auto& [id, sum] : expected) {
      if (sum % 2 == 0) even[id] = sum;
    }
    CHECK(stored == even);
  }
}

TEST_CASE("the stored children of a tile lie side by side in the pack, in the order of their quadrants") {
  const test::TempDir dir;
  const fs::path target = dir.path() / "sums.cairn";
  REQUIRE(bake_sums(target, false, 2, kAllCalls).status.ok());
  const auto pack = PackReader::open(target);
  REQUIRE(pack.ok());
  std::set<TileId> parents;
  for (std::size_t i = 0; i < pack->entry_count(); ++i) {
    const IndexEntry entry = pack->entry(i);
    if (entry.id.level > small_tree().top()) parents.insert(parent_of(entry.id));
  }
  std::size_t groups = 0;
  for (const TileId& parent : parents) {
    std::optional<std::uint64_t> end;
    for (int q = 0; q < 4; ++q) {
      const TileId id = child_of(parent, q);
      const auto entry = is_valid(id) ? pack->find(Layer::heights, id) : std::nullopt;
      if (!entry || entry->bytes == 0) continue;
      INFO("child " << to_string(id));
      if (end) CHECK(entry->offset == *end);
      groups += end ? 1 : 0;
      end = entry->offset + entry->bytes;
    }
  }
  CHECK(groups > 0);
}

TEST_CASE("a layer cancelled after any unit is resumed to equal bytes") {
  const test::TempDir dir;
  const fs::path whole = dir.path() / "whole.cairn", cut = dir.path() / "cut.cairn";
  const Baked all = bake_sums(whole, false, 2, kAllCalls);
  const auto expected = test::read_bytes(whole);
  const std::size_t units = all.progress.size();
  REQUIRE(units == small_tree().units().size());
  for (std::size_t cut_after = 1; cut_after <= units; ++cut_after) {
    const Baked cancelled = bake_sums(cut, false, 2, cut_after);
    REQUIRE_FALSE(cancelled.status.ok());
    CHECK(cancelled.progress.size() == cut_after);
    CHECK(fs::exists(Journal::path_for(cut)));
    const Baked resumed = bake_sums(cut, true, 1, kAllCalls);
    REQUIRE(resumed.status.ok());
    CHECK(resumed.resumed);
    CHECK(resumed.progress.size() == units - cut_after);
    CHECK(resumed.roots.size() == all.roots.size());
    CHECK(test::read_bytes(cut) == expected);
    fs::remove(cut);
  }
}

}  // namespace cairn
