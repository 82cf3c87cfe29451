// Orthoimages in any CRS that touch: between them, as PROJ places them, no texel is left open.

#include <cmath>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <proj.h>

#include "builder/imagery/imagery_mosaic.h"
#include "tests/support/dem_files.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

namespace fs = std::filesystem;

constexpr int kImages = 3;  ///< along each side
constexpr int kPixels = 40;
constexpr int kTexels = 256;

struct Layout {
  const char* name;
  int epsg;
  bool is_geographic;
  double x;  ///< of the north-western corner of all
  double y;
  double pixel;
  double turn = 0;  ///< degrees, anticlockwise
};

struct Affine {
  double dx, dy, x_per_row, y_per_column;
};

Affine affine_of(const Layout& layout) {
  const double a = layout.turn * M_PI / 180;
  return {layout.pixel * std::cos(a), -layout.pixel * std::cos(a), layout.pixel * std::sin(a),
          layout.pixel * std::sin(a)};
}

std::vector<fs::path> write_images(const fs::path& folder, const Layout& layout) {
  const Affine m = affine_of(layout);
  std::vector<fs::path> paths;
  for (int row = 0; row < kImages; ++row) {
    for (int column = 0; column < kImages; ++column) {
      const double c = column * kPixels, r = row * kPixels;
      TiffRecipe recipe;
      recipe.columns = recipe.rows = kPixels;
      recipe.bands = 3;
      recipe.type = SampleType::uint8;
      recipe.photometric = 2;
      recipe.pixel_scale.clear();
      recipe.tiepoint.clear();
      recipe.transformation = {m.dx,
                               m.x_per_row,
                               0,
                               layout.x + c * m.dx + r * m.x_per_row,
                               m.y_per_column,
                               m.dy,
                               0,
                               layout.y + c * m.y_per_column + r * m.dy,
                               0,
                               0,
                               0,
                               0,
                               0,
                               0,
                               0,
                               1};
      recipe.keys = {
          {1024, layout.is_geographic ? 2 : 1}, {1025, 1}, {layout.is_geographic ? 2048 : 3072, layout.epsg}};
      recipe.sample = [=](int, std::int64_t, std::int64_t) { return 60.0 + 20 * column + 30 * row; };
      paths.push_back(folder / (std::to_string(row) + std::to_string(column) + ".tif"));
      write_tiff(paths.back(), recipe);
    }
  }
  return paths;
}

/// Where a place lies in the layout, in pixels from its corner, by PROJ alone.
class PixelsByProj {
 public:
  explicit PixelsByProj(const Layout& layout) : layout_(layout) {
    const std::string crs = "EPSG:" + std::to_string(layout.epsg);
    PJ* any = proj_create_crs_to_crs(context_, crs.c_str(), "EPSG:4326", nullptr);
    REQUIRE(any != nullptr);
    operation_ = proj_normalize_for_visualization(context_, any);
    proj_destroy(any);
  }
  ~PixelsByProj() {
    proj_destroy(operation_);
    proj_context_destroy(context_);
  }
  PixelsByProj(const PixelsByProj&) = delete;
  PixelsByProj& operator=(const PixelsByProj&) = delete;

  bool is_inside(double lon, double lat) const {
    const PJ_COORD at = proj_trans(operation_, PJ_INV, proj_coord(lon, lat, 0, HUGE_VAL));
    const Affine m = affine_of(layout_);
    const double determinant = m.dx * m.dy - m.x_per_row * m.y_per_column;
    const double x = at.xy.x - layout_.x, y = at.xy.y - layout_.y;
    const double c = (x * m.dy - y * m.x_per_row) / determinant,
                 r = (y * m.dx - x * m.y_per_column) / determinant;
    const double end = kImages * kPixels - 1.0;
    return c > 1 && r > 1 && c < end && r < end;
  }

 private:
  Layout layout_;
  PJ_CONTEXT* context_ = proj_context_create();
  PJ* operation_ = nullptr;
};

}  // namespace

TEST_CASE("orthoimages that touch, in any CRS, leave no texel open between them") {
  const std::vector<Layout> layouts = {
      {"LV95", 2056, false, 2600000, 1200000, 1},
      {"OSGB36", 27700, false, 400000, 300000, 10},
      {"Colorado North, feet", 2231, false, 3100000, 1700000, 3},
      {"UTM 32N turned by 20°", 32632, false, 500000, 5200000, 5, 20},
      {"PDC Mercator over 180°", 3832, false, 3336000, -1850000, 100},
      {"UTM 60S over 180°", 32760, false, 815000, 8000000, 50},
      {"degrees", 4326, true, 10, 50, 0.001},
      {"polar stereographic north, pole inside", 3413, false, -61000, 59000, 1000},
  };
  for (const Layout& layout : layouts) {
    CAPTURE(layout.name);
    const TempDir folder;
    ImageryOptions options;
    options.inputs = write_images(folder.path(), layout);
    const auto mosaic = ImageryMosaic::open(options, kTexels);
    INFO((mosaic.ok() ? "" : mosaic.error().message));
    REQUIRE(mosaic.ok());
    const PixelsByProj pixels(layout);
    const int level = (*mosaic)->finest_level();
    const GeoBounds bounds = (*mosaic)->bounds();
    const double width = tile_width_degrees(level);
    int inside = 0, open = 0;
    for (double south = std::floor((bounds.south + 90) / width); south * width - 90 < bounds.north; ++south) {
      for (double west = std::floor((bounds.west + 180) / width); west * width - 180 < bounds.east; ++west) {
        const double around = 360 / width;
        const TileId id{static_cast<std::int8_t>(level),
                        static_cast<std::int32_t>(west - around * std::floor(west / around)),
                        static_cast<std::int32_t>(south)};
        if (!(*mosaic)->native_level(id)) continue;
        const TexelWindow window = texels_of(id, kTexels, 0);
        const auto image = (*mosaic)->sample(window);
        REQUIRE(image.ok());
        for (int r = 0; r < kTexels; ++r) {
          for (int c = 0; c < kTexels; ++c) {
            if (std::abs(window.lat_of(r)) > 90 || !pixels.is_inside(window.lon_of(c), window.lat_of(r)))
              continue;
            ++inside;
            if (image->row(r)[c][3] != 65535) ++open;
          }
        }
      }
    }
    CHECK(inside > 5000);
    CHECK(open == 0);
  }
}

}  // namespace cairn::test
