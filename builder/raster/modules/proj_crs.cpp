// Coordinate reference systems by PROJ. A PROJ object serves one thread at a time, so a transform keeps as
// many copies as threads have used it at once.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <exception>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <proj.h>
#include <proj_experimental.h>

#include "builder/raster/crs_transform.h"

namespace cairn {
namespace {

struct DestroyContext {
  void operator()(PJ_CONTEXT* context) const { proj_context_destroy(context); }
};
struct DestroyObject {
  void operator()(PJ* object) const { proj_destroy(object); }
};
using Context = std::unique_ptr<PJ_CONTEXT, DestroyContext>;
using Object = std::unique_ptr<PJ, DestroyObject>;

Context make_context() {
  Context context(proj_context_create());
  proj_log_level(context.get(), PJ_LOG_NONE);
  proj_context_set_enable_network(context.get(), 0);
  return context;
}

/// An operation and the context that it lives in.
struct Operation {
  Context context;
  Object object;
};

/// From its pipeline, which needs no database, where that is all of it.
Operation copy_of(PJ* operation) {
  Operation copy{make_context(), nullptr};
  const char* pipeline = proj_pj_info(operation).definition;
  if (pipeline != nullptr && std::strstr(pipeline, "proj=") != nullptr)
    copy.object.reset(proj_create(copy.context.get(), pipeline));
  if (!copy.object) copy.object.reset(proj_clone(copy.context.get(), operation));
  return copy;
}

void transform(PJ* operation, PJ_DIRECTION direction, std::span<LonLat> places) {
  for (LonLat& place : places) {
    PJ_COORD at = proj_coord(place.lon, place.lat, 0, HUGE_VAL);
    at = proj_trans(operation, direction, at);
    const bool exists = std::isfinite(at.xy.x) && std::isfinite(at.xy.y);
    place = exists ? LonLat{at.xy.x, at.xy.y} : LonLat{HUGE_VAL, HUGE_VAL};
  }
}

/// The plane's axes: whether they are angles, and their unit.
struct PlaneUnit {
  bool is_degree = false;
  double metres = 0;
};

PlaneUnit unit_of(PJ_CONTEXT* context, const PJ* crs) {
  const Object system(proj_crs_get_coordinate_system(context, crs));
  double factor = 0;
  if (!system || proj_cs_get_axis_info(context, system.get(), 0, nullptr, nullptr, nullptr, &factor, nullptr,
                                       nullptr, nullptr) == 0)
    return {};
  const PJ_TYPE type = proj_get_type(crs);
  if (type != PJ_TYPE_GEOGRAPHIC_2D_CRS) return {false, factor};
  return {std::abs(factor - M_PI / 180) < 1e-12, 0};
}

/// A CRS and all operations from it to degrees on its body.
struct KnownCrs {
  Object crs;
  Object operations;  // PROJ chooses among them by place
  std::string name;   // of the CRS that was asked for
  Body body;
  std::optional<LatitudeKind> latitude = LatitudeKind::planetographic;
  bool is_west_positive = false;
};

class ProjTransform final : public CrsTransform {
 public:
  ProjTransform(const KnownCrs& known, PJ_CONTEXT* context, std::string operation, Operation&& prototype) {
    const PJ* crs = known.crs.get();
    name_ = known.name;
    body_ = known.body;
    latitude_ = known.latitude;
    longitude_sign_ = known.is_west_positive ? -1 : 1;
    operation_ = std::move(operation);
    // A bound CRS has the plane of its base.
    const bool is_bound = proj_get_type(crs) == PJ_TYPE_BOUND_CRS;
    const Object base(is_bound ? proj_get_source_crs(context, crs) : nullptr);
    const PlaneUnit unit = unit_of(context, base ? base.get() : crs);
    is_geographic_ = unit.is_degree;
    metres_of_unit_ = unit.metres;
    prototype_ = std::move(prototype);
  }

  void to_degrees(std::span<LonLat> places) const override {
    Operation operation = take();
    transform(operation.object.get(), PJ_FWD, places);
    turn(places);
    for (LonLat& place : places)
      if (std::abs(place.lon) > 180 && std::isfinite(place.lon)) place.lon = std::remainder(place.lon, 360);
    give_back(std::move(operation));
  }

  void from_degrees(std::span<LonLat> places) const override {
    Operation operation = take();
    turn(places);
    transform(operation.object.get(), PJ_INV, places);
    give_back(std::move(operation));
  }

 private:
  /// Degrees of another body that count to the west go through PROJ as if they counted to the east.
  void turn(std::span<LonLat> places) const {
    if (longitude_sign_ > 0) return;
    for (LonLat& place : places) place.lon = -place.lon;
  }

  Operation take() const {
    const std::scoped_lock lock(mutex_);
    if (idle_.empty()) return copy_of(prototype_.object.get());
    Operation operation = std::move(idle_.back());
    idle_.pop_back();
    return operation;
  }

  void give_back(Operation&& operation) const {
    const std::scoped_lock lock(mutex_);
    idle_.push_back(std::move(operation));
  }

  double longitude_sign_ = 1;
  mutable std::mutex mutex_;
  Operation prototype_;                  // only ever cloned, under the mutex
  mutable std::vector<Operation> idle_;  // guarded by mutex_
};

/// The part of a CRS that lies in the plane.
Object horizontal_part(PJ_CONTEXT* context, Object crs) {
  while (crs && proj_get_type(crs.get()) == PJ_TYPE_COMPOUND_CRS)
    crs.reset(proj_crs_get_sub_crs(context, crs.get(), 0));
  if (!crs) return crs;
  const PJ_TYPE type = proj_get_type(crs.get());
  if (type == PJ_TYPE_BOUND_CRS) {
    const Object base(proj_get_source_crs(context, crs.get()));
    if (!base || proj_get_type(base.get()) != PJ_TYPE_COMPOUND_CRS) return crs;
    return horizontal_part(context, Object(proj_clone(context, base.get())));
  }
  if (type == PJ_TYPE_GEOGRAPHIC_3D_CRS || type == PJ_TYPE_PROJECTED_CRS) {
    Object plane(proj_crs_demote_to_2D(context, nullptr, crs.get()));
    return plane ? std::move(plane) : std::move(crs);
  }
  return crs;
}

/// Every CRS that was asked for.
class CrsLibrary {
 public:
  Result<std::shared_ptr<const CrsTransform>> open(const std::string& definition, double x, double y);

 private:
  Result<KnownCrs*> find(const std::string& definition);

  std::mutex mutex_;
  Context context_ = make_context();
  std::map<std::string, KnownCrs> known_;
  std::map<std::string, std::shared_ptr<const CrsTransform>> transforms_;  // by pipeline
};

std::string reason_of(PJ_CONTEXT* context) {
  const int error = proj_context_errno(context);
  const char* text = error == 0 ? nullptr : proj_context_errno_string(context, error);
  return text == nullptr ? "nothing that PROJ knows" : text;
}

/// A definition as a message shows it: a code as it is, the name of a WKT.
std::string shown(const std::string& definition) {
  const std::size_t open = definition.find('"');
  if (open == std::string::npos) return definition.substr(0, 80);
  return definition.substr(open + 1, definition.find('"', open + 1) - open - 1).substr(0, 80);
}

/// A CRS that GDAL read from a GeoTIFF whose keys name it in words alone ("GCS Name = Mars (2015) /
/// Ocentric|…") is found by that name.
std::string definition_of(const std::string& definition) {
  constexpr std::string_view kName = "GCS Name = ";
  const bool is_local = definition.starts_with("ENGCRS") || definition.starts_with("LOCAL_CS");
  const std::size_t at = definition.find(kName);
  if (!is_local || at == std::string::npos) return definition;
  const std::size_t begin = at + kName.size();
  return definition.substr(begin, definition.find_first_of("|\"", begin) - begin);
}

/// The axes of a CRS of two angles.
struct DegreeAxes {
  bool are_degrees = false;
  bool are_planetocentric = false;
  bool count_west = false;
};

DegreeAxes degree_axes(PJ_CONTEXT* context, const PJ* crs) {
  const Object system(proj_crs_get_coordinate_system(context, crs));
  if (!system) return {};
  const PJ_COORDINATE_SYSTEM_TYPE type = proj_cs_get_type(context, system.get());
  const bool is_spherical = type == PJ_CS_TYPE_SPHERICAL;
  if ((!is_spherical && type != PJ_CS_TYPE_ELLIPSOIDAL) || proj_cs_get_axis_count(context, system.get()) != 2)
    return {};
  DegreeAxes axes{true, is_spherical, false};
  for (const int i : {0, 1}) {
    const char* direction = nullptr;
    double radians = 0;
    if (proj_cs_get_axis_info(context, system.get(), i, nullptr, nullptr, &direction, &radians, nullptr,
                              nullptr, nullptr) == 0 ||
        direction == nullptr || std::abs(radians - M_PI / 180) > 1e-12)
      return {};
    axes.count_west = axes.count_west || std::strcmp(direction, "west") == 0;
  }
  return axes;
}

/// Degrees of longitude and latitude, east and north, on the datum of a CRS.
Object degrees_on_datum(PJ_CONTEXT* context, const PJ* crs) {
  const Object geodetic(proj_crs_get_geodetic_crs(context, crs));
  const Object datum(geodetic ? proj_crs_get_datum_forced(context, geodetic.get()) : nullptr);
  const Object system(
      proj_create_ellipsoidal_2D_cs(context, PJ_ELLPS2D_LONGITUDE_LATITUDE, "degree", M_PI / 180));
  if (!datum || !system) return nullptr;
  return Object(proj_create_geographic_crs_from_datum(context, "degrees", datum.get(), system.get()));
}

/// What a CRS of degrees says by its name: "Mars (2015) / Ocentric", "Mars 2000 planetographic" …
std::optional<LatitudeKind> latitude_by_name(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (name.find("ocentric") != std::string::npos) return LatitudeKind::planetocentric;
  if (name.find("ographic") != std::string::npos || name.find("geodetic") != std::string::npos)
    return LatitudeKind::planetographic;
  return std::nullopt;
}

/// Reads the body of a CRS from its ellipsoid. A CRS of another body's degrees becomes one of plain degrees,
/// and the meaning of its axes is kept apart: PROJ does not put axes that count to the west in order, and
/// does not take the latitudes of a sphere for planetocentric ones.
Status find_body(PJ_CONTEXT* context, KnownCrs& known) {
  const Object ellipsoid(proj_get_ellipsoid(context, known.crs.get()));
  Ellipsoid shape;
  if (!ellipsoid || proj_ellipsoid_get_parameters(context, ellipsoid.get(), &shape.semi_major_m,
                                                  &shape.semi_minor_m, nullptr, nullptr) == 0)
    return {};
  known.body = body_of(shape, proj_get_name(ellipsoid.get()));
  if (known.body.is_earth()) return {};
  const Object geodetic(proj_crs_get_geodetic_crs(context, known.crs.get()));
  const Object meridian(geodetic ? proj_get_prime_meridian(context, geodetic.get()) : nullptr);
  double lon = 0;
  if (meridian && proj_prime_meridian_get_parameters(context, meridian.get(), &lon, nullptr, nullptr) != 0 &&
      lon != 0)
    return bad_data(
        fmt::format("CRS: expected longitudes from the meridian of {}, found a meridian at {} degrees",
                    known.body.name, lon));
  const DegreeAxes axes = degree_axes(context, known.crs.get());
  if (!axes.are_degrees) return {};
  known.is_west_positive = axes.count_west;
  if (!shape.is_sphere())
    known.latitude = axes.are_planetocentric ? LatitudeKind::planetocentric : latitude_by_name(known.name);
  known.crs = degrees_on_datum(context, known.crs.get());
  return {};
}

Object operations_to_degrees(PJ_CONTEXT* context, const KnownCrs& known) {
  const Object degrees = known.body.is_earth() ? Object(proj_create(context, "EPSG:4326"))
                                               : degrees_on_datum(context, known.crs.get());
  if (!degrees) return nullptr;
  const Object all(proj_create_crs_to_crs_from_pj(context, known.crs.get(), degrees.get(), nullptr, nullptr));
  return Object(all ? proj_normalize_for_visualization(context, all.get()) : nullptr);
}

Result<KnownCrs*> CrsLibrary::find(const std::string& definition) {
  const auto found = known_.find(definition);
  if (found != known_.end()) return &found->second;
  PJ_CONTEXT* context = context_.get();
  KnownCrs known;
  known.crs = horizontal_part(context, Object(proj_create(context, definition_of(definition).c_str())));
  if (!known.crs || proj_is_crs(known.crs.get()) == 0)
    return bad_data(fmt::format("CRS: expected one that PROJ knows, found {}: {}", shown(definition),
                                reason_of(context)));
  known.name = proj_get_name(known.crs.get());
  if (auto body = find_body(context, known); !body) return body.error();
  if (known.crs) known.operations = operations_to_degrees(context, known);
  if (!known.operations)
    return bad_data(fmt::format("CRS: expected one that PROJ can transform to degrees on {}, found {}: {}",
                                known.body.is_earth() ? "WGS84" : known.body.name, shown(definition),
                                reason_of(context)));
  return &known_.emplace(definition, std::move(known)).first->second;
}

Result<std::shared_ptr<const CrsTransform>> CrsLibrary::open(const std::string& definition, double x,
                                                             double y) {
  const std::scoped_lock lock(mutex_);
  const auto known = find(definition);
  if (!known) return known.error();
  PJ* all = (*known)->operations.get();
  LonLat place{x, y};
  transform(all, PJ_FWD, {&place, 1});
  if (!std::isfinite(place.lon))
    return bad_data(
        fmt::format("CRS: expected a place of {}, found ({}, {}) outside it", shown(definition), x, y));
  const PJ_PROJ_INFO info = proj_pj_info(all);
  const std::string pipeline = info.definition == nullptr ? definition : info.definition;
  const std::string key = (*known)->name + '\n' + pipeline;
  auto& transform_of = transforms_[key];
  if (transform_of) return transform_of;
  const Object used(proj_trans_get_last_used_operation(all));
  Operation one = copy_of(used ? used.get() : all);
  if (!one.object)
    return bad_data("CRS: expected an operation to WGS84, found none for " + shown(definition));
  const std::string operation = info.description == nullptr ? pipeline : info.description;
  transform_of = std::make_shared<ProjTransform>(**known, context_.get(), operation, std::move(one));
  return transform_of;
}

/// The part of a CRS that heights are measured in: a vertical CRS, or one of three dimensions.
Object vertical_part(PJ_CONTEXT* context, Object crs) {
  while (crs) {
    const PJ_TYPE type = proj_get_type(crs.get());
    if (type == PJ_TYPE_COMPOUND_CRS) {
      crs.reset(proj_crs_get_sub_crs(context, crs.get(), 1));
    } else if (type == PJ_TYPE_BOUND_CRS) {
      crs.reset(proj_get_source_crs(context, crs.get()));
    } else {
      return crs;
    }
  }
  return crs;
}

std::optional<VerticalCrs> find_vertical(const std::string& definition) {
  const Context context = make_context();
  const Object crs = vertical_part(context.get(), Object(proj_create(context.get(), definition.c_str())));
  if (!crs || proj_is_crs(crs.get()) == 0) return std::nullopt;
  const Object system(proj_crs_get_coordinate_system(context.get(), crs.get()));
  const bool is_vertical = proj_get_type(crs.get()) == PJ_TYPE_VERTICAL_CRS;
  const int axis = is_vertical ? 0 : 2;
  double metres = 0;
  const char* direction = nullptr;
  if (!system || proj_cs_get_axis_count(context.get(), system.get()) <= axis ||
      proj_cs_get_axis_info(context.get(), system.get(), axis, nullptr, nullptr, &direction, &metres, nullptr,
                            nullptr, nullptr) == 0)
    return std::nullopt;
  const bool is_up = direction != nullptr && std::strcmp(direction, "up") == 0;
  if (!is_vertical && !is_up) return std::nullopt;  // geocentric
  return VerticalCrs{proj_get_name(crs.get()), is_up ? metres : 0, !is_vertical};
}

}  // namespace
}  // namespace cairn

/// The module's entries: cairn::OpenCrs and cairn::FindVertical.
extern "C" __attribute__((visibility("default"))) void cairn_open_crs(
    const std::string& definition, double x, double y,
    cairn::Result<std::shared_ptr<const cairn::CrsTransform>>& out) {
  try {
    static cairn::CrsLibrary library;
    out = library.open(definition, x, y);
  } catch (const std::exception& e) {
    out = cairn::bad_data(std::string("CRS: expected one that PROJ knows, found: ") + e.what());
  }
}

extern "C" __attribute__((visibility("default"))) void cairn_find_vertical_crs(
    const std::string& definition, std::optional<cairn::VerticalCrs>& out) {
  try {
    out = cairn::find_vertical(definition);
  } catch (const std::exception&) {
    out = std::nullopt;
  }
}
