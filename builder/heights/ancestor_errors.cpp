#include "builder/heights/ancestor_errors.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdlib>

#include "format/simd_clones.h"

namespace cairn {
namespace {

constexpr std::int32_t kLargest = 1 << 24;  // quanta: the bounds of nine levels add up in 32 bits
constexpr double kQuarters = 4;             // to a quantum

// Every 2^k-th sample of a tile.
struct Decimated {
  int size = 0;
  const std::int32_t* samples = nullptr;

  const std::int32_t* row(int r) const {
    return samples + static_cast<std::ptrdiff_t>(r) * static_cast<std::ptrdiff_t>(size);
  }
};

std::vector<std::int32_t> every_second(const Decimated& from) {
  std::vector<std::int32_t> to;
  to.reserve(static_cast<std::size_t>(from.size / 2 + 1) * static_cast<std::size_t>(from.size / 2 + 1));
  for (int r = 0; r < from.size; r += 2) {
    const std::int32_t* row = from.row(r);
    for (int c = 0; c < from.size; c += 2) to.push_back(row[c]);
  }
  return to;
}

struct LargestOfRow {
  std::int32_t deviation = 0;
  std::int32_t bound = 0;
};

// How far five samples of a 2×2 group of cells are from the surface of the group's corners, in quarters of a
// quantum: the middles of the sides and the centre.
struct Middles {
  std::int32_t south, north, west, east, centre;

  Middles(const std::int32_t* s, const std::int32_t* m, const std::int32_t* n)
      : south(2 * std::abs(s[0] + s[2] - 2 * s[1])),
        north(2 * std::abs(n[0] + n[2] - 2 * n[1])),
        west(2 * std::abs(s[0] + n[0] - 2 * m[0])),
        east(2 * std::abs(s[2] + n[2] - 2 * m[2])),
        centre(std::abs(s[0] + s[2] + n[0] + n[2] - 4 * m[1])) {}
};

inline std::int32_t larger(std::int32_t a, std::int32_t b) {
  return a > b ? a : b;
}

// The bounds of a row of groups over the tile's own cells: a post is no farther from the group's surface than
// from the tile's own, plus what lies between the two.
CAIRN_SIMD_CLONES LargestOfRow bound_lowest_row(const Decimated& d, int row, const std::int32_t* posts,
                                                std::int32_t* bounds) {
  const std::int32_t *s = d.row(2 * row), *m = d.row(2 * row + 1), *n = d.row(2 * row + 2);
  std::int32_t most_deviation = 0, most_bound = 0;
  for (int c = 0; c < d.size / 2; ++c) {
    const Middles at(s + 2 * c, m + 2 * c, n + 2 * c);
    const std::int32_t deviation =
        larger(larger(larger(at.south, at.north), larger(at.west, at.east)), at.centre);
    bounds[c] = deviation + posts[c];
    most_deviation = larger(most_deviation, deviation);
    most_bound = larger(most_bound, bounds[c]);
  }
  return {most_deviation, most_bound};
}

// The bounds of a row of groups, of those of their four cells: two rows of `cells` bounds.
CAIRN_SIMD_CLONES LargestOfRow bound_row(const Decimated& d, int row, const std::int32_t* south_cells,
                                         const std::int32_t* north_cells, std::int32_t* bounds) {
  const std::int32_t *s = d.row(2 * row), *m = d.row(2 * row + 1), *n = d.row(2 * row + 2);
  std::int32_t most_deviation = 0, most_bound = 0;
  for (int c = 0; c < d.size / 2; ++c) {
    const Middles at(s + 2 * c, m + 2 * c, n + 2 * c);
    const std::int32_t sw = larger(larger(at.south, at.west), at.centre);
    const std::int32_t se = larger(larger(at.south, at.east), at.centre);
    const std::int32_t nw = larger(larger(at.north, at.west), at.centre);
    const std::int32_t ne = larger(larger(at.north, at.east), at.centre);
    most_deviation = larger(most_deviation, larger(larger(sw, se), larger(nw, ne)));
    const std::int32_t south = larger(south_cells[2 * c] + sw, south_cells[2 * c + 1] + se);
    const std::int32_t north = larger(north_cells[2 * c] + nw, north_cells[2 * c + 1] + ne);
    bounds[c] = larger(south, north);
    most_bound = larger(most_bound, bounds[c]);
  }
  return {most_deviation, most_bound};
}

// Rounded up.
std::vector<std::int32_t> in_quarters(const PostErrors& errors, double quantum_m, std::size_t groups) {
  std::vector<std::int32_t> quarters(groups, 0);
  for (std::size_t i = 0; i < errors.groups.size(); ++i) {
    const double exact = static_cast<double>(errors.groups[i]) * kQuarters / quantum_m;
    quarters[i] = static_cast<std::int32_t>(std::min(exact, kQuarters * kLargest)) + 1;
  }
  return quarters;
}

std::vector<std::uint32_t> firsts_by_group(const std::vector<double>& at, int groups) {
  std::vector<std::uint32_t> first(static_cast<std::size_t>(groups) + 1, 0);
  for (const double x : at) ++first[static_cast<std::size_t>(PostErrors::group_of(x, groups)) + 1];
  for (std::size_t g = 1; g < first.size(); ++g) first[g] += first[g - 1];
  return first;
}

// The surface of one ancestor's cell, in quanta. Every term is a short dyadic fraction, so sums are exact at
// samples.
struct Bilinear {
  double x0, y0, scale;
  double corner, along_x, along_y, twist;

  double at(double x, double y) const {
    const double u = (x - x0) * scale;
    const double v = (y - y0) * scale;
    return corner + along_x * u + (along_y + twist * u) * v;
  }
};

Bilinear surface_of_cell(const HeightTile& tile, int level, int column, int row) {
  const int x = column << level, y = row << level, side = 1 << level;
  const double sw = tile.at(x, y), se = tile.at(x + side, y);
  const double nw = tile.at(x, y + side), ne = tile.at(x + side, y + side);
  return {static_cast<double>(x), static_cast<double>(y), std::ldexp(1.0, -level), sw, se - sw, nw - sw,
          ne - se - nw + sw};
}

}  // namespace

// A search for the largest error within cells of one ancestor.
struct AncestorErrors::Search {
  const AncestorErrors& errors;
  bool samples_count;
  bool posts_count;
  double most = 0;  ///< quanta: the largest found so far; what cannot exceed it is not looked at
  double enough = HUGE_VAL;

  void look_into_row(int level, int row) {
    const Bounds& bounds = errors.bounds(level);
    if (bounds.of_rows[static_cast<std::size_t>(row)] / kQuarters <= most) return;
    for (int column = 0; column < bounds.cells && most < enough; ++column) {
      if (bounds.at(column, row) / kQuarters > most)
        look_into_parts(surface_of_cell(errors.tile_, level, column, row), level, column, row);
    }
  }

 private:
  double deviation(const Bilinear& surface, int x, int y) const {
    return std::abs(surface.at(x, y) - errors.tile_.at(x, y));
  }

  void look_into(const Bilinear& surface, int level, int column, int row) {
    const double bound = errors.bounds(level).at(column, row) / kQuarters;
    const int x = column << level, y = row << level, side = 1 << level;
    const double corners =
        std::max(std::max(deviation(surface, x, y), deviation(surface, x + side, y)),
                 std::max(deviation(surface, x, y + side), deviation(surface, x + side, y + side)));
    if (samples_count) most = std::max(most, corners);
    if (bound + corners <= most || most >= enough) return;
    look_into_parts(surface, level, column, row);
  }

  void look_into_parts(const Bilinear& surface, int level, int column, int row) {
    if (level == 1) return look_at_posts(surface, column, row);
    for (int part = 0; part < 4; ++part)
      look_into(surface, level - 1, 2 * column + (part & 1), 2 * row + (part >> 1));
  }

  void look_at_posts(const Bilinear& surface, int column, int row) {
    if (samples_count) {
      for (int y = 2 * row; y <= 2 * row + 2; ++y) {
        for (int x = 2 * column; x <= 2 * column + 2; ++x) most = std::max(most, deviation(surface, x, y));
      }
    }
    if (!posts_count) return;
    look_at_placed_posts(surface, column, row);
    for (const LatticePosts& lattice : errors.lattices_) {
      const auto c = static_cast<std::size_t>(column), r = static_cast<std::size_t>(row);
      const MeasuredPosts& posts = *lattice.posts;
      for (std::size_t j = lattice.first_row[r]; j < lattice.first_row[r + 1]; ++j) {
        for (std::size_t i = lattice.first_column[c]; i < lattice.first_column[c + 1]; ++i) {
          const double height = static_cast<double>(posts.heights[j * posts.xs.size() + i]);
          const double error =
              std::abs(surface.at(posts.xs[i], posts.ys[j]) * errors.quantum_m_ - height) / errors.quantum_m_;
          if (error > most) most = error;  // never for NaN
        }
      }
    }
  }

  void look_at_placed_posts(const Bilinear& surface, int column, int row) {
    const int groups = (errors.tile_.size - 1) / 2;
    const auto group =
        static_cast<std::size_t>(row) * static_cast<std::size_t>(groups) + static_cast<std::size_t>(column);
    for (const PlacedPosts& placed : errors.placed_) {
      for (std::size_t i = placed.first[group]; i < placed.first[group + 1]; ++i) {
        const MeasuredPosts::Placed& post = placed.posts->placed[placed.order[i]];
        const double error =
            std::abs(surface.at(post.x, post.y) * errors.quantum_m_ - static_cast<double>(post.height)) /
            errors.quantum_m_;
        if (error > most) most = error;
      }
    }
  }
};

AncestorErrors::PlacedPosts AncestorErrors::by_group(const MeasuredPosts& posts, int groups) {
  PlacedPosts sorted{&posts, {}, {}};
  const auto group_of = [groups](const MeasuredPosts::Placed& p) {
    return static_cast<std::size_t>(PostErrors::group_of(p.y, groups)) * static_cast<std::size_t>(groups) +
           static_cast<std::size_t>(PostErrors::group_of(p.x, groups));
  };
  sorted.first.assign(static_cast<std::size_t>(groups) * static_cast<std::size_t>(groups) + 1, 0);
  for (const auto& p : posts.placed) ++sorted.first[group_of(p) + 1];
  for (std::size_t g = 1; g < sorted.first.size(); ++g) sorted.first[g] += sorted.first[g - 1];
  std::vector<std::uint32_t> next(sorted.first.begin(), sorted.first.end() - 1);
  sorted.order.resize(posts.placed.size());
  for (std::size_t i = 0; i < posts.placed.size(); ++i)
    sorted.order[next[group_of(posts.placed[i])]++] = static_cast<std::uint32_t>(i);
  return sorted;
}

bool AncestorErrors::can_measure(const HeightTile& tile) {
  if (!tile.voids.empty()) return false;
  const HeightRange range = range_of(tile);
  return range.lowest >= -kLargest && range.highest <= kLargest;
}

AncestorErrors::AncestorErrors(const HeightTile& tile, double quantum_m, std::span<const MeasuredPosts> posts,
                               const PostErrors& own)
    : tile_(tile), quantum_m_(quantum_m), posts_are_exact_(own.groups.empty()) {
  const int groups = (tile.size - 1) / 2;
  const std::vector<std::int32_t> of_posts =
      in_quarters(own, quantum_m, static_cast<std::size_t>(groups) * static_cast<std::size_t>(groups));
  Decimated samples{tile.size, tile.samples.data()};
  std::vector<std::int32_t> decimated;
  for (int cells = groups; cells > 0; cells /= 2) {
    Bounds level;
    level.cells = cells;
    level.of_cells.resize(static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells));
    for (int r = 0; r < cells; ++r) {
      const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(r) * cells;
      std::int32_t* bounds = level.of_cells.data() + at;
      const std::int32_t* below =
          bounds_.empty() ? of_posts.data() + at : bounds_.back().of_cells.data() + 4 * at;
      const LargestOfRow most = bounds_.empty()
                                    ? bound_lowest_row(samples, r, below, bounds)
                                    : bound_row(samples, r, below, below + std::ptrdiff_t{2} * cells, bounds);
      level.of_rows.push_back(most.bound);
      level.found = larger(level.found, most.deviation);
    }
    bounds_.push_back(std::move(level));
    decimated = every_second(samples);
    samples = {cells + 1, decimated.data()};
  }
  for (const MeasuredPosts& p : posts) {
    lattices_.push_back({&p, firsts_by_group(p.xs, groups), firsts_by_group(p.ys, groups)});
    if (!p.placed.empty()) placed_.push_back(by_group(p, groups));
  }
}

double AncestorErrors::max_m(int up) const {
  const Bounds& cells = bounds(up);
  Search search{*this, true, !posts_are_exact_, cells.found / kQuarters};
  const auto widest = std::max_element(cells.of_rows.begin(), cells.of_rows.end()) - cells.of_rows.begin();
  search.look_into_row(up, static_cast<int>(widest));
  for (int r = 0; r < cells.cells; ++r) search.look_into_row(up, r);
  return search.most * quantum_m_;
}

bool AncestorErrors::any_post_beyond(int up, double limit_m) const {
  const double limit = limit_m / quantum_m_;
  Search search{*this, false, true, limit, std::nextafter(limit, HUGE_VAL)};
  for (int r = 0; r < bounds(up).cells; ++r) search.look_into_row(up, r);
  return search.most > limit;
}

}  // namespace cairn
