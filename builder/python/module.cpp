// The Python module: packs as numpy arrays, and bakes. Arrays have their first row in the north.

#include <cerrno>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <tuple>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "builder/python/bake.h"
#include "builder/python/errors.h"
#include "builder/python/pack.h"
#include "format/imagery_tile.h"

namespace cairn {
namespace py = pybind11;
namespace {

using Path = std::filesystem::path;
using Bounds = std::tuple<double, double, double, double>;
using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

constexpr std::size_t kMostPixels = std::size_t{1} << 31;

std::unique_ptr<Pack> open_pack(const Path& path) {
  if (!std::filesystem::exists(path)) {
    errno = ENOENT;
    PyErr_SetFromErrnoWithFilename(PyExc_OSError, path.c_str());
    throw py::error_already_set();
  }
  const py::gil_scoped_release release;
  auto pack = Pack::open(path);
  if (pack) return *std::move(pack);
  const py::gil_scoped_acquire gil;
  raise(pack.error());
}

py::object info_of(const Pack& pack) {
  return py::module_::import("json").attr("loads")(std::string(pack.reader().metadata_json()));
}

std::optional<std::tuple<int, int>> levels_of(const Pack& pack, Layer layer) {
  const auto range = pack.reader().levels(layer);
  if (!range) return std::nullopt;
  return std::tuple(range->coarsest, range->finest);
}

Layer layer_of(const std::string& name) {
  for (const Layer layer : {Layer::heights, Layer::imagery})
    if (name == to_string(layer)) return layer;
  raise(usage_error("layer: expected heights or imagery, found " + name));
}

void check_level(std::optional<int> level) {
  if (level && (*level < kMinLevel || *level > kMaxLevel))
    raise(usage_error("level: expected -9 to 20, found " + std::to_string(*level)));
}

/// An array whose NaN are masked.
py::object masked(const py::array& values) {
  return py::module_::import("numpy.ma").attr("masked_invalid")(values, py::arg("copy") = false);
}

/// Runs `work`, which reads tiles, without the GIL.
template <class Work>
void without_gil(const Work& work) {
  const Status status = [&] {
    const py::gil_scoped_release release;
    return work();
  }();
  if (!status) raise(status.error());
}

template <class Value>
std::span<Value> span_of(py::array_t<Value>& array) {
  return {array.mutable_data(), static_cast<std::size_t>(array.size())};
}

py::object heights(const Pack& pack, const py::object& lon, const py::object& lat, std::optional<int> level) {
  check_level(level);
  const py::tuple both = py::module_::import("numpy").attr("broadcast_arrays")(lon, lat);
  const auto lons = py::cast<Numbers>(both[0]), lats = py::cast<Numbers>(both[1]);
  const std::vector<py::ssize_t> shape(lons.shape(), lons.shape() + lons.ndim());
  py::array_t<double> metres(shape);
  py::array_t<std::int8_t> levels(shape);
  py::array_t<float> errors(shape);
  const HeightAnswers out{span_of(metres), span_of(levels), span_of(errors)};
  const auto places = [](const Numbers& n) {
    return std::span(n.data(), static_cast<std::size_t>(n.size()));
  };
  without_gil([&] { return pack.heights(places(lons), places(lats), level, out); });
  return py::module_::import("cairn").attr("Heights")(metres, levels, errors);
}

IndexEntry find_entry(const Pack& pack, Layer layer, const TileId& id) {
  if (!is_valid(id)) raise(usage_error("tile: expected level, x and y of the grid, found " + to_string(id)));
  const auto entry = pack.reader().find(layer, id);
  if (entry) return *entry;
  throw py::key_error(pack.reader().path().string() + ": " + to_string(layer) + " " + to_string(id) +
                      ": expected a tile, found none");
}

py::object height_tile(const Pack& pack, const IndexEntry& entry) {
  const auto side = static_cast<std::size_t>(pack.reader().header().tile_size);
  py::array_t<double> metres({side, side});
  const std::span<double> out = span_of(metres);
  without_gil([&]() -> Status {
    const auto tile = pack.reader().read_height_tile(entry);
    if (!tile) return tile.error();
    for (std::size_t i = 0; i < out.size(); ++i) {
      const std::size_t from = (side - 1 - i / side) * side + i % side;
      const bool is_void = !tile->voids.empty() && tile->voids[from] != 0;
      out[i] = is_void ? std::numeric_limits<double>::quiet_NaN()
                       : tile->samples[from] * pack.reader().header().quantum_m;
    }
    return {};
  });
  return masked(metres);
}

py::object imagery_tile(const Pack& pack, const IndexEntry& entry) {
  const auto side = static_cast<std::size_t>(pack.reader().header().tile_size - 1);
  py::array_t<std::uint8_t> rgba({side, side, std::size_t{4}});
  const std::span<std::uint8_t> out = span_of(rgba);
  without_gil([&]() -> Status {
    const auto tile = read_imagery_tile(pack.reader(), entry);
    if (!tile) return tile.error();
    std::copy(tile->begin(), tile->end(), out.begin());
    return {};
  });
  return rgba;
}

py::object tile(const Pack& pack, int level, std::int32_t x, std::int32_t y, const std::string& layer_name) {
  const Layer layer = layer_of(layer_name);
  const IndexEntry entry = find_entry(pack, layer, {level, x, y});
  return layer == Layer::heights ? height_tile(pack, entry) : imagery_tile(pack, entry);
}

Window window_of(const Bounds& b, const std::tuple<py::ssize_t, py::ssize_t>& shape) {
  const auto [west, south, east, north] = b;
  if (!(west < east && south < north && south >= -90 && north <= 90 && east - west <= 360 &&
        std::isfinite(west) && std::isfinite(east)))
    raise(
        usage_error("bounds: expected (west, south, east, north) in degrees, west < east and south < north, "
                    "found others"));
  const auto [rows, columns] = shape;
  if (rows < 1 || columns < 1 ||
      static_cast<std::size_t>(rows) > kMostPixels / static_cast<std::size_t>(columns))
    raise(usage_error("shape: expected (rows, columns) of at least 1 and at most 2^31 pixels, found (" +
                      std::to_string(rows) + ", " + std::to_string(columns) + ")"));
  return {{west, south, east, north}, static_cast<std::size_t>(rows), static_cast<std::size_t>(columns)};
}

/// The level to draw a window from.
int level_of(const Pack& pack, const Window& window, Layer layer, std::optional<int> level) {
  check_level(level);
  if (!pack.reader().levels(layer))
    raise(failed(pack.reader().path().string() + ": expected " + to_string(layer) + ", the pack has none"));
  return level ? *level : pack.level_for(window, layer);
}

py::object window(const Pack& pack, const Bounds& bounds, const std::tuple<py::ssize_t, py::ssize_t>& shape,
                  std::optional<int> level) {
  const Window area = window_of(bounds, shape);
  const int from = level_of(pack, area, Layer::heights, level);
  py::array_t<double> metres({area.rows, area.columns});
  const std::span<double> out = span_of(metres);
  without_gil([&] { return pack.draw_heights(area, from, out); });
  return masked(metres);
}

py::object imagery(const Pack& pack, const Bounds& bounds, const std::tuple<py::ssize_t, py::ssize_t>& shape,
                   std::optional<int> level) {
  const Window area = window_of(bounds, shape);
  const int from = level_of(pack, area, Layer::imagery, level);
  py::array_t<std::uint8_t> rgba({area.rows, area.columns, std::size_t{4}});
  const std::span<std::uint8_t> out = span_of(rgba);
  without_gil([&] { return pack.draw_imagery(area, from, out); });
  return rgba;
}

std::string repr(const Pack& pack) {
  return "<cairn.Pack " + pack.reader().path().string() + ">";
}

void add_pack(py::module_& module) {
  py::class_<Pack>(module, "Pack", "An open pack. Any number of threads may call it at once.")
      .def_property_readonly(
          "path", [](const Pack& p) { return p.reader().path(); }, "The file.")
      .def_property_readonly("info", &info_of,
                             "The metadata of the pack; docs/pack-format.md lists the keys.")
      .def_property_readonly(
          "tile_size", [](const Pack& p) { return int{p.reader().header().tile_size}; },
          "Samples along a side of a height tile; an imagery tile has one texel less.")
      .def_property_readonly(
          "quantum_m", [](const Pack& p) { return p.reader().header().quantum_m; },
          "The step in which heights are stored, in metres.")
      .def_property_readonly(
          "body",
          [](const Pack& p) {
            const Body& body = p.reader().header().body;
            return py::make_tuple(body.name, body.shape.semi_major_m, body.shape.semi_minor_m);
          },
          "The body's name and the semi-axes of its ellipsoid in metres.")
      .def_property_readonly(
          "vertical_datum", [](const Pack& p) { return std::string(p.reader().header().datum_name()); },
          "What heights are measured from: unknown, egm96, ellipsoid or another name.")
      .def_property_readonly(
          "levels", [](const Pack& p) { return levels_of(p, Layer::heights); },
          "(coarsest, finest) level of heights; None without heights.")
      .def_property_readonly(
          "imagery_levels", [](const Pack& p) { return levels_of(p, Layer::imagery); },
          "(coarsest, finest) level of imagery; None without imagery.")
      .def("heights", &heights, py::arg("lon"), py::arg("lat"), py::kw_only(), py::arg("level") = py::none(),
           R"(Heights at places in degrees, from the finest tiles, or from those of one level only.

lon and lat are numbers or arrays that broadcast. Returns Heights(metres, level, error_m), arrays of their common
shape: bilinear heights, the level of the tile that gave each, and that tile's geometric error. Where the pack has
no height, and where lon or lat is NaN, metres and error_m are NaN and level is -128.)")
      .def("tile", &tile, py::arg("level"), py::arg("x"), py::arg("y"), py::arg("layer") = "heights",
           R"(A tile as it is stored; KeyError where the pack has none.

heights: a masked array of metres, tile_size squared, voids masked. imagery: RGBA bytes in sRGB, one texel less along
a side. The first row is in the north.)")
      .def("window", &window, py::arg("bounds"), py::arg("shape"), py::kw_only(),
           py::arg("level") = py::none(),
           R"(Heights of an area as a masked array of metres, masked where the pack has none.

bounds: (west, south, east, north), the outer edges in degrees; shape: (rows, columns). A value is the height at its
pixel's centre. Without level, tiles are used whose samples lie no farther apart than the pixels, where there are
such. Where tiles were left out, coarser ones are drawn.)")
      .def("imagery", &imagery, py::arg("bounds"), py::arg("shape"), py::kw_only(),
           py::arg("level") = py::none(),
           "Imagery of an area as RGBA bytes in sRGB, shape (rows, columns, 4), transparent where there is "
           "none; "
           "otherwise as window().")
      .def("__repr__", &repr);
}

}  // namespace
}  // namespace cairn

PYBIND11_MODULE(_cairn, module) {
  module.attr("__version__") = CAIRN_VERSION;
  cairn::add_errors(module);
  cairn::add_pack(module);
  module.def("open", &cairn::open_pack, pybind11::arg("path"),
             "Opens a pack. FileNotFoundError where there is none, BadDataError where it is damaged.");
  cairn::add_bake(module);
}
