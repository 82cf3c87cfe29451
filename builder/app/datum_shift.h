#pragma once

#include <memory>
#include <string>

#include "cairn/pack_reader.h"

namespace cairn {

/// What is added to a pack's heights so that they are above the ellipsoid or the geoid EGM96.
class DatumShift {
 public:
  enum class To { stored, ellipsoid, orthometric };

  /// The geoid is egm96-5 of GeographicLib, else its egm96-15, from where the library looks for it
  /// (GEOGRAPHICLIB_GEOID_PATH, GEOGRAPHICLIB_DATA, /usr/share/GeographicLib). usage_error where the pack's
  /// datum is unknown; failed where the shift needs a geoid and none is installed.
  static Result<DatumShift> open(const PackReader& pack, To to);

  /// Metres.
  double at(LonLat place) const;

  DatumShift(DatumShift&&) noexcept;
  DatumShift& operator=(DatumShift&&) noexcept;
  ~DatumShift();

 private:
  struct Geoid;
  DatumShift();
  std::unique_ptr<Geoid> geoid_;  // null where nothing is added
  double sign_ = 1;
};

}  // namespace cairn
