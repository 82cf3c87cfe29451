// Formats that come in through OpenImageIO, each against a PNG of the same pixels.
#include <cmath>
#include <string>

#include <OpenImageIO/imageio.h>
#include <catch2/catch.hpp>

#include "cairn/build.h"
#include "tests/support/dem_files.h"
#include "tests/support/gdal_oracle.h"
#include "tests/support/test_data.h"
#include "tests/support/texture_pack.h"

namespace cairn::test {
namespace {

namespace fs = std::filesystem;

constexpr int kColumns = 70, kRows = 50;
const OpenOptions kSomewhere{.bounds = GeoBounds{10, 49.5, 10.7, 50}, .cache_bytes = 1 << 20};

bool has_oiio_reader() {
  for (const RasterFormat* format : raster_formats())
    if (std::string(format->name) == "oiio") return true;
  WARN("SKIPPED, nothing was checked: cairn was built without OpenImageIO");
  return false;
}

template <class T>
void write_image(const fs::path& path, int channels, OIIO::TypeDesc type, const std::vector<T>& pixels,
                 int tile = 0) {
  auto out = OIIO::ImageOutput::create(path.string());
  REQUIRE(out);
  OIIO::ImageSpec spec(kColumns, kRows, channels, type);
  spec.attribute("oiio:UnassociatedAlpha", 1);
  spec.attribute("compression", "lossless");
  if (tile > 0) spec.attribute("compression", "zip");
  spec.tile_width = spec.tile_height = tile;
  REQUIRE(out->open(path.string(), spec));
  REQUIRE(out->write_image(type, pixels.data()));
  REQUIRE(out->close());
}

std::vector<std::uint8_t> colours(int channels) {
  std::vector<std::uint8_t> pixels;
  for (int r = 0; r < kRows; ++r)
    for (int c = 0; c < kColumns; ++c)
      for (int k = 0; k < channels; ++k)
        pixels.push_back(static_cast<std::uint8_t>(k == 3 ? (c < 9 ? 0 : 255) : 3 * c + 2 * r + 20 * k));
  return pixels;
}

}  // namespace

TEST_CASE("BMP, TGA and JPEG 2000 hold the pixels of a PNG of the same picture") {
  if (!has_oiio_reader()) return;
  const TempDir folder;
  const auto pixels = colours(3);
  write_image(folder.path() / "x.png", 3, OIIO::TypeDesc::UINT8, pixels);
  const auto expected = all_colours(*opened(folder.path() / "x.png", kSomewhere));
  for (const char* name : {"x.bmp", "x.tga", "x.jp2"}) {
    INFO(name);
    const fs::path path = folder.path() / name;
    write_image(path, 3, OIIO::TypeDesc::UINT8, pixels);
    const auto source = opened(path, kSomewhere);
    CHECK(source->info().format == "oiio");
    CHECK(source->info().columns == kColumns);
    CHECK(source->info().georeference.x0 == Approx(10.005));
    const auto found = all_colours(*source);
    REQUIRE(found.size() == expected.size());
    int furthest = 0;
    for (std::size_t i = 0; i < found.size(); ++i)
      furthest = std::max(furthest, std::abs(found[i] - expected[i]));
    // OpenImageIO writes JPEG 2000 with losses.
    CHECK(furthest <= (path.extension() == ".jp2" ? 12 : 0));
  }
}

TEST_CASE("a TGA's alpha comes unmultiplied") {
  if (!has_oiio_reader()) return;
  const TempDir folder;
  const auto pixels = colours(4);
  write_image(folder.path() / "x.tga", 4, OIIO::TypeDesc::UINT8, pixels);
  const auto found = all_colours(*opened(folder.path() / "x.tga", kSomewhere));
  for (std::size_t i = 0; i < found.size(); i += 4) {
    REQUIRE(found[i + 3] == pixels[i + 3]);
    if (found[i + 3] != 0) REQUIRE(found[i] == pixels[i]);
  }
}

TEST_CASE("OpenEXR holds heights in their own type, scanlines and tiles, and is no picture") {
  if (!has_oiio_reader()) return;
  const TempDir folder;
  std::vector<float> heights;
  for (int r = 0; r < kRows; ++r)
    for (int c = 0; c < kColumns; ++c) heights.push_back(static_cast<float>(test_height(c, r)) + 0.125F);
  for (const int tile : {0, 16}) {
    const fs::path path = folder.path() / "x.exr";
    write_image(path, 1, OIIO::TypeDesc::FLOAT, heights, tile);
    const auto source = opened(path, kSomewhere);
    CHECK(source->info().type == SampleType::float32);
    CHECK_FALSE(source->info().whole_metres);
    CHECK(all_heights(*source) == heights);
    std::vector<std::uint8_t> rgba(4);
    CHECK_FALSE(source->read_colours({0, 0, 1, 1}, rgba).ok());
  }
}

TEST_CASE(
    "JPEG 2000 by a world file or by --bounds is baked as the PNG is, and one that says its place lies "
    "there") {
  if (!has_oiio_reader()) return;
  const TempDir folder;
  const fs::path jp2 = folder.path() / "x.jp2", png = folder.path() / "x.png";
  write_image(png, 3, OIIO::TypeDesc::UINT8, colours(3));
  write_text(folder.path() / "x.wld", "0.01 0 0 -0.01 10.005 49.995");
  if (!run_gdal("gdal_translate -q -of JP2OpenJPEG -co REVERSIBLE=YES -co QUALITY=100 -co GMLJP2=NO -co "
                "GeoJP2=NO " +
                png.string() + " " + jp2.string()))
    return;
  const auto bake = [&](const fs::path& image, std::optional<GeoBounds> bounds) {
    BuildOptions options;
    options.imagery.inputs = {image};
    options.imagery.bounds = bounds;
    options.grid.tile_size = 257;
    options.session.threads = 1;
    options.session.force = true;
    options.session.target = folder.path() / "a.cairn";
    const auto report = build(options, [](const Progress&) { return true; });
    INFO((report.ok() ? "" : report.error().message));
    REQUIRE(report.ok());
    TexturePack pack(options.session.target);
    std::vector<std::optional<std::array<int, 3>>> seen;
    for (int i = 0; i < 30; ++i) seen.push_back(pack.colour({10.02 + 0.02 * i, 49.98 - 0.015 * i}));
    CHECK(seen.front().has_value());
    return seen;
  };
  const auto expected = bake(png, std::nullopt);
  CHECK(bake(jp2, std::nullopt) == expected);
  fs::remove(folder.path() / "x.wld");
  CHECK(bake(jp2, kSomewhere.bounds) == expected);
  for (const char* own : {"-co GMLJP2=NO -co GeoJP2=YES ", "-co GMLJP2=YES -co GeoJP2=NO "}) {
    REQUIRE(
        run_gdal("gdal_translate -q -of JP2OpenJPEG -co REVERSIBLE=YES -co QUALITY=100 -a_srs EPSG:4326 "
                 "-a_ullr 10 50 10.7 49.5 " +
                 std::string(own) + png.string() + " " + jp2.string()));
    fs::remove(jp2.string() + ".aux.xml");
    CHECK(bake(jp2, GeoBounds{-100, 0, -99, 1}) == expected);
  }
}

TEST_CASE("a damaged image that goes through OpenImageIO is an error of one line") {
  if (!has_oiio_reader()) return;
  const TempDir folder;
  for (const char* name : {"x.bmp", "x.jp2", "x.tga"}) {
    const fs::path path = folder.path() / name;
    write_image(path, 3, OIIO::TypeDesc::UINT8, colours(3));
    const auto whole = read_bytes(path);
    for (const std::size_t cut : {std::size_t{20}, whole.size() / 3}) {
      write_bytes(path, {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(cut)});
      const std::string complaint = complaint_of(path, kSomewhere);
      INFO(name << " cut to " << cut << ": " << complaint);
      CHECK_FALSE(complaint.empty());
      CHECK(complaint.find('\n') == std::string::npos);
    }
  }
}

}  // namespace cairn::test
