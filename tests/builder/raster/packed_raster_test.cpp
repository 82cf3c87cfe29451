// Rasters of any format in gzip files and zip archives.
#include <cstdlib>

#include <catch2/catch.hpp>

#include "builder/raster/expand_inputs.h"
#include "tests/support/dem_files.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

namespace fs = std::filesystem;

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

Bytes tiff_bytes(const TiffRecipe& recipe = {}) {
  const TempDir folder;
  write_tiff(folder.path() / "t.tif", recipe);
  return read_bytes(folder.path() / "t.tif");
}

Bytes bytes_of(const std::string& text) {
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

/// What macOS adds to each archive.
ZipMember resource_fork(const std::string& name) {
  return {"__MACOSX/._" + name, bytes_of(std::string("\0\5\x16\7", 4) + std::string(200, '\0'))};
}

std::size_t unpacked_folders() {
  std::size_t count = 0;
  for (const auto& entry : fs::directory_iterator(fs::temp_directory_path()))
    count += entry.path().filename().string().starts_with("cairn-unpacked-") ? 1 : 0;
  return count;
}

}  // namespace

TEST_CASE("a GeoTIFF and a DTED read the same packed as plain, and nothing is left in the temporary folder") {
  const TempDir folder, temporary;
  ::setenv("TMPDIR", temporary.path().c_str(), 1);
  const Bytes tiff = tiff_bytes(), dted = dted_bytes({});
  const std::vector<std::tuple<std::string, Bytes, std::string, Bytes>> files{
      {"a.tif", tiff, "a.tif.gz", gzipped(tiff)},
      {"b.tif", tiff, "b.zip",
       zipped({{"readme.txt", Bytes(9)}, {"data/B.TIF", tiff}, resource_fork("B.TIF")})},
      {"c.dt1", dted, "c.dt1.gz", gzipped(dted)},
      {"d.dt1", dted, "d.ZIP", zipped({{"d.dt1", dted, false}})}};
  for (const auto& [plain, plain_bytes, packed, packed_bytes] : files) {
    INFO(packed);
    write_bytes(folder.path() / plain, plain_bytes);
    write_bytes(folder.path() / packed, packed_bytes);
    {
      const auto one = opened(folder.path() / plain), other = opened(folder.path() / packed);
      CHECK(other->info().path == folder.path() / packed);
      CHECK(other->info().format == one->info().format);
      CHECK(other->info().bounds.west == one->info().bounds.west);
      CHECK(all_heights(*other) == all_heights(*one));
    }
    CHECK(unpacked_folders() == 0);
  }
  ::unsetenv("TMPDIR");
}

TEST_CASE("an archive from macOS has one .hgt") {
  const TempDir folder;
  const Bytes cell = hgt_bytes(1201);
  write_bytes(folder.path() / "N36E028.hgt.zip",
              zipped({{"N36E028.hgt", cell}, resource_fork("N36E028.hgt")}));
  CHECK(opened(folder.path() / "N36E028.hgt.zip")->info().columns == 1201);
}

TEST_CASE("a packed image takes the world file beside it, in the archive or in the folder") {
  const TempDir folder;
  TiffRecipe recipe;
  recipe.pixel_scale = {};
  recipe.tiepoint = {};
  recipe.keys = {};
  const Bytes tiff = tiff_bytes(recipe);
  const std::string world = "0.01\n0\n0\n-0.01\n10.005\n49.995\n";
  write_bytes(folder.path() / "a.zip", zipped({{"x/a.tif", tiff}, {"x/a.tfw", bytes_of(world)}}));
  write_bytes(folder.path() / "b.tif.gz", gzipped(tiff));
  CHECK_FALSE(complaint_of(folder.path() / "b.tif.gz").empty());
  write_text(folder.path() / "b.tfw", world);
  for (const char* name : {"a.zip", "b.tif.gz"}) {
    INFO(name);
    CHECK(opened(folder.path() / name)->info().bounds.west == Approx(10.005));
    CHECK(opened(folder.path() / name)->info().bounds.north == Approx(49.995));
  }
}

TEST_CASE(
    "an archive of no raster or several, and packed damage, are refused in one line that names the file") {
  const TempDir folder;
  const Bytes tiff = tiff_bytes();
  const auto complaint = [&](const char* name, const Bytes& bytes) {
    write_bytes(folder.path() / name, bytes);
    const std::string text = complaint_of(folder.path() / name);
    INFO(text);
    CHECK(contains(text, name));
    CHECK_FALSE(contains(text, "\n"));
    CHECK_FALSE(contains(text, "cairn-unpacked-"));
    return text;
  };
  CHECK(contains(complaint("a.zip", zipped({{"a.txt", Bytes(9)}})), "found none"));
  CHECK(contains(complaint("a.zip", zipped({{"a.tif", tiff}, {"b.tif", tiff}})), "found a.tif, b.tif"));
  CHECK(contains(complaint("a.zip", zipped({{"../../a.tif", Bytes(50)}})), "a.tif"));
  CHECK(contains(complaint("a.zip", bytes_of("no archive")), "expected a zip archive"));
  CHECK(contains(complaint("a.tif.gz", bytes_of("no gzip, but long enough to be one")),
                 "expected a gzip file"));
  CHECK(contains(complaint("a.tif.gz", gzipped(bytes_of("no raster"))), "a.tif"));
  Bytes tar(1024);
  std::copy_n(reinterpret_cast<const std::byte*>("ustar"), 5, tar.begin() + 257);
  CHECK(contains(complaint("a.tar.gz", gzipped(tar)), "tar archive"));
  const Bytes whole = gzipped(tiff), archive = zipped({{"a.tif", tiff}});
  for (const std::size_t cut : {std::size_t{5}, whole.size() / 2, whole.size() - 1})
    complaint("cut.tif.gz", {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(cut)});
  for (const std::size_t cut : {std::size_t{5}, archive.size() / 2, archive.size() - 1})
    complaint("cut.zip", {archive.begin(), archive.begin() + static_cast<std::ptrdiff_t>(cut)});
  Bytes damaged = archive;
  damaged[damaged.size() / 3] ^= std::byte{0x40};
  complaint("damaged.zip", damaged);
}

TEST_CASE("a folder gives packed files that hold a raster, and names those that do not") {
  const TempDir folder;
  const Bytes tiff = tiff_bytes();
  write_bytes(folder.path() / "a.tif.gz", gzipped(tiff));
  write_bytes(folder.path() / "b.zip", zipped({{"b.tif", tiff}}));
  write_bytes(folder.path() / "c.zip", bytes_of("damaged"));
  write_bytes(folder.path() / "notes.txt.gz", gzipped(tiff));
  write_bytes(folder.path() / "papers.zip", zipped({{"a.pdf", tiff}}));
  const std::vector<std::string> arguments{folder.path().string()};
  const auto found = expand_inputs(arguments);
  REQUIRE(found.ok());
  std::vector<std::string> files, without;
  for (const auto& file : found->files) files.push_back(file.filename().string());
  for (const auto& file : found->without_raster) without.push_back(file.filename().string());
  CHECK(files == std::vector<std::string>{"a.tif.gz", "b.zip", "c.zip"});
  CHECK(without == std::vector<std::string>{"notes.txt.gz", "papers.zip"});
}

}  // namespace cairn::test
