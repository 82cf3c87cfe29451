// Any bytes are opened as an .hgt, plain, gzipped or zipped.
#include <catch2/catch.hpp>

#include "tests/support/dem_files.h"
#include "tests/support/fuzz.h"
#include "tests/support/raster_fuzz.h"

namespace cairn::test {
namespace {

int steps(std::int64_t column, std::int64_t row) {
  return static_cast<int>(100 + row / 100 + column / 300);
}

void zip(std::span<const std::byte> input) {
  open_and_read("hgt", "N36E028.hgt.zip", input);
}

void gzip(std::span<const std::byte> input) {
  open_and_read("hgt", "N36E028.hgt.gz", input);
}

void plain(std::span<const std::byte> input) {
  open_and_read("hgt", "N36E028.hgt", input);
}

}  // namespace

TEST_CASE("no bytes make reading an hgt crash, packed or plain") {
  const Bytes cell = hgt_bytes(1201, steps);
  run_fuzz("hgt_zip", zip,
           {zipped({{"N36E028.hgt", cell}}), zipped({{"a.txt", Bytes(9)}, {"N36E028.hgt", cell}})}, 1500);
  run_fuzz("hgt_gzip", gzip, {gzipped(cell)}, 700);
  run_fuzz("hgt", plain, {cell, Bytes(100)}, 100);
}

}  // namespace cairn::test
