// RasterPool over many small rasters and a large one: right posts in every window, few files open at a time.

#include "builder/raster/raster_pool.h"

#include <filesystem>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include <catch2/catch.hpp>
#include <fmt/format.h>

#include "tests/support/dem_files.h"
#include "tests/support/test_data.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr int kFiles = 150;
constexpr int kSide = 24;
constexpr std::size_t kCacheBytes = std::size_t{1} << 20;  // too little for the posts of all

double height_of(int file, std::int64_t column, std::int64_t row) {
  return 10 * file + test::test_height(column, row) % 7;
}

/// Small files, and a last one that is not read whole.
std::vector<fs::path> write_files(const fs::path& folder) {
  std::vector<fs::path> paths;
  for (int f = 0; f <= kFiles; ++f) {
    test::TiffRecipe recipe;
    recipe.columns = recipe.rows = f < kFiles ? kSide : 12 * kSide;
    recipe.compression = 8;
    recipe.sample = [f](int, std::int64_t column, std::int64_t row) { return height_of(f, column, row); };
    paths.push_back(folder / fmt::format("{:03}.tif", f));
    test::write_tiff(paths.back(), recipe);
  }
  return paths;
}

int wrong_posts(RasterPool& pool, int file, const PostWindow& window) {
  std::vector<float> read(static_cast<std::size_t>(window.columns * window.rows));
  if (!pool.read_heights(static_cast<std::size_t>(file), window, read)) return static_cast<int>(read.size());
  int wrong = 0;
  for (std::int64_t r = 0; r < window.rows; ++r) {
    for (std::int64_t c = 0; c < window.columns; ++c) {
      const double expected = height_of(file, window.column + c, window.row + r);
      wrong += static_cast<double>(read[static_cast<std::size_t>(r * window.columns + c)]) != expected;
    }
  }
  return wrong;
}

std::ptrdiff_t open_descriptors() {
  return std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator());
}

}  // namespace

TEST_CASE("a pool gives the posts of many files, by any thread, with few of them open") {
  const test::TempDir dir;
  const std::vector<fs::path> paths = write_files(dir.path());
  const std::ptrdiff_t before = open_descriptors();
  const auto pool = RasterPool::open(paths, {{}, kCacheBytes}, RasterPool::Content::heights);
  REQUIRE(pool.ok());
  REQUIRE((*pool)->size() == paths.size());
  CHECK((*pool)->info(7).path == paths[7]);
  std::vector<int> wrong(4);
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < wrong.size(); ++t) {
    threads.emplace_back([&, t] {
      const auto shift = static_cast<std::int64_t>(t);
      for (int f = 0; f <= kFiles; ++f) wrong[t] += wrong_posts(**pool, f, {shift, 2 * shift, 13, 11});
      for (int f = kFiles; f >= 0; --f) wrong[t] += wrong_posts(**pool, f, {0, 0, kSide, kSide - shift});
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(wrong == std::vector<int>(4));
  CHECK(open_descriptors() <= before + 16);
  (*pool)->close();
  CHECK(open_descriptors() == before);
  CHECK(wrong_posts(**pool, 3, {1, 1, 5, 5}) == 0);
}

TEST_CASE("a pool names the first file that cannot be opened, and one that is damaged when it is read") {
  const test::TempDir dir;
  std::vector<fs::path> paths = write_files(dir.path());
  test::write_text(paths[40], "no raster");
  test::write_text(paths[90], "nor this");
  const auto refused = RasterPool::open(paths, {{}, kCacheBytes}, RasterPool::Content::heights);
  REQUIRE_FALSE(refused.ok());
  CHECK(refused.error().message.starts_with(paths[40].string()));
  paths.erase(paths.begin() + 90);
  paths.erase(paths.begin() + 40);
  const auto pool = RasterPool::open(paths, {{}, kCacheBytes}, RasterPool::Content::heights);
  REQUIRE(pool.ok());
  fs::resize_file(paths[20], 300);
  std::vector<float> read(4);
  const Status status = (*pool)->read_heights(20, {0, 0, 2, 2}, read);
  REQUIRE_FALSE(status.ok());
  CHECK(status.error().message.starts_with(paths[20].string()));
}

}  // namespace cairn
