// Divides, bakes, merges and reads a planet of synthetic tiles of a few bytes: scripts/bench_planet. A layer
// that samples nothing stands in for heights and imagery; all else is what cairn plan, bake --plan, merge and
// the reader do.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include <sys/resource.h>

#include "builder/shard/part_merge.h"
#include "builder/shard/shard_plan.h"
#include "builder/shard/shard_tiles.h"
#include "cairn/geo.h"
#include "cairn/pack_reader.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr int kFinestHeights = 3;
constexpr int kFinestImagery = 5;
constexpr double kTextured = 0.565;  // of what has heights
constexpr int kFinds = 200'000;

/// A layer whose tiles hold their own address.
class AddressLayer {
 public:
  struct Node {
    TileId id;
    std::uint32_t leaves = 0;
  };
  using Leaf = Node;

  explicit AddressLayer(Layer kind) : kind_(kind) {}

  Result<Leaf> sample_leaf(const TileId& id) const { return Node{id, 1}; }
  Node measure_leaf(Leaf leaf) const { return leaf; }
  Node begin_parent(const TileId& id) const { return {id, 0}; }
  void merge_child(const Node& child, Node& parent) const { parent.leaves += child.leaves; }
  void finish_parent(Node&) const {}
  bool can_prune(const Node&) const { return false; }
  void prune(Node&) const {}
  void keep(Node&) const {}
  TileBlock encode(Node& node) const {
    TileBlock tile;
    tile.entry.layer = kind_;
    tile.entry.id = node.id;
    tile.entry.min_quanta = node.id.x;
    tile.entry.max_quanta = node.id.x + std::abs(node.id.y);
    tile.entry.geometric_error_m = static_cast<float>(node.leaves);
    tile.block.resize(sizeof node.id);
    std::memcpy(tile.block.data(), &node.id, sizeof node.id);
    return tile;
  }
  void save_state(const Node& node, std::vector<std::byte>& out) const {
    ByteWriter writer(out);
    writer.write(std::int32_t{node.id.level});
    writer.write(node.id.x);
    writer.write(node.id.y);
    writer.write(node.leaves);
  }
  Result<Node> load_state(ByteReader& in) const {
    Node node;
    node.id.level = in.read<std::int32_t>();
    node.id.x = in.read<std::int32_t>();
    node.id.y = in.read<std::int32_t>();
    node.leaves = in.read<std::uint32_t>();
    if (!in.ok()) return bad_data("state: expected a tile's address, found less");
    return node;
  }
  void finish_root(const Node& root) { leaves_ += root.leaves; }
  std::uint64_t leaves() const { return leaves_; }

 private:
  Layer kind_;
  std::uint64_t leaves_ = 0;
};

/// The western part of a planet, all of it for the fraction 1.
struct Planet {
  double fraction = 1;

  static TileTree tree(int finest, double fraction) {
    return TileTree(kMinLevel,
                    [finest, east = -180 + 360 * fraction](const TileId& id) -> std::optional<int> {
                      return tile_bounds(id).west < east ? std::optional(finest) : std::nullopt;
                    });
  }
  TileTree heights() const { return tree(kFinestHeights, fraction); }
  TileTree imagery() const { return tree(kFinestImagery, kTextured * fraction); }
};

bool go_on(const Progress&) {
  return true;
}

fs::path plan_of(const fs::path& folder) {
  return folder / "plan.json";
}

fs::path part_of(const fs::path& folder, std::size_t shard) {
  return folder / (std::to_string(shard) + ".part");
}

Status plan(const fs::path& folder, const Planet& planet, std::size_t shards) {
  const TileTree heights = planet.heights(), imagery = planet.imagery();
  DividedTiles tiles = divide_tiles(&heights, &imagery, shards);
  ShardPlan plan;
  plan.version = CAIRN_VERSION;
  plan.options = nlohmann::json::object();
  plan.shards.resize(shards);
  for (std::size_t s = 0; s < shards; ++s) {
    plan.shards[s].heights = std::move(tiles.heights[s]);
    plan.shards[s].imagery = std::move(tiles.imagery[s]);
  }
  return write_shard_plan(plan, plan_of(folder));
}

Status bake_layer_of_shard(Layer kind, const TileTree& tree, const ShardTiles& tiles, PartWriter& part) {
  const AddressLayer layer(kind);
  PartSink<AddressLayer> sink(layer, kind, tree, tiles.subtrees, part);
  for (const TileId& id : units_of(tree, tiles)) {
    auto unit = bake_unit(layer, tree, id);
    if (!unit) return unit.error();
    if (auto status = sink.take(std::move(*unit)); !status) return status;
  }
  return {};
}

Status shard(const fs::path& folder, const Planet& planet, std::size_t number) {
  const auto plan = read_shard_plan(plan_of(folder));
  if (!plan) return plan.error();
  const Shard& own = plan->shards.at(number);
  const TileTree heights = planet.heights(), imagery = planet.imagery();
  SessionOptions session;
  session.target = part_of(folder, number);
  const std::uint64_t units = units_of(heights, own.heights).size() + units_of(imagery, own.imagery).size();
  auto part = PartWriter::begin(session, {plan->version, own.key, number, plan->shards.size(), units});
  if (!part) return part.error();
  if (auto status = bake_layer_of_shard(Layer::heights, heights, own.heights, *part); !status) return status;
  if (auto status = bake_layer_of_shard(Layer::imagery, imagery, own.imagery, *part); !status) return status;
  return part->finish();
}

Status merge_layer(Layer kind, const TileTree& tree, const ShardPlan& plan, ShardTiles Shard::*tiles,
                   std::vector<MergedPart>& parts, BakeSession& session) {
  AddressLayer layer(kind);
  LayerSink sink(layer, tree, session);
  Progress now;
  for (std::size_t s = 0; s < parts.size(); ++s) {
    const Status status = merge_part(parts[s], units_of(tree, plan.shards[s].*tiles), kind, layer, tree, 1,
                                     session, sink, now, go_on);
    if (!status) return status;
  }
  const std::uint64_t expected = tree.leaf_count();
  if (layer.leaves() == expected) return {};
  return bad_data("merge: expected " + std::to_string(expected) + " leaves, found " +
                  std::to_string(layer.leaves()));
}

Status merge(const fs::path& folder, const Planet& planet) {
  const auto plan = read_shard_plan(plan_of(folder));
  if (!plan) return plan.error();
  std::vector<MergedPart> parts;
  for (std::size_t s = 0; s < plan->shards.size(); ++s) {
    const auto part = PartReader::open(part_of(folder, s));
    if (!part) return part.error();
    parts.push_back({part->path(), part->position()});
  }
  SessionOptions options;
  options.target = folder / "planet.cairn";
  auto session = begin_session(options, {}, PackHeader());
  if (!session) return session.error();
  const TileTree heights = planet.heights(), imagery = planet.imagery();
  if (auto status = merge_layer(Layer::heights, heights, *plan, &Shard::heights, parts, *session); !status)
    return status;
  if (auto status = merge_layer(Layer::imagery, imagery, *plan, &Shard::imagery, parts, *session); !status)
    return status;
  if (auto status = session->writer.finish("{}"); !status) return status;
  remove_journal(options.target);
  return {};
}

// Reads a tile's block and compares it with its address.
Status check_tile(const PackReader& pack, Layer layer, const TileId& id) {
  const auto entry = pack.find(layer, id);
  if (!entry) return bad_data(to_string(id) + ": expected the tile, found none");
  const auto block = pack.read_block(*entry);
  if (!block) return block.error();
  if (block->size() == sizeof id && std::memcmp(block->data(), &id, sizeof id) == 0) return {};
  return bad_data(to_string(id) + ": expected its own block, found another");
}

// The tiles along the western end of the equator and all above them: what a program reads that flies there.
Status fly_over(const PackReader& pack, Layer layer, int finest, std::int32_t columns) {
  constexpr std::int32_t kSteps = 400, kReach = 4;
  const std::int32_t middle = tiles_pole_to_pole(finest) / 2;
  for (std::int32_t x = 0; x < std::min(kSteps, columns); ++x) {
    for (std::int32_t y = middle - kReach; y <= middle + kReach; ++y) {
      for (TileId id{finest, x, y};; id = parent_of(id)) {
        if (auto status = check_tile(pack, layer, id); !status) return status;
        if (id.level == kMinLevel) break;
      }
    }
  }
  return {};
}

// Tiles at random places, so that every page of the index is needed.
Status find_anywhere(const PackReader& pack, Layer layer, int finest, std::int32_t columns) {
  std::mt19937 random(2);
  const auto rows = static_cast<unsigned>(tiles_pole_to_pole(finest));
  for (int i = 0; i < kFinds; ++i) {
    const TileId id{finest, static_cast<std::int32_t>(random() % static_cast<unsigned>(columns)),
                    static_cast<std::int32_t>(random() % rows)};
    if (auto status = check_tile(pack, layer, id); !status) return status;
  }
  return {};
}

template <class Visit>
Status read(const fs::path& folder, const Planet& planet, const Visit& visit) {
  const auto pack = PackReader::open(folder / "planet.cairn");
  if (!pack) return pack.error();
  std::uint64_t heights = 0;
  for (const PackLevel& level : pack->level_table())
    if (level.layer == Layer::heights) heights += level.tiles;
  std::printf("entries %zu heights %llu bytes %llu ", pack->entry_count(),
              static_cast<unsigned long long>(heights),
              static_cast<unsigned long long>(pack->header().file_bytes()));
  const auto columns = [](int finest, double fraction) {
    return std::max(1, static_cast<std::int32_t>(fraction * tiles_around(finest)));
  };
  const std::int32_t of_heights = columns(kFinestHeights, planet.fraction);
  if (auto status = visit(*pack, Layer::heights, kFinestHeights, of_heights); !status) return status;
  return visit(*pack, Layer::imagery, kFinestImagery, columns(kFinestImagery, kTextured * planet.fraction));
}

int run(const std::string& verb, const fs::path& folder, double fraction, std::size_t number) {
  const auto start = Clock::now();
  const Planet planet{fraction};
  const Status status = verb == "plan"    ? plan(folder, planet, number)
                        : verb == "shard" ? shard(folder, planet, number)
                        : verb == "merge" ? merge(folder, planet)
                        : verb == "fly"   ? read(folder, planet, fly_over)
                        : verb == "find"
                            ? read(folder, planet, find_anywhere)
                            : usage_error("expected plan, shard, merge, fly or find, found " + verb);
  if (!status) {
    std::fprintf(stderr, "%s\n", status.error().message.c_str());
    return 1;
  }
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  const auto seconds_of = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  std::printf("cpu %.2f seconds %.2f peak_mib %.1f\n", seconds_of(used.ru_utime) + seconds_of(used.ru_stime),
              std::chrono::duration<double>(Clock::now() - start).count(),
              static_cast<double>(used.ru_maxrss) / 1024);
  return 0;
}

}  // namespace
}  // namespace cairn

int main(int argc, char** argv) {
  if (argc != 5) {
    std::fprintf(stderr,
                 "usage: cairn-planet-bench plan|shard|merge|fly|find FOLDER FRACTION SHARDS|NUMBER\n");
    return 2;
  }
  return cairn::run(argv[1], argv[2], std::atof(argv[3]), static_cast<std::size_t>(std::atoi(argv[4])));
}
