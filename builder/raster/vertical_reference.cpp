#include "builder/raster/vertical_reference.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "builder/raster/crs_transform.h"
#include "builder/raster/io/printable.h"

namespace cairn {
namespace {

struct Known {
  int epsg;
  const char* name;
  VerticalDatum datum;
};
// The commonest, for which PROJ need not be loaded. 5030 is GeoTIFF 1.0's code of the WGS84 ellipsoid.
constexpr std::array kKnown = {Known{5773, "EGM96 height", VerticalDatum::egm96},
                               Known{5171, "EGM96 height", VerticalDatum::egm96},
                               Known{3855, "EGM2008 height", VerticalDatum::unknown},
                               Known{5703, "NAVD88 height", VerticalDatum::unknown},
                               Known{4979, "WGS 84", VerticalDatum::ellipsoid},
                               Known{5030, "WGS 84", VerticalDatum::ellipsoid}};

}  // namespace

// Heights are metres once they are read, so the unit in a CRS's name is none of the datum's.
VerticalReference vertical_reference_named(std::string_view given) {
  std::string spaced(given);  // ESRI: "NAVD88_height_(ftUS)"
  std::replace(spaced.begin(), spaced.end(), '_', ' ');
  std::string_view name = spaced;
  for (const std::string_view unit : {" (ft)", " (ftUS)", " (m)"})
    if (name.ends_with(unit)) name.remove_suffix(unit.size());
  const bool is_egm96 = name.find("EGM96") != std::string_view::npos;
  return {printable(name), is_egm96 ? VerticalDatum::egm96 : VerticalDatum::unknown};
}

VerticalReference vertical_reference(int epsg) {
  const auto known =
      std::find_if(kKnown.begin(), kKnown.end(), [epsg](const Known& k) { return k.epsg == epsg; });
  if (known != kKnown.end()) return {known->name, known->datum};
  const std::string code = fmt::format("EPSG:{}", epsg);
  // GeoTIFF 1.0 has codes of ellipsoids, by which it means heights above them.
  if (epsg >= 5001 && epsg <= 5033) return {code, VerticalDatum::ellipsoid};
  const auto crs = find_vertical_crs(code);
  if (!crs) return {code, VerticalDatum::unknown};
  if (crs->is_ellipsoidal) return {crs->name, VerticalDatum::ellipsoid};
  return vertical_reference_named(crs->name);
}

bool is_one_datum(const VerticalReference& a, const VerticalReference& b) {
  if (a.datum != VerticalDatum::unknown || b.datum != VerticalDatum::unknown) return a.datum == b.datum;
  return a.name == b.name;
}

}  // namespace cairn
