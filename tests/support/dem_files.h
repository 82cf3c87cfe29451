#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "builder/raster/raster_source.h"
#include "tests/support/test_pack.h"

namespace cairn::test {

using Bytes = std::vector<std::byte>;

void write_text(const std::filesystem::path& path, const std::string& text);

/// Integer heights of a test raster by column and row (row 0 the northernmost): hills between -300 and 3000
/// m.
int test_height(std::int64_t column, std::int64_t row);

/// Big-endian int16, `posts`² of them.
Bytes hgt_bytes(int posts, const std::function<int(std::int64_t, std::int64_t)>& height = test_height);

Bytes gzipped(const Bytes& bytes);

struct ZipMember {
  std::string name;
  Bytes bytes;
  bool deflate = true;
};
Bytes zipped(const std::vector<ZipMember>& members);

/// A DTED file of columns × rows posts whose south-western one lies at whole degrees. row 0 of `height` is
/// the northernmost.
struct DtedRecipe {
  int lon = -156;
  int lat = 19;
  int columns = 121;
  int rows = 121;
  int lon_interval = 300;  ///< tenths of a second
  int lat_interval = 300;
  bool twos_complement = false;
  std::function<int(std::int64_t, std::int64_t)> height = test_height;
};
Bytes dted_bytes(const DtedRecipe& recipe);

/// A TIFF written through libtiff.
struct TiffRecipe {
  int columns = 100;
  int rows = 80;
  int bands = 1;
  SampleType type = SampleType::int16;
  int bits = 0;  ///< 0: the type's own
  int compression = 1;
  int predictor = 1;
  int tile = 0;  ///< 0: strips
  int rows_per_strip = 7;
  bool planar = false;
  bool big_endian = false;
  bool big_tiff = false;
  int photometric = 1;
  std::vector<std::uint16_t> extra_samples;
  std::vector<double> pixel_scale{0.01, 0.01, 0};
  std::vector<double> tiepoint{0, 0, 0, 10, 50, 0};
  std::vector<double> transformation;
  /// Short keys, in order; the default is WGS84, pixel-is-area.
  std::map<int, int> keys{{1024, 2}, {1025, 1}, {2048, 4326}};
  std::map<int, double> double_keys;
  std::string citation;  ///< key 1026
  std::string nodata;
  std::string gdal_metadata;
  bool mask = false;  ///< a second directory: pixels of odd columns are left out
  bool leave_out_last_tile = false;
  /// Sample of a band as a number; the default is test_height for every band.
  std::function<double(int band, std::int64_t column, std::int64_t row)> sample;
};
void write_tiff(const std::filesystem::path& path, const TiffRecipe& recipe);

/// Reads every post.
std::vector<float> all_heights(const RasterSource& source);
std::vector<std::uint8_t> all_colours(const RasterSource& source);

/// Opens the raster, which must succeed.
std::unique_ptr<RasterSource> opened(const std::filesystem::path& path, const OpenOptions& options = {});

/// The message with which opening, or else reading every post, fails; empty where neither does.
std::string complaint_of(const std::filesystem::path& path, const OpenOptions& options = {});

}  // namespace cairn::test
