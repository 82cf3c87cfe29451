// Every raster of the data folder opens, lies where GDAL puts it, and holds the heights that GDAL reads.
#include <cmath>
#include <random>

#include <catch2/catch.hpp>

#include "builder/raster/expand_inputs.h"
#include "builder/raster/raster_source.h"
#include "tests/support/gdal_oracle.h"
#include "tests/support/test_data.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> rasters_in(const fs::path& folder) {
  const std::vector<std::string> arguments{folder.string()};
  const auto files = expand_inputs(arguments);
  REQUIRE(files.ok());
  return files->files;
}

std::vector<test::Post> some_posts(const RasterInfo& info, unsigned seed) {
  std::mt19937_64 random(seed);
  const std::int64_t c = info.columns - 1, r = info.rows - 1;
  std::vector<test::Post> posts{{0, 0}, {c, 0}, {0, r}, {c, r}};
  while (posts.size() < 200)
    posts.push_back({static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(info.columns)),
                     static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(info.rows))});
  return posts;
}

float height_at(const RasterSource& source, test::Post post) {
  float height = 0;
  const Status read = source.read_heights({post.column, post.row, 1, 1}, {&height, 1});
  if (!read) FAIL(read.error().message);
  return height;
}

bool is_void_to_gdal(const RasterInfo& info, double value) {
  return std::isnan(value) || value == -32768 || value == -32767 || value == -9999 || std::abs(value) > 1e6 ||
         (info.nodata && value == *info.nodata);
}

void compare_with_gdal(const fs::path& path, const std::string& gdal_name) {
  INFO(path);
  const auto source = open_raster(path, {});
  if (!source) FAIL(source.error().message);
  const RasterInfo& info = (*source)->info();
  const auto posts = some_posts(info, 7);
  const auto values = test::gdal_values(gdal_name, posts);
  const auto place = test::gdal_georeference(gdal_name);
  if (!values || !place) return;
  const Georeference& g = info.georeference;
  CHECK(g.x0 == Approx((*place)[0]).margin(1e-6 * std::abs(g.dx)));
  CHECK(g.y0 == Approx((*place)[1]).margin(1e-6 * std::abs(g.dy)));
  CHECK(g.dx == Approx((*place)[2]).epsilon(1e-9));
  CHECK(g.dy == Approx((*place)[3]).epsilon(1e-9));
  REQUIRE(values->size() == posts.size());
  for (std::size_t i = 0; i < posts.size(); ++i) {
    const float height = height_at(**source, posts[i]);
    INFO(posts[i].column << " " << posts[i].row << " " << (*values)[i]);
    CHECK(std::isnan(height) == is_void_to_gdal(info, (*values)[i]));
    if (!std::isnan(height)) CHECK(height == static_cast<float>((*values)[i]));
  }
}

}  // namespace

TEST_CASE("Real DEMs lie where GDAL puts them and hold the heights that it reads", "[data]") {
  const auto data = test::real_data();
  if (!data) return;
  for (const char* folder : {"srtm3", "srtm1", "dted1", "geotiff", "utm", "global", "geoid"}) {
    for (const fs::path& path : rasters_in(*data / folder)) {
      std::string name = path.string();
      if (path.extension() == ".zip") name = "/vsizip/" + name + "/" + path.stem().string();
      compare_with_gdal(path, name);
    }
  }
}

}  // namespace cairn
