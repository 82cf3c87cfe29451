#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>

#include "cairn/pack_layout.h"
#include "cairn/status.h"

namespace cairn {

/// Where the pixels of a georeferenced picture lie: on a regular grid of degrees on a body, rows from NORTH
/// to south.
struct GeoGrid {
  int columns = 0;
  int rows = 0;
  double west = 0;            ///< degrees, of the first column's posts, or of its outer edge
  double north = 0;           ///< degrees, of the first row's posts, or of its outer edge
  double column_degrees = 0;  ///< from one column to the next
  double row_degrees = 0;     ///< from one row to the next; above zero
  Body body = {};
};

/// A GeoTIFF 1.1 (OGC 19-008r4) in EPSG:4326, or in degrees on another body's ellipsoid, that is written row
/// by row beside its target, as `TARGET.part`, and renamed when whole. Deflated; a BigTIFF where it may pass
/// 4 GiB.
class TiffWriter {
 public:
  enum class Pixel {
    int16,    ///< heights at posts, a void -32768
    float32,  ///< heights at posts, a void -32768
    rgba8,    ///< colours of areas, alpha not premultiplied
  };

  /// `datum` is what heights are measured from.
  static Result<TiffWriter> create(const std::filesystem::path& target, const GeoGrid& grid, Pixel pixel,
                                   VerticalDatum datum = VerticalDatum::unknown);

  TiffWriter(TiffWriter&&) noexcept;
  TiffWriter& operator=(TiffWriter&&) noexcept;
  ~TiffWriter();  ///< removes the part where finish() was not called

  /// The next row from the north, in this machine's byte order. Its values may be changed.
  Status write_row(std::span<std::byte> row);

  /// REQUIRES: all rows are written.
  Status finish();

 private:
  struct State;
  explicit TiffWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cairn
