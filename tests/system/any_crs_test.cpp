// Posts in any CRS: at every post of the files, at its place by PROJ, the pack has the file's height. Nothing
// of cairn's own placing is used for that.

#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <proj.h>

#include "cairn/pack_reader.h"
#include "cairn/pack_sampler.h"
#include "format/pack_verify.h"
#include "tests/support/dem_files.h"
#include "tests/support/test_bake.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

namespace fs = std::filesystem;

constexpr double kErrorBound = 0.05;

/// A grid of posts: where it is, how it is written in a GeoTIFF, and how large one of its rasters is.
struct Grid {
  const char* name;
  int epsg;
  bool is_geographic;
  double x;  ///< of the first post
  double y;
  double spacing;
  double turn = 0;  ///< degrees, anticlockwise
};

const std::vector<Grid>& national_grids() {
  static const std::vector<Grid> grids = {
      {"OSGB36", 27700, false, 400000, 300000, 50},
      {"LV95, oblique Mercator on Bessel", 2056, false, 2600000, 1200000, 25},
      {"LV03", 21781, false, 600000, 200000, 25},
      {"Lambert-93", 2154, false, 700000, 6600000, 25},
      {"Belgian Lambert 72", 31370, false, 150000, 170000, 20},
      {"RD New, oblique stereographic", 28992, false, 155000, 463000, 25},
      {"Gauss-Krüger 3 on DHDN", 31467, false, 3500000, 5600000, 25},
      {"Krovak, east and north", 5514, false, -700000, -1100000, 20},
      {"NZTM", 2193, false, 1700000, 5500000, 8},
      {"Korea 2000 Central", 5186, false, 200000, 550000, 10},
      {"Timbalai RSO Borneo, Hotine oblique Mercator", 29873, false, 600000, 600000, 30},
      {"Colorado North, US survey feet", 2231, false, 3100000, 1700000, 100},
      {"SWEREF99 TM", 3006, false, 600000, 6600000, 50},
      {"ETRS89 / TM35FIN", 3067, false, 400000, 7000000, 25},
      {"UTM 17N on NAD83(CSRS)", 2958, false, 600000, 4900000, 20},
      {"MGA zone 55", 28355, false, 600000, 6000000, 30},
      {"JGD2011 UTM 54N", 6691, false, 400000, 4000000, 10},
  };
  return grids;
}

const std::vector<Grid>& wide_grids() {
  static const std::vector<Grid> grids = {
      {"LAEA Europe", 3035, false, 4321000, 3210000, 100},
      {"Conus Albers", 5070, false, -1000000, 1900000, 30},
      {"Alaska Albers over 180°", 3338, false, -1157000, 2015000, 200},
      {"polar stereographic north", 3413, false, -400000, -900000, 100},
      {"polar stereographic south", 3031, false, 1000000, -900000, 200},
      {"LAEA north pole, Alaska", 3572, false, 300000, -2000000, 200},
      {"NAD27, degrees", 4267, true, -100, 40, 0.001},
      {"NTF (Paris), grads", 4807, true, 1, 52, 0.001},
  };
  return grids;
}

const std::vector<Grid>& turned_grids() {
  static const std::vector<Grid> grids = {
      {"UTM 32N turned by 20°", 32632, false, 500000, 5200000, 25, 20},
      {"Lambert-93 turned by 45°", 2154, false, 700000, 6600000, 25, 45},
      {"degrees turned by -30°", 4326, true, 10, 50, 0.001, -30},
      {"OSGB36 turned by 180°", 27700, false, 400000, 300000, 50, 180},
  };
  return grids;
}

const std::vector<Grid>& antimeridian_grids() {
  static const std::vector<Grid> grids = {
      {"PDC Mercator over 180°", 3832, false, 3336000, -1850000, 200},
      {"UTM 60S over 180°", 32760, false, 815000, 8000000, 100},
      {"UTM 1N over 180°", 32601, false, 175000, 7200000, 100},
      {"Web Mercator beyond 180°", 3857, false, 20034000, -1850000, 200},
      {"Chatham Islands TM", 3793, false, 3500000, 5100000, 50},
      {"south pole inside", 3031, false, -24000, 20000, 1000},
      {"north pole inside, beside a post", 3413, false, -24300, 19800, 1000},
  };
  return grids;
}

struct Raster {
  std::int64_t column = 0;  ///< of the grid
  int columns = 48;
  double lift = 0;  ///< added to its heights
};

float height_of(std::int64_t column, std::int64_t row) {
  const auto u = static_cast<double>(column), v = static_cast<double>(row);
  const double noise = std::fmod(std::abs(std::sin(u * 12.9898 + v * 78.233) * 43758.5453), 1.0);
  return static_cast<float>(900 + 300 * std::sin(u / 7) * std::cos(v / 5) + 60 * noise);
}

constexpr int kRows = 40;

struct Affine {
  double dx, dy, x_per_row, y_per_column;
};

Affine affine_of(const Grid& grid) {
  const double a = grid.turn * M_PI / 180;
  return {grid.spacing * std::cos(a), -grid.spacing * std::cos(a), grid.spacing * std::sin(a),
          grid.spacing * std::sin(a)};
}

void write_raster(const fs::path& path, const Grid& grid, const Raster& raster, bool is_point) {
  const Affine m = affine_of(grid);
  // The first post, and from it the corner that the file's numbers are of.
  const double first = static_cast<double>(raster.column) - (is_point ? 0 : 0.5), up = is_point ? 0 : -0.5;
  const double x = grid.x + first * m.dx + up * m.x_per_row, y = grid.y + first * m.y_per_column + up * m.dy;
  TiffRecipe recipe;
  recipe.columns = raster.columns;
  recipe.rows = kRows;
  recipe.type = SampleType::float32;
  recipe.keys = {{1024, grid.is_geographic ? 2 : 1},
                 {1025, is_point ? 2 : 1},
                 {grid.is_geographic ? 2048 : 3072, grid.epsg}};
  if (grid.turn == 0) {
    recipe.pixel_scale = {m.dx, -m.dy, 0};
    recipe.tiepoint = {0, 0, 0, x, y, 0};
  } else {
    recipe.pixel_scale.clear();
    recipe.tiepoint.clear();
    recipe.transformation = {m.dx, m.x_per_row, 0, x, m.y_per_column, m.dy, 0, y, 0, 0, 0, 0, 0, 0, 0, 1};
  }
  recipe.sample = [raster](int, std::int64_t c, std::int64_t r) {
    return static_cast<double>(height_of(raster.column + c, r)) + raster.lift;
  };
  write_tiff(path, recipe);
}

/// Places by PROJ alone.
class Proj {
 public:
  explicit Proj(int epsg) {
    const std::string from = "EPSG:" + std::to_string(epsg);
    PJ* any = proj_create_crs_to_crs(context_, from.c_str(), "EPSG:4326", nullptr);
    REQUIRE(any != nullptr);
    operation_ = proj_normalize_for_visualization(context_, any);
    proj_destroy(any);
    REQUIRE(operation_ != nullptr);
  }
  ~Proj() {
    proj_destroy(operation_);
    proj_context_destroy(context_);
  }
  Proj(const Proj&) = delete;
  Proj& operator=(const Proj&) = delete;

  LonLat place_of(double x, double y) const {
    const PJ_COORD at = proj_trans(operation_, PJ_FWD, proj_coord(x, y, 0, HUGE_VAL));
    return {at.xy.x, at.xy.y};
  }

 private:
  PJ_CONTEXT* context_ = proj_context_create();
  PJ* operation_ = nullptr;
};

struct Measured {
  int posts = 0;
  int missing = 0;
  double worst = 0;
};

Measured measure(const fs::path& pack_path, const Grid& grid, const std::vector<Raster>& rasters) {
  const auto pack = PackReader::open(pack_path);
  REQUIRE(pack.ok());
  PackSampler sampler(*pack, 64);
  const Proj proj(grid.epsg);
  const Affine m = affine_of(grid);
  std::map<std::pair<std::int64_t, std::int64_t>, double> expected;
  for (const Raster& raster : rasters) {
    for (std::int64_t c = raster.column; c < raster.column + raster.columns; ++c) {
      for (std::int64_t r = 0; r < kRows; ++r)
        expected.try_emplace(
            {c, r},
            static_cast<double>(static_cast<float>(static_cast<double>(height_of(c, r)) + raster.lift)));
    }
  }
  Measured measured;
  for (const auto& [post, height] : expected) {
    const auto c = static_cast<double>(post.first), r = static_cast<double>(post.second);
    const LonLat place =
        proj.place_of(grid.x + c * m.dx + r * m.x_per_row, grid.y + c * m.y_per_column + r * m.dy);
    const auto found = sampler.height_at(place);
    REQUIRE(found.ok());
    ++measured.posts;
    if (!found->has_value()) {
      ++measured.missing;
    } else {
      measured.worst = std::max(measured.worst, std::abs((*found)->metres - height));
    }
  }
  return measured;
}

void check(const Grid& grid, const char* layout, const std::vector<Raster>& rasters, bool is_point) {
  CAPTURE(grid.name, layout, is_point);
  const TempDir folder;
  std::vector<fs::path> files;
  for (std::size_t i = 0; i < rasters.size(); ++i) {
    files.push_back(folder.path() / (std::to_string(i) + ".tif"));
    write_raster(files.back(), grid, rasters[i], is_point);
  }
  BuildOptions options = bake_options(files, folder.path() / "a.cairn");
  options.grid.tile_size = 257;
  bake(options);
  const Measured measured = measure(options.session.target, grid, rasters);
  CHECK(measured.posts > 0);
  CHECK(measured.missing == 0);
  CHECK(measured.worst <= kErrorBound);
  const auto verified = verify_pack(options.session.target);
  REQUIRE(verified.ok());
  for (const Finding& finding : verified->findings) FAIL_CHECK(finding.where << ": " << finding.what);
}

void check_layouts(const std::vector<Grid>& grids) {
  for (const Grid& grid : grids) {
    for (const bool is_point : {false, true}) {
      check(grid, "one file", {{0, 48, 0}}, is_point);
      check(grid, "touching", {{0, 24, 0}, {24, 24, 0}}, is_point);
      check(grid, "overlapping", {{0, 28, 0}, {20, 28, 7}}, is_point);
      check(grid, "with a gap", {{0, 20, 0}, {27, 21, 0}}, is_point);
    }
  }
}

}  // namespace

TEST_CASE("every post of rasters in national grids is within the error bound at its place by PROJ") {
  check_layouts(national_grids());
}
TEST_CASE(
    "every post of rasters in polar and continental CRSs is within the error bound at its place by PROJ") {
  check_layouts(wide_grids());
}
TEST_CASE("every post of turned rasters is within the error bound at its place by PROJ") {
  check_layouts(turned_grids());
}
TEST_CASE("every post of rasters over 180° or a pole is within the error bound at its place by PROJ") {
  check_layouts(antimeridian_grids());
}

}  // namespace cairn::test
