#include <cmath>
#include <cstring>

#include <catch2/catch.hpp>

#include "tests/support/dem_files.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

int deep_and_void(std::int64_t column, std::int64_t row) {
  if ((column * 3 + row) % 29 == 0) return -32767;
  return test_height(column, row) - 2500;
}

void check_all(const RasterSource& source, const DtedRecipe& recipe) {
  const auto heights = all_heights(source);
  bool equal = true;
  for (int r = 0; r < recipe.rows; ++r)
    for (int c = 0; c < recipe.columns; ++c) {
      const float h = heights[static_cast<std::size_t>(r * recipe.columns + c)];
      const int expected = recipe.height(c, r);
      equal = equal && (expected == -32767 ? std::isnan(h) : h == static_cast<float>(expected));
    }
  CHECK(equal);
}

}  // namespace

TEST_CASE("DTED posts lie where the header says, at every latitude's spacing, below the sea too") {
  const TempDir folder;
  const auto path = folder.path() / "x.dt1";
  for (const DtedRecipe& recipe : {DtedRecipe{-156, 19, 121, 121, 300, 300, false, deep_and_void},
                                   DtedRecipe{7, -52, 61, 121, 600, 300, false, deep_and_void},
                                   DtedRecipe{179, 84, 21, 121, 1800, 300, false, deep_and_void},
                                   DtedRecipe{-180, -90, 40, 7, 300, 300, false, deep_and_void}}) {
    write_bytes(path, dted_bytes(recipe));
    const auto source = opened(path);
    const RasterInfo& info = source->info();
    CHECK(info.format == "dted");
    CHECK(info.bounds.west == recipe.lon);
    CHECK(info.bounds.south == Approx(recipe.lat).margin(1e-12));
    CHECK(info.georeference.dx == Approx(recipe.lon_interval / 36000.0));
    CHECK(info.georeference.dy == Approx(-recipe.lat_interval / 36000.0));
    check_all(*source, recipe);
    std::vector<float> window(12);
    REQUIRE(source->read_heights({3, 2, 4, 3}, window).ok());
    CHECK(window[11] == static_cast<float>(recipe.height(6, 4)));
  }
}

TEST_CASE("DTED says by its identification what its heights and its places are measured from") {
  const TempDir folder;
  const auto path = folder.path() / "x.dt0";
  const auto with_datums = [&](const std::string& vertical, const std::string& horizontal) {
    Bytes bytes = dted_bytes({});
    const std::string datums = vertical + horizontal;
    std::memcpy(bytes.data() + 80, "DSI", 3);
    std::memcpy(bytes.data() + 80 + 141, datums.data(), datums.size());
    write_bytes(path, bytes);
    return opened(path)->info();
  };
  const RasterInfo egm96 = with_datums("E96", "WGS84");
  REQUIRE(egm96.vertical);
  CHECK(egm96.vertical->datum == VerticalDatum::egm96);
  CHECK(egm96.georeference.crs == Georeference::Crs::geographic);
  CHECK_FALSE(with_datums("MSL", "WGS84").vertical);
  // Between the two datums longitudes are turned by 0.554 seconds of arc (DMA TR 8350.2-B, 1987).
  const RasterInfo wgs72 = with_datums("MSL", "WGS72");
  CHECK(wgs72.georeference.place_of(0, 0).lon - egm96.georeference.place_of(0, 0).lon ==
        Approx(0.554 / 3600).margin(2e-6));
}

TEST_CASE("DTED heights in two's complement read as what they mean") {
  const TempDir folder;
  DtedRecipe recipe;
  recipe.twos_complement = true;
  recipe.height = [](std::int64_t c, std::int64_t r) {
    return c == 0 ? test_height(c, r) : -20 - static_cast<int>(r);
  };
  write_bytes(folder.path() / "x.dt0", dted_bytes(recipe));
  check_all(*opened(folder.path() / "x.dt0"), recipe);
}

TEST_CASE("A DTED record with a wrong checksum is refused, naming the column") {
  const TempDir folder;
  const auto path = folder.path() / "x.dt1";
  const DtedRecipe recipe;
  Bytes bytes = dted_bytes(recipe);
  const std::size_t record = 8 + 2 * 121 + 4;
  bytes[3428 + 57 * record + 100] ^= std::byte{1};
  write_bytes(path, bytes);
  const std::string complaint = complaint_of(path);
  CHECK(complaint.find("column 57") != std::string::npos);
  CHECK(complaint.find("checksum") != std::string::npos);
  float h = 0;
  CHECK(opened(path)->read_heights({56, 5, 1, 1}, {&h, 1}).ok());
}

TEST_CASE("DTED files cut short, or with a header that says nonsense, are refused") {
  const TempDir folder;
  const auto path = folder.path() / "x.dt1";
  const Bytes whole = dted_bytes({});
  for (const std::size_t cut : {std::size_t{3}, std::size_t{4}, std::size_t{79}, std::size_t{80},
                                std::size_t{3427}, std::size_t{3428}, whole.size() / 2, whole.size() - 1}) {
    INFO(cut);
    write_bytes(path, Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(cut)));
    CHECK_FALSE(complaint_of(path).empty());
  }
  for (const auto& [at, text] : {std::pair{4, "2000000E"},
                                 {4, "15X0000W"},
                                 {12, "0916000N"},
                                 {12, "0990000N"},
                                 {20, "0000"},
                                 {24, "    "},
                                 {47, "0000"},
                                 {51, "9999"}}) {
    Bytes bytes = whole;
    for (std::size_t i = 0; text[i] != 0; ++i)
      bytes[static_cast<std::size_t>(at) + i] = static_cast<std::byte>(text[i]);
    INFO(text);
    write_bytes(path, bytes);
    const std::string complaint = complaint_of(path);
    CHECK(complaint.find("expected") != std::string::npos);
    CHECK(complaint.find('\n') == std::string::npos);
  }
}

}  // namespace cairn::test
