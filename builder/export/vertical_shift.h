#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "cairn/geo.h"
#include "cairn/pack_layout.h"
#include "cairn/status.h"

namespace cairn {

/// What heights an export has.
enum class ExportHeights {
  ellipsoidal,  ///< above the WGS84 ellipsoid
  as_stored,    ///< above the pack's own datum
};

/// What is added to a pack's heights to make them those of an export.
struct VerticalShift {
  /// Metres at a place; empty where nothing is added. Any number of threads may call it.
  std::function<double(LonLat)> metres;
  /// The datum that the exported heights are above.
  VerticalDatum datum = VerticalDatum::unknown;

  double at(LonLat place) const { return metres ? metres(place) : 0; }
};

/// The shift for a pack of this datum. A pack above a geoid needs the geoid's undulations: `geoid`, a raster
/// around the Earth or a .pgm of GeographicLib, or GeographicLib's installed egm96-5 where it is empty.
/// usage where the datum is unknown or a geoid is named that is not needed, failed where no geoid is found,
/// bad_data where the file is none.
Result<VerticalShift> vertical_shift(VerticalDatum pack_datum, ExportHeights heights,
                                     const std::filesystem::path& geoid);

}  // namespace cairn
