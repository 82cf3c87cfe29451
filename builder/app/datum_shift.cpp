#include "builder/app/datum_shift.h"

#include <exception>

#include <GeographicLib/Geoid.hpp>

namespace cairn {

struct DatumShift::Geoid {
  explicit Geoid(const char* name) : undulations(name) {}
  GeographicLib::Geoid undulations;
};

DatumShift::DatumShift() = default;
DatumShift::DatumShift(DatumShift&&) noexcept = default;
DatumShift& DatumShift::operator=(DatumShift&&) noexcept = default;
DatumShift::~DatumShift() = default;

Result<DatumShift> DatumShift::open(const PackReader& pack, To to) {
  DatumShift shift;
  const VerticalDatum datum = pack.header().vertical_datum;
  if (to == To::stored) return shift;
  if (to == To::orthometric && !pack.header().body.is_earth())
    return usage_error(pack.path().string() +
                       ": vertical datum: expected the Earth for the geoid EGM96, found " +
                       pack.header().body.name);
  if (datum == VerticalDatum::unknown)
    return usage_error(pack.path().string() + ": vertical datum: expected a known one, found unknown");
  const bool is_ellipsoidal = datum == VerticalDatum::ellipsoid;
  if (is_ellipsoidal == (to == To::ellipsoid)) return shift;
  shift.sign_ = is_ellipsoidal ? -1 : 1;
  std::string found;
  for (const char* name : {"egm96-5", "egm96-15"}) {
    try {
      shift.geoid_ = std::make_unique<Geoid>(name);
      return shift;
    } catch (const std::exception& error) {
      found = error.what();
    }
  }
  return failed(
      "geoid: expected GeographicLib's egm96-5 (geographiclib-get-geoids egm96-5 installs it), found: " +
      found);
}

double DatumShift::at(LonLat place) const {
  return geoid_ ? sign_ * geoid_->undulations(place.lat, place.lon) : 0;
}

}  // namespace cairn
