#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "builder/export/tiff_writer.h"
#include "cairn/status.h"

namespace cairn {

/// A georeferenced picture that is written row by row beside its target and renamed when whole.
class PictureWriter {
 public:
  virtual ~PictureWriter() = default;

  /// The next row from the north: 4 bytes a pixel, R, G, B and alpha, not premultiplied.
  virtual Status write_row(std::span<const std::uint8_t> rgba) = 0;

  /// REQUIRES: all rows are written.
  virtual Status finish() = 0;
};

/// Returns whether the name's ending is that of a picture that can be written.
bool is_picture_name(const std::filesystem::path& target);

/// Begins a picture of the format that the name's ending says: .tif and .tiff (GeoTIFF), .png, or .jpg and
/// .jpeg, where what is transparent becomes white. PNG and JPEG have a world file beside them (.pgw, .jgw),
/// in degrees. `area` has the outer edges of the picture. Wrong usage where the ending is another.
Result<std::unique_ptr<PictureWriter>> create_picture(const std::filesystem::path& target,
                                                      const GeoGrid& area);

}  // namespace cairn
