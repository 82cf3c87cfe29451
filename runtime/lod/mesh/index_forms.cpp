#include "runtime/lod/mesh/index_forms.h"

#include <cassert>

namespace cairn {
namespace {

using Indices = std::vector<std::uint32_t>;

class Grid {
 public:
  Grid(int columns, int rows) : columns_(columns), rows_(rows) {}

  Indices list() const {
    Indices out;
    for (int r = 0; r + 1 < rows_; ++r) {
      for (int c = 0; c + 1 < columns_; ++c) {
        for (const std::uint32_t v : {at(c, r), at(c + 1, r), at(c + 1, r + 1)}) out.push_back(v);
        for (const std::uint32_t v : {at(c, r), at(c + 1, r + 1), at(c, r + 1)}) out.push_back(v);
      }
    }
    return out;
  }

  Indices fans() const {
    constexpr int kRing[9][2] = {{-1, -1}, {0, -1}, {1, -1}, {1, 0},  {1, 1},
                                 {0, 1},   {-1, 1}, {-1, 0}, {-1, -1}};
    Indices out;
    for (int r = 1; r < rows_; r += 2) {
      for (int c = 1; c < columns_; c += 2) {
        out.push_back(at(c, r));
        for (const auto& step : kRing) out.push_back(at(c + step[0], r + step[1]));
      }
    }
    return out;
  }

  Indices strips() const {
    Indices out;
    for (int r = 0; r + 1 < rows_; ++r) {
      for (int c = 0; c < columns_; ++c) append({at(c, r + 1), at(c, r)}, out);
    }
    return out;
  }

  /// Rows run to and fro. At each row's end one more index turns the strip, another keeps its orientation.
  Indices degenerate_strip() const {
    Indices out;
    for (int r = 0; r + 1 < rows_; ++r) {
      const bool west = r % 2 == 1;
      for (int k = 0; k < columns_; ++k) {
        const int c = west ? columns_ - 1 - k : k;
        append(west ? std::array{at(c, r), at(c, r + 1)} : std::array{at(c, r + 1), at(c, r)}, out);
      }
      const std::uint32_t turn = at(west ? 0 : columns_ - 1, r + 1);
      append({turn, turn}, out);
    }
    return out;
  }

 private:
  std::uint32_t at(int c, int r) const {
    return static_cast<std::uint32_t>(r) * static_cast<std::uint32_t>(columns_) +
           static_cast<std::uint32_t>(c);
  }
  static void append(const std::array<std::uint32_t, 2>& pair, Indices& out) {
    out.insert(out.end(), pair.begin(), pair.end());
  }

  int columns_;
  int rows_;
};

}  // namespace

IndexCount grid_index_count(IndexForm form, std::int64_t columns, std::int64_t rows) {
  assert(columns >= 2 && rows >= 2);
  const auto n = static_cast<std::uint64_t>(columns), m = static_cast<std::uint64_t>(rows);
  switch (form) {
    case IndexForm::list:
      return {6 * (n - 1) * (m - 1), 1};
    case IndexForm::fan:
      return {5 * (n - 1) * (m - 1) / 2, (n - 1) * (m - 1) / 4};
    case IndexForm::strip:
      return {2 * n * (m - 1), m - 1};
    default:
      return {(2 * n + 2) * (m - 1), 1};
  }
}

std::vector<std::uint32_t> grid_indices(IndexForm form, int columns, int rows) {
  const Grid grid(columns, rows);
  switch (form) {
    case IndexForm::list:
      return grid.list();
    case IndexForm::fan:
      return grid.fans();
    case IndexForm::strip:
      return grid.strips();
    default:
      return grid.degenerate_strip();
  }
}

std::vector<LodTriangle> triangles_of_strip(std::span<const std::uint32_t> strip) {
  std::vector<LodTriangle> triangles;
  for (std::size_t i = 2; i < strip.size(); ++i) {
    const std::uint32_t a = strip[i - 2], b = strip[i - 1], c = strip[i];
    if (a == b || b == c || a == c) continue;
    triangles.push_back(i % 2 == 0 ? LodTriangle{a, b, c} : LodTriangle{b, a, c});
  }
  return triangles;
}

}  // namespace cairn
