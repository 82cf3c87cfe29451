#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "builder/raster/georeference.h"
#include "builder/raster/sample_type.h"
#include "builder/raster/vertical_reference.h"
#include "cairn/body.h"
#include "cairn/geo.h"
#include "cairn/source_rule.h"
#include "cairn/status.h"

namespace cairn {

/// What a raster says of itself before any post is read.
struct RasterInfo {
  std::filesystem::path path;
  std::string format;  ///< "hgt", "dted", "geotiff", …
  std::int64_t columns = 0;
  std::int64_t rows = 0;
  int bands = 1;
  SampleType type = SampleType::int16;
  /// Posts are whole metres, as far as known: by their type, or in a RasterPool by those that were looked at.
  /// The default error bound is then 0.5 m, else 0.05 m.
  bool whole_metres = true;
  Georeference georeference;
  Body body;                                  ///< on which its places are
  GeoBounds bounds;                           ///< of the posts, in degrees; east may pass 180
  std::optional<double> nodata;               ///< the customary void values are voids besides
  std::string unit;                           ///< of its heights as the file spells it; "" is the metre
  std::optional<VerticalReference> vertical;  ///< what its heights are measured from, where it says so
  SourceOverrides overrides;                  ///< what the user says of it; nodata and unit have it already
};

/// A rectangle of posts in the file's own order: row 0 is the file's first.
struct PostWindow {
  std::int64_t column = 0;
  std::int64_t row = 0;
  std::int64_t columns = 0;
  std::int64_t rows = 0;
};

/// One raster, read window by window and never whole. Safe to call from several threads at once.
class RasterSource {
 public:
  virtual ~RasterSource() = default;

  const RasterInfo& info() const { return info_; }

  /// Heights in metres, row-major, window.columns·window.rows of them; a void is NaN. REQUIRES: the window
  /// lies inside the raster. bad_data names the file and the place that could not be read.
  virtual Status read_heights(const PostWindow& window, std::span<float> out) const = 0;

  /// Colours: 4 bytes a pixel, R, G, B and alpha, not premultiplied; alpha 0 where the file has no value.
  virtual Status read_colours(const PostWindow& window, std::span<std::uint8_t> rgba) const = 0;

 protected:
  explicit RasterSource(RasterInfo info) : info_(std::move(info)) {}
  RasterInfo info_;
};

struct OpenOptions {
  std::optional<GeoBounds> bounds =
      std::nullopt;  ///< where the image has no georeference of its own (outer edges of its pixels)
  std::size_t cache_bytes = 32u << 20;  ///< decoded strips or tiles that the source may keep
  std::vector<SourceRule> rules = {};   ///< what counts instead of what sources say of themselves
  SourceOverrides overrides = {};       ///< those of this source; open_raster() makes them of the rules
};

/// One way of opening files. Each file of builder/raster/formats/ defines one; the folder is the list.
struct RasterFormat {
  const char* name;
  /// Lower claims first; a general reader (GDAL) has the highest number.
  int order;
  /// Whether the file is this format's to open: by its first bytes and its name. Must not fail on garbage.
  bool (*claims)(const std::filesystem::path& path, std::span<const std::byte> first_bytes);
  Result<std::unique_ptr<RasterSource>> (*open)(const std::filesystem::path& path,
                                                const OpenOptions& options);
  /// Whether a file that it claims is no other format's: its error is then the last word. (GDAL would take an
  /// .hgt whose name or size lies for something else.)
  bool exclusive = false;
};
std::span<const RasterFormat* const> raster_formats();

/// Opens a raster of any known format: the first format that claims the file and opens it, up to an exclusive
/// one, else the first claimant's error.
Result<std::unique_ptr<RasterSource>> open_raster(const std::filesystem::path& path,
                                                  const OpenOptions& options);

}  // namespace cairn
