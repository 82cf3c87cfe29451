#include <algorithm>
#include <array>
#include <set>

#include <catch2/catch.hpp>

#include "runtime/lod/mesh/index_forms.h"

namespace cairn {
namespace {

TEST_CASE("Index counts of a grid of 1025 vertices a side are those of the published table") {
  const auto count = [](IndexForm form) { return grid_index_count(form, 1025, 1025); };
  const auto mebibytes = [&](IndexForm form) {
    return static_cast<double>(4 * count(form).indices) / (1024 * 1024);
  };
  CHECK(count(IndexForm::list).indices == 6291456);
  CHECK(mebibytes(IndexForm::list) == 24);
  CHECK(count(IndexForm::list).parts == 1);
  CHECK(mebibytes(IndexForm::fan) == 10);
  CHECK(count(IndexForm::fan).parts == 262144);
  CHECK(mebibytes(IndexForm::strip) == Approx(8.008).margin(0.0005));
  CHECK(count(IndexForm::strip).parts == 1024);
  CHECK(mebibytes(IndexForm::degenerate_strip) == Approx(8.016).margin(0.0005));
  CHECK(count(IndexForm::degenerate_strip).parts == 1);
}

TEST_CASE("The indices that a grid is drawn with are as many as counted") {
  for (const auto [columns, rows] : {std::array{3, 3}, {5, 9}, {17, 3}}) {
    for (const IndexForm form : kIndexForms) {
      CHECK(grid_indices(form, columns, rows).size() == grid_index_count(form, columns, rows).indices);
    }
  }
}

TEST_CASE("A strip with degenerate triangles covers each cell once, and every triangle faces up") {
  const int columns = 6, rows = 5;
  std::set<std::array<std::uint32_t, 3>> seen;
  int doubled_area = 0;
  for (LodTriangle t : triangles_of_strip(grid_indices(IndexForm::degenerate_strip, columns, rows))) {
    const auto x = [&](std::size_t i) { return static_cast<int>(t[i]) % columns; };
    const auto y = [&](std::size_t i) { return static_cast<int>(t[i]) / columns; };
    const int area = (x(1) - x(0)) * (y(2) - y(0)) - (x(2) - x(0)) * (y(1) - y(0));
    CHECK(area == 1);
    doubled_area += area;
    std::sort(t.begin(), t.end());
    CHECK(seen.insert(t).second);
  }
  CHECK(doubled_area == 2 * (columns - 1) * (rows - 1));
}

}  // namespace
}  // namespace cairn
