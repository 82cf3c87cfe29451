#pragma once

#include <filesystem>
#include <memory>

#include "cairn/geo.h"
#include "cairn/pack_reader.h"
#include "cairn/status.h"

namespace cairn {

/// Converts heights between a pack's vertical datum and the WGS84 ellipsoid. The runtime itself never
/// converts: what it takes and gives is in the pack's datum.
///
/// Threads: immutable, so that any number of threads may call it at once.
class VerticalConversion {
 public:
  /// Opens the conversion of a pack. A pack whose heights are above the ellipsoid needs no geoid and ignores
  /// it. A pack of orthometric heights needs the geoid that they are measured from, as a file in the PGM
  /// format of GeographicLib (egm96-5.pgm, egm2008-1.pgm and the like), which is read whole.
  /// usage where the pack's datum is unknown or a geoid is needed and not named; bad_data where the file is
  /// no geoid.
  static Result<VerticalConversion> open(const PackReader& pack, const std::filesystem::path& geoid = {});

  VerticalConversion(VerticalConversion&&) noexcept;
  VerticalConversion& operator=(VerticalConversion&&) noexcept;
  ~VerticalConversion();

  /// Metres above the ellipsoid of a height in the pack's datum. Longitudes may have any number of turns.
  double to_ellipsoid(LonLat place, double height_m) const;

  /// Metres in the pack's datum of a height above the ellipsoid, to the last bits the inverse of
  /// to_ellipsoid().
  double from_ellipsoid(LonLat place, double height_m) const;

 private:
  struct State;
  explicit VerticalConversion(std::unique_ptr<const State> state);
  std::unique_ptr<const State> state_;
};

}  // namespace cairn
