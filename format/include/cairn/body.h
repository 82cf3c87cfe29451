#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace cairn {

/// An ellipsoid of revolution, by its semi-axes in metres, 0 < minor <= major. The default is that of WGS84.
struct Ellipsoid {
  double semi_major_m = 6378137.0;
  double semi_minor_m = 6356752.314245179;

  double flattening() const { return (semi_major_m - semi_minor_m) / semi_major_m; }
  bool is_sphere() const { return semi_major_m == semi_minor_m; }
  /// Metres per degree of the equator.
  double equator_degree_m() const { return semi_major_m * 0.017453292519943295; }
  /// The factor between the tangents of a planetocentric latitude and of the planetographic one: (a/b)².
  double graphic_per_centric() const {
    const double ratio = semi_major_m / semi_minor_m;
    return ratio * ratio;
  }

  friend bool operator==(const Ellipsoid&, const Ellipsoid&) = default;
};

/// A body of the solar system and the ellipsoid on which longitudes, east-positive, and latitudes,
/// planetographic, are.
struct Body {
  std::string name = "Earth";  ///< UTF-8, 1 to 31 bytes
  Ellipsoid shape;

  bool is_earth() const { return name == "Earth"; }
  friend bool operator==(const Body&, const Body&) = default;
};

/// Returns a body that is known by name, in any case, with its ellipsoid by the IAU (Archinal et al. 2018,
/// docs/references.md), the Earth with that of WGS84. nullopt for other names.
std::optional<Body> known_body(std::string_view name);

/// Returns the names of all known bodies, a comma between two.
std::string known_body_names();

/// Returns the body that has an ellipsoid of these semi-axes. A known body is recognised where the
/// semi-major axis is not more than 0.1 % outside its radii, so that spheres of its polar or mean radius are
/// its own; semi-axes within 1 cm of the known ones are replaced by them. The ellipsoids of the Earth's many
/// datums are all WGS84's. Another body has `otherwise` as its name, cut to 31 bytes.
Body body_of(const Ellipsoid& shape, std::string_view otherwise);

}  // namespace cairn
