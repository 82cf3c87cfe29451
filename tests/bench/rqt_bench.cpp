// The rqt layer of a pack in numbers: bits, triangles, and what it takes to make a tile's triangles from it.

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include <fmt/core.h>

#include "cairn/pack_reader.h"
#include "format/rqt_block.h"
#include "format/rqt_triangulate.h"

namespace cairn {
namespace {

double cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

struct Corner {
  int column;
  int row;
};

/// Intel 2012, Algorithm 1: the indices of triangulation k.
class Triangles {
 public:
  Triangles(const RqtSteps& vertices, int k, std::vector<std::uint32_t>& out)
      : vertices_(vertices), k_(k), out_(out) {}

  void run() {
    const int n = vertices_.size() - 1;
    const Corner sw{0, 0}, se{n, 0}, ne{n, n}, nw{0, n};
    if (vertices_.rising()) {
      bisect(ne, sw, se);
      bisect(sw, ne, nw);
    } else {
      bisect(se, nw, ne);
      bisect(nw, se, sw);
    }
  }

 private:
  void bisect(const Corner& a, const Corner& b, const Corner& apex) {
    const int column = a.column + b.column, row = a.row + b.row;
    const bool has_base = ((column | row) & 1) == 0;
    if (has_base && vertices_.has(column / 2, row / 2, k_)) {
      const Corner base{column / 2, row / 2};
      bisect(apex, a, base);
      bisect(b, apex, base);
      return;
    }
    for (const Corner& corner : {a, b, apex})
      out_.push_back(static_cast<std::uint32_t>(corner.row * vertices_.size() + corner.column));
  }

  const RqtSteps& vertices_;
  int k_;
  std::vector<std::uint32_t>& out_;
};

struct Level {
  std::size_t tiles = 0;
  double samples = 0, bytes = 0, bits = 0, first_bits = 0, triangles = 0;
  double tolerance_m = 0, decode_s = 0, indices_s = 0, anew_s = 0;
};

/// Bits of the first triangulation alone.
double bits_alone(const RqtBlock& block) {
  RqtBlock first{block.tolerance_m, 1, RqtSteps(block.vertices.size(), block.vertices.rising())};
  const auto steps = first.vertices.writable();
  const auto all = block.vertices.all();
  for (std::size_t i = 0; i < all.size(); ++i)
    steps[i] = all[i] > 0 ? std::max<std::uint8_t>(steps[i], 1) : 0;
  return static_cast<double>(encode_rqt_block(first).size()) * 8;
}

template <class Work>
double best_of_five(const Work& work) {
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 5; ++i) {
    const double start = cpu_s();
    work();
    best = std::min(best, cpu_s() - start);
  }
  return best;
}

int measure(const PackReader& pack, const IndexEntry& entry, Level& level) {
  const int size = pack.header().tile_size;
  const bool rising = root_rises(entry.id);
  const auto bytes = pack.read_block(entry);
  if (!bytes) return fmt::print(stderr, "{}\n", bytes.error().message), 1;
  const auto block = decode_rqt_block(*bytes, size, rising);
  if (!block) return fmt::print(stderr, "{}\n", block.error().message), 1;
  const auto heights = pack.read_height_tile(*pack.find(Layer::heights, entry.id));
  if (!heights) return fmt::print(stderr, "{}\n", heights.error().message), 1;
  ++level.tiles;
  level.samples += static_cast<double>(size) * size;
  level.bytes += static_cast<double>(bytes->size());
  level.bits += static_cast<double>(rqt_bit_count(*bytes));
  level.first_bits += bits_alone(*block);
  level.triangles += static_cast<double>(block->vertices.triangle_count(0));
  level.tolerance_m = static_cast<double>(block->tolerance_m);
  level.decode_s += best_of_five([&] { (void)decode_rqt_block(*bytes, size, rising); });
  std::vector<std::uint32_t> indices;
  level.indices_s += best_of_five([&] {
    indices.clear();
    Triangles(block->vertices, 0, indices).run();
  });
  level.anew_s += best_of_five([&] {
    (void)triangulate(*heights, pack.header().quantum_m, block->tolerance_m, block->steps, rising);
  });
  return 0;
}

int run(const char* path) {
  const auto pack = PackReader::open(path);
  if (!pack) return fmt::print(stderr, "{}\n", pack.error().message), 1;
  std::map<int, Level> levels;
  for (std::size_t i = 0; i < pack->entry_count(); ++i) {
    const IndexEntry entry = pack->entry(i);
    if (entry.layer == Layer::rqt && measure(*pack, entry, levels[entry.id.level]) != 0) return 1;
  }
  const double cells = static_cast<double>(pack->header().tile_size - 1);
  double bytes = 0, first_bytes = 0;
  fmt::print("{:>5} {:>6} {:>11} {:>10} {:>15} {:>15} {:>13} {:>11} {:>9} {:>10} {:>9}\n", "level", "tiles",
             "tolerance m", "full/first", "bits/s., first", "bits/s., all", "bits/visited", "bytes",
             "decode ms", "indices ms", "anew ms");
  for (const auto& [number, l] : levels) {
    const double n = static_cast<double>(l.tiles);
    bytes += l.bytes;
    first_bytes += l.first_bits / 8;
    fmt::print(
        "{:>5} {:>6} {:>11.2f} {:>10.2f} {:>15.3f} {:>15.3f} {:>13.3f} {:>11.0f} {:>9.2f} {:>10.2f} "
        "{:>9.2f}\n",
        number, l.tiles, l.tolerance_m, n * 2 * cells * cells / l.triangles, l.first_bits / l.samples,
        l.bytes * 8 / l.samples, l.bytes * 8 / l.bits, l.bytes, l.decode_s / n * 1e3, l.indices_s / n * 1e3,
        l.anew_s / n * 1e3);
  }
  fmt::print("all levels: {:.2f} MB, with the first triangulation alone {:.2f} MB\n", bytes / 1e6,
             first_bytes / 1e6);
  return 0;
}

}  // namespace
}  // namespace cairn

int main(int argc, char** argv) {
  if (argc != 2) return fmt::print(stderr, "usage: cairn-rqt-bench PACK\n"), 2;
  return cairn::run(argv[1]);
}
