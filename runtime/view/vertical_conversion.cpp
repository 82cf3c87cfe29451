#include "cairn/vertical_conversion.h"

#include <exception>
#include <optional>
#include <string>
#include <utility>

#include <GeographicLib/Geoid.hpp>

namespace cairn {

struct VerticalConversion::State {
  std::optional<GeographicLib::Geoid> geoid;  // none: the pack's datum is the ellipsoid

  double undulation_m(LonLat place) const { return geoid ? (*geoid)(place.lat, place.lon) : 0; }
};

Result<VerticalConversion> VerticalConversion::open(const PackReader& pack,
                                                    const std::filesystem::path& geoid) {
  auto state = std::make_unique<State>();
  const VerticalDatum datum = pack.header().vertical_datum;
  if (datum == VerticalDatum::ellipsoid) return VerticalConversion(std::move(state));
  if (datum == VerticalDatum::unknown) {
    return usage_error(pack.path().string() + ": vertical datum: expected a known one, found unknown");
  }
  if (geoid.empty()) {
    return usage_error(pack.path().string() + ": vertical datum: expected a geoid for " + to_string(datum) +
                       ", found none");
  }
  if (geoid.extension() != ".pgm") {
    return usage_error(geoid.string() +
                       ": expected a geoid of GeographicLib (.pgm), found another extension");
  }
  try {
    // Read whole and marked as safe to share, so that no call has to read the file.
    const bool cubic = true;
    const bool thread_safe = true;
    state->geoid.emplace(geoid.stem().string(), geoid.has_parent_path() ? geoid.parent_path().string() : ".",
                         cubic, thread_safe);
  } catch (const std::exception& error) {
    return bad_data(geoid.string() + ": expected a geoid of GeographicLib, found " + error.what());
  }
  return VerticalConversion(std::move(state));
}

VerticalConversion::VerticalConversion(std::unique_ptr<const State> state) : state_(std::move(state)) {}
VerticalConversion::VerticalConversion(VerticalConversion&&) noexcept = default;
VerticalConversion& VerticalConversion::operator=(VerticalConversion&&) noexcept = default;
VerticalConversion::~VerticalConversion() = default;

double VerticalConversion::to_ellipsoid(LonLat place, double height_m) const {
  return height_m + state_->undulation_m(place);
}

double VerticalConversion::from_ellipsoid(LonLat place, double height_m) const {
  return height_m - state_->undulation_m(place);
}

}  // namespace cairn
