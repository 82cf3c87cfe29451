#pragma once

#include <optional>
#include <string>

#include "builder/raster/raster_pool.h"
#include "cairn/pack_layout.h"
#include "cairn/status.h"

namespace cairn {

/// What the heights of a mosaic are measured from.
struct MosaicDatum {
  VerticalDatum datum = VerticalDatum::unknown;
  std::string vertical_crs;  ///< its name, where every source says one and they agree; else empty
};

/// What a pack calls a datum that is none of VerticalDatum's: the vertical CRS's name, in as many whole UTF-8
/// characters as its header has room for. Empty where the datum is one of those, or nothing is known of it.
std::string other_datum_of(const MosaicDatum& datum);

/// What heights of all sources are measured from: `told`, else what every source says of itself, else
/// unknown. With a geoid, which makes them ellipsoidal, it is the ellipsoid.
///
/// bad_data where two sources say different things and nothing is told of them, and where a geoid would be
/// added to heights that are ellipsoidal already.
Result<MosaicDatum> vertical_datum_of(const RasterPool& pool, std::optional<VerticalDatum> told,
                                      bool with_geoid);

}  // namespace cairn
