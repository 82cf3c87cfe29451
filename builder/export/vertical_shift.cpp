#include "builder/export/vertical_shift.h"

#include <exception>
#include <memory>
#include <string>

#include <GeographicLib/Geoid.hpp>

#include "builder/mosaic/geoid.h"

namespace cairn {
namespace {

Result<VerticalShift> shift_by_geographiclib(const std::filesystem::path& file) {
  const std::string name = file.empty() ? "egm96-5" : file.stem().string();
  const std::string folder = file.empty() ? "" : file.has_parent_path() ? file.parent_path().string() : ".";
  try {
    const auto geoid = std::make_shared<GeographicLib::Geoid>(name, folder, true, true);
    return VerticalShift{[geoid](LonLat p) { return (*geoid)(p.lat, p.lon); }, VerticalDatum::ellipsoid};
  } catch (const std::exception& error) {
    if (file.empty())
      return failed(
          std::string(
              "geoid: expected the undulations of EGM96, which the pack's heights are above, found ") +
          error.what());
    return bad_data(file.string() + ": expected a geoid of GeographicLib, found " + error.what());
  }
}

}  // namespace

Result<VerticalShift> vertical_shift(VerticalDatum pack_datum, ExportHeights heights,
                                     const std::filesystem::path& geoid) {
  if (heights == ExportHeights::as_stored || pack_datum == VerticalDatum::ellipsoid) {
    if (!geoid.empty())
      return usage_error(geoid.string() + ": expected no geoid, since nothing is to be added, found one");
    return VerticalShift{{}, pack_datum};
  }
  if (pack_datum == VerticalDatum::unknown)
    return usage_error("vertical datum: expected one that is known, found unknown");
  if (geoid.empty() || geoid.extension() == ".pgm") return shift_by_geographiclib(geoid);
  auto raster = Geoid::open(geoid);
  if (!raster) return raster.error();
  const auto shared = std::make_shared<Geoid>(std::move(*raster));
  return VerticalShift{[shared](LonLat p) { return shared->undulation(p); }, VerticalDatum::ellipsoid};
}

}  // namespace cairn
