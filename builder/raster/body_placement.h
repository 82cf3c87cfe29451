#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "builder/raster/raster_source.h"
#include "cairn/body.h"
#include "cairn/status.h"

namespace cairn {

/// A body as a user names it.
struct ToldBody {
  std::string name;
  std::optional<Ellipsoid> shape;  ///< absent: the sources' own, else that of the known body
};

/// Parses "NAME", "NAME,a,b" and "a,b". A name without semi-axes has to be a known body's.
Result<ToldBody> parse_body(std::string_view text);

/// What the CRS of a raster says of the body; what nobody says is the Earth's.
struct CrsBody {
  Body body;
  std::optional<LatitudeKind> latitude = LatitudeKind::planetographic;  ///< nullopt where it could be either
  bool is_west_positive = false;  ///< the raster's longitudes were turned already
};

/// Puts a raster, whose CRS is found, onto its body: sets `info.body`, and how its latitudes and longitudes
/// become planetographic and east-positive ones there. What the user says (SourceOverrides) counts instead of
/// what the CRS says. bad_data where the user names another body than the CRS, and where latitudes on an
/// ellipsoid could be of either kind.
Status put_on_body(const CrsBody& said, RasterInfo& info);

/// Makes west-positive degrees east-positive ones, and back.
void turn_longitudes(Georeference& georeference);

/// The errors that a user can settle by naming the body, or the kind of the latitudes, end so.
inline constexpr std::string_view kBodyUnsettled = "; sources of one pack lie on one ellipsoid";
inline constexpr std::string_view kLatitudeUnsettled = " without saying which";

/// The one body of all rasters, WGS84's Earth where there are none. bad_data where two differ.
Result<Body> common_body(std::span<const RasterInfo* const> rasters);

}  // namespace cairn
