#include "builder/resample/resample_lattice.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <vector>

#include "builder/resample/row_passes.h"

namespace cairn {
namespace {

bool picks_posts(const AxisWeights& weights) {
  return std::all_of(weights.rows.begin(), weights.rows.end(), [&](const AxisWeights::Row& row) {
    return row.count == 1 && weights.weights_of(row).front() == 1;
  });
}

bool are_consecutive(const std::vector<AxisWeights::Row>& rows) {
  const std::ptrdiff_t first = rows.front().first;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (rows[k].first != first + static_cast<std::ptrdiff_t>(k)) return false;
  }
  return true;
}

void pick(const AxisWeights& x, const AxisWeights& y, IndexWindow window, Rows<const float> posts,
          float* out) {
  const bool copies = are_consecutive(x.rows);
  for (const AxisWeights::Row& to_y : y.rows) {
    const float* from = posts.row(to_y.first - window.y.first);
    if (copies) {
      out = std::copy_n(from + (x.rows.front().first - window.x.first), x.rows.size(), out);
      continue;
    }
    for (const AxisWeights::Row& to_x : x.rows) *out++ = from[to_x.first - window.x.first];
  }
}

// A block of sample columns: along x over transposed posts, so that both passes combine whole rows, then
// along y.
void combine_block(const AxisWeights& x, std::ptrdiff_t first, std::ptrdiff_t width, const AxisWeights& y,
                   IndexWindow window, Rows<const float> posts, std::array<Scratch<double>, 3>& scratch,
                   Rows<float> out) {
  const auto columns =
      std::span(x.rows).subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(width));
  const IndexRange over = posts_of(columns);
  const IndexRange down = posts_of(y.rows);
  const Rows<double> turned = scratch[0].shape(over.count(), down.count());
  const Rows<double> along_x = scratch[1].shape(width, down.count());
  const Rows<double> upright = scratch[2].shape(down.count(), width);
  const float* corner = posts.row(down.first - window.y.first) + (over.first - window.x.first);
  transpose(Rows<const float>{corner, posts.stride}, down.count(), over.count(), turned);
  for (std::ptrdiff_t k = 0; k < width; ++k) {
    const AxisWeights::Row& row = columns[static_cast<std::size_t>(k)];
    weighted_row_sum(x.weights_of(row), read(turned, row.first - over.first),
                     static_cast<std::size_t>(down.count()), along_x.row(k));
  }
  transpose(read(along_x), width, down.count(), upright);
  for (std::size_t k = 0; k < y.rows.size(); ++k) {
    const AxisWeights::Row& row = y.rows[k];
    weighted_row_sum(y.weights_of(row), read(upright, row.first - down.first),
                     static_cast<std::size_t>(width), out.row(static_cast<std::ptrdiff_t>(k)) + first);
  }
}

}  // namespace

void resample_lattice(const AxisResampler& x, const AxisResampler& y, IndexWindow post_window,
                      std::span<const float> posts, IndexWindow sample_window, std::span<float> out) {
  assert(posts.size() == static_cast<std::size_t>(post_window.count()));
  assert(out.size() == static_cast<std::size_t>(sample_window.count()));
  const AxisWeights to_x = x.weights_for(sample_window.x);
  const AxisWeights to_y = y.weights_for(sample_window.y);
  assert(post_window.holds({posts_of(to_x.rows), posts_of(to_y.rows)}));
  const Rows<const float> from{posts.data(), post_window.x.count()};
  if (picks_posts(to_x) && picks_posts(to_y)) return pick(to_x, to_y, post_window, from, out.data());

  std::array<Scratch<double>, 3> scratch;
  const std::ptrdiff_t columns = sample_window.x.count();
  for (std::ptrdiff_t first = 0; first < columns; first += kStripColumns) {
    combine_block(to_x, first, std::min(kStripColumns, columns - first), to_y, post_window, from, scratch,
                  {out.data(), columns});
  }
}

}  // namespace cairn
