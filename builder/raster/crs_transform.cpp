// PROJ brings SQLite and curl, so it lives in a module of its own (cairn-proj.so), loaded for the first CRS
// that cairn does not compute itself.
#include "builder/raster/crs_transform.h"

#include "builder/raster/reader_plugin.h"

namespace cairn {
namespace {

using Transform = std::shared_ptr<const CrsTransform>;
using OpenCrs = void (*)(const std::string& definition, double x, double y, Result<Transform>& out);
using FindVertical = void (*)(const std::string& definition, std::optional<VerticalCrs>& out);

}  // namespace

Result<Transform> open_crs(const std::string& definition, double x, double y) {
  static const auto open = reinterpret_cast<OpenCrs>(load_reader_plugin("cairn-proj", "cairn_open_crs"));
  if (open == nullptr)
    return bad_data(
        "CRS: expected geographic WGS84, UTM or Web Mercator, found another, and cairn-proj.so cannot be "
        "loaded");
  Result<Transform> out(nullptr);
  open(definition, x, y, out);
  return out;
}

std::optional<VerticalCrs> find_vertical_crs(const std::string& definition) {
  static const auto find =
      reinterpret_cast<FindVertical>(load_reader_plugin("cairn-proj", "cairn_find_vertical_crs"));
  std::optional<VerticalCrs> found;
  if (find != nullptr) find(definition, found);
  return found;
}

}  // namespace cairn
