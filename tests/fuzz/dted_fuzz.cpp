// Any bytes are opened as DTED.
#include <algorithm>

#include <catch2/catch.hpp>

#include "tests/support/dem_files.h"
#include "tests/support/fuzz.h"
#include "tests/support/raster_fuzz.h"

namespace cairn::test {
namespace {

void dted(std::span<const std::byte> input) {
  open_and_read("dted", "n19.dt1", input);
}

}  // namespace

TEST_CASE("no bytes make reading DTED crash") {
  const Bytes cell = dted_bytes({.columns = 21, .rows = 31});
  Bytes labelled(160 + cell.size(), std::byte{' '});
  std::copy(cell.begin(), cell.end(), labelled.begin() + 160);
  for (const auto& [at, text] : {std::pair{std::size_t{0}, "VOL"}, {std::size_t{80}, "HDR"}})
    for (std::size_t i = 0; i < 3; ++i) labelled[at + i] = static_cast<std::byte>(text[i]);
  run_fuzz("dted", dted, {cell, labelled}, 5000);
}

}  // namespace cairn::test
