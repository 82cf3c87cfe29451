#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>

#include "cairn/body.h"
#include "cairn/geo.h"
#include "cairn/source_rule.h"
#include "cairn/status.h"

namespace cairn {

/// The plane of a CRS against longitude and latitude on WGS84, or on its own ellipsoid where that is another
/// body's, by one operation of PROJ. Safe to call from several threads at once.
class CrsTransform {
 public:
  virtual ~CrsTransform() = default;

  /// In place: coordinates of the CRS, east in `lon` and north in `lat`, in its own unit, become degrees;
  /// longitudes lie in -180…180. Both numbers of a place that the CRS does not have become infinite.
  virtual void to_degrees(std::span<LonLat> places) const = 0;

  /// The inverse.
  virtual void from_degrees(std::span<LonLat> places) const = 0;

  /// What the operation is called, for a report: "Inverse of British National Grid + OSGB36 to WGS 84 (6)".
  const std::string& operation() const { return operation_; }
  /// The CRS's name, without its vertical part.
  const std::string& name() const { return name_; }
  /// Whether the CRS is one of longitude and latitude in degrees.
  bool is_geographic() const { return is_geographic_; }
  /// Metres of the plane's unit; 0 where it is an angle.
  double metres_of_unit() const { return metres_of_unit_; }
  /// The body that the degrees are on, with the CRS's own ellipsoid where it is not the Earth.
  const Body& body() const { return body_; }
  /// What the latitudes are. nullopt where the CRS is one of degrees on another body's ellipsoid and does not
  /// say it by its axes or its name.
  std::optional<LatitudeKind> latitude() const { return latitude_; }

 protected:
  std::string operation_;
  std::string name_;
  bool is_geographic_ = false;
  double metres_of_unit_ = 0;
  Body body_;
  std::optional<LatitudeKind> latitude_ = LatitudeKind::planetographic;
};

/// The transform of a CRS: `definition` is whatever PROJ takes, "EPSG:2154" or WKT. A vertical part is left
/// out, so the plane is transformed as a plane. Of several datum operations the one is chosen that PROJ ranks
/// first at (x, y), a place of the raster in the CRS. Equal operations are one object, so they can be
/// compared by address. bad_data says why PROJ has none ("CRS: expected …"), without a file's name.
Result<std::shared_ptr<const CrsTransform>> open_crs(const std::string& definition, double x, double y);

/// What a CRS says of heights.
struct VerticalCrs {
  std::string name;
  double metres = 1;  ///< of its unit; 0 where it counts downwards
  bool is_ellipsoidal = false;
};

/// The vertical part of a CRS: a vertical one itself, that of a compound one, the third dimension of a
/// geographic or projected one. nullopt where it has none or PROJ does not know it.
std::optional<VerticalCrs> find_vertical_crs(const std::string& definition);

}  // namespace cairn
