#include <cmath>

#include <catch2/catch.hpp>

#include "tests/support/dem_files.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

namespace fs = std::filesystem;

int with_voids(std::int64_t column, std::int64_t row) {
  return (column + row) % 97 == 0 ? -32768 : test_height(column, row);
}

void check_posts(const RasterSource& source, int posts) {
  const auto heights = all_heights(source);
  bool equal = true;
  for (int r = 0; r < posts; ++r)
    for (int c = 0; c < posts; ++c) {
      const float h = heights[static_cast<std::size_t>(r * posts + c)];
      const int expected = with_voids(c, r);
      equal = equal && (expected == -32768 ? std::isnan(h) : h == static_cast<float>(expected));
    }
  CHECK(equal);
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("An hgt cell reads the same plain, gzipped, and zipped stored or deflated") {
  const TempDir folder;
  const Bytes plain = hgt_bytes(1201, with_voids);
  write_bytes(folder.path() / "S02E036.hgt", plain);
  write_bytes(folder.path() / "s02e036.hgt.gz", gzipped(plain));
  write_bytes(folder.path() / "S02E036.hgt.zip", zipped({{"readme.txt", Bytes(10)}, {"S02E036.hgt", plain}}));
  write_bytes(folder.path() / "download.zip", zipped({{"S02E036.hgt", plain, false}}));
  write_bytes(folder.path() / "S02E036.SRTMGL3.hgt.zip", zipped({{"posts.hgt", plain}}));
  for (const auto& entry : fs::directory_iterator(folder.path())) {
    INFO(entry.path());
    for (const std::size_t cache : {std::size_t{1} << 10, std::size_t{32} << 20}) {
      const auto source = opened(entry.path(), {.bounds = {}, .cache_bytes = cache});
      const RasterInfo& info = source->info();
      CHECK(info.format == "hgt");
      CHECK(info.whole_metres);
      CHECK(info.bounds.west == 36);
      CHECK(info.bounds.south == -2);
      CHECK(info.bounds.east == 37);
      CHECK(info.bounds.north == -1);
      check_posts(*source, 1201);
    }
  }
}

TEST_CASE("A one-second hgt cell has 3601 posts a side") {
  const TempDir folder;
  write_bytes(folder.path() / "N00W180.hgt", hgt_bytes(3601));
  const auto source = opened(folder.path() / "N00W180.hgt");
  CHECK(source->info().columns == 3601);
  CHECK(source->info().georeference.place_of(3600, 3600).lon == -179);
  CHECK(source->info().georeference.place_of(3600, 3600).lat == Approx(0).margin(1e-15));
  float h = 0;
  REQUIRE(source->read_heights({3600, 1800, 1, 1}, {&h, 1}).ok());
  CHECK(h == static_cast<float>(test_height(3600, 1800)));
}

TEST_CASE("An hgt cell of 1\" from 50° of latitude has every second meridian") {
  const TempDir folder;
  Bytes bytes(static_cast<std::size_t>(2) * 1801 * 3601);
  bytes[2 * 1801 + 2 * 7] = std::byte{1};  // column 7 of the second row: 256 m
  write_bytes(folder.path() / "N61E010.hgt", bytes);
  const auto source = opened(folder.path() / "N61E010.hgt");
  CHECK(source->info().columns == 1801);
  CHECK(source->info().rows == 3601);
  CHECK(source->info().georeference.place_of(1800, 3600).lon == Approx(11).margin(1e-12));
  CHECK(source->info().georeference.place_of(1800, 3600).lat == Approx(61).margin(1e-12));
  float h = 0;
  REQUIRE(source->read_heights({7, 1, 1, 1}, {&h, 1}).ok());
  CHECK(h == 256);
}

TEST_CASE("An hgt whose name or size lies is refused in one line that says what was expected") {
  const TempDir folder;
  const Bytes plain = hgt_bytes(1201);
  for (const char* name : {"N90E000.hgt", "S91E000.hgt", "N00E180.hgt", "N00W181.hgt", "relief.hgt",
                           "N1E2.hgt", "N51E0000.hgt"}) {
    write_bytes(folder.path() / name, plain);
    INFO(name);
    CHECK(contains(complaint_of(folder.path() / name), "expected a cell such as N36E028"));
  }
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{2884800}, std::size_t{2884803},
                                 std::size_t{2 * 1801 * 1801}, std::size_t{2 * 3601 * 1802}}) {
    write_bytes(folder.path() / "N36E028.hgt", Bytes(size));
    INFO(size);
    const std::string complaint = complaint_of(folder.path() / "N36E028.hgt");
    CHECK(contains(complaint, "1201×1201"));
    CHECK(contains(complaint, "found " + std::to_string(size)));
  }
  write_bytes(folder.path() / "N36E028.hgt.zip", zipped({{"N37E028.hgt", plain}}));
  CHECK(contains(complaint_of(folder.path() / "N36E028.hgt.zip"), "N37E028.hgt"));
  write_bytes(folder.path() / "N36E028.hgt.zip", zipped({{"N36E028.hgt", plain}, {"N36E029.hgt", plain}}));
  CHECK(contains(complaint_of(folder.path() / "N36E028.hgt.zip"), "several"));
  write_bytes(folder.path() / "N36E028.hgt.zip", zipped({{"N36E028.txt", plain}}));
  CHECK(contains(complaint_of(folder.path() / "N36E028.hgt.zip"), "found none"));
}

TEST_CASE("An hgt of the right size that holds no heights is refused when it is read") {
  const TempDir folder;
  const auto path = folder.path() / "N36E028.hgt";
  write_bytes(path, hgt_bytes(1201, [](std::int64_t c, std::int64_t r) {
                return static_cast<int>((c * 40503 + r * 30011) * 2654435761 >> 7 & 0xFFFF);
              }));
  CHECK(contains(complaint_of(path), "expected heights"));
  const auto swapped = [](std::int64_t c, std::int64_t r) {
    return (test_height(c, r) & 255) << 8 | test_height(c, r) >> 8;
  };
  write_bytes(path, hgt_bytes(1201, swapped));
  CHECK(contains(complaint_of(path), "expected heights"));
  write_bytes(path, hgt_bytes(1201, [](std::int64_t, std::int64_t) { return -32768; }));
  CHECK(complaint_of(path).empty());
}

TEST_CASE("A packed hgt cut anywhere is refused, and so is one with damage inside") {
  const TempDir folder;
  const Bytes plain = hgt_bytes(1201);
  for (const auto& [name, whole] :
       {std::pair{"N36E028.hgt.gz", gzipped(plain)}, {"N36E028.hgt.zip", zipped({{"N36E028.hgt", plain}})}}) {
    const auto path = folder.path() / name;
    for (std::size_t cut :
         {std::size_t{0}, std::size_t{1}, std::size_t{10}, std::size_t{17}, std::size_t{18}, std::size_t{30},
          std::size_t{100}, whole.size() / 2, whole.size() - 23, whole.size() - 9, whole.size() - 1}) {
      INFO(name << " cut to " << cut);
      write_bytes(path, Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(cut)));
      CHECK_FALSE(complaint_of(path).empty());
    }
    Bytes damaged = whole;
    damaged[whole.size() / 2] ^= std::byte{0x10};
    write_bytes(path, damaged);
    CHECK_FALSE(complaint_of(path).empty());
    write_bytes(path, whole);
    CHECK(complaint_of(path).empty());
  }
}

}  // namespace cairn::test
