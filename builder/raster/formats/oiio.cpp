// Images of formats that no reader of cairn's own knows, through OpenImageIO, which lives in a module of its
// own (cairn-oiio.so) and is loaded by the first such file. They lie where a world file or the options say.
#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "builder/raster/image_module.h"
#include "builder/raster/raster_names.h"
#include "builder/raster/raster_source.h"
#include "builder/raster/reader_plugin.h"
#include "builder/raster/world_file.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr std::array kExtensions = {".jp2", ".j2k", ".bmp", ".webp", ".exr", ".tga"};
using namespace std::string_view_literals;

/// What the formats begin with. TGA begins with nothing of its own and goes by its name.
constexpr std::array kMagics = {
    "BM"sv,     "8BPS"sv, "GIF8"sv, "\x76\x2f\x31\x01"sv, "SDPX"sv, "XPDS"sv, "#?RADIANCE"sv,
    "#?RGBE"sv, "P5"sv,   "P6"sv,   "\xff\x4f\xff\x51"sv};
constexpr auto kJpeg2000 = "\0\0\0\x0cjP  \r\n\x87\n"sv;
/// Boxes of a JPEG 2000 file that say where it lies: GeoJP2's identifier, and GMLJP2's association. GDAL
/// reads them, OpenImageIO does not.
constexpr std::array kPlaceBoxes = {"\xb1\x4b\xf8\xbd\x08\x3d\x4b\x43\xa5\xae\x8c\xd7\xd5\xa6\xce\x03"sv,
                                    "asoc"sv};

bool claims(const fs::path& path, std::span<const std::byte> first_bytes) {
  const std::string_view first(reinterpret_cast<const char*>(first_bytes.data()), first_bytes.size());
  if (first.starts_with(kJpeg2000))
    return std::none_of(kPlaceBoxes.begin(), kPlaceBoxes.end(),
                        [&](std::string_view box) { return first.find(box) != first.npos; });
  if (first.starts_with("RIFF") && first.size() >= 12 && first.substr(8, 4) == "WEBP") return true;
  if (std::any_of(kMagics.begin(), kMagics.end(),
                  [&](std::string_view magic) { return first.starts_with(magic); }))
    return true;
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".tga";
}

ImageModule load_module() {
  ImageModule module;
  const auto fill =
      reinterpret_cast<void (*)(ImageModule&)>(load_reader_plugin("cairn-oiio", "cairn_image_module"));
  if (fill != nullptr) fill(module);
  return module;
}

Result<std::unique_ptr<RasterSource>> open(const fs::path& path, const OpenOptions& options) {
  // An image without a place is GDAL's, and OpenImageIO need not be loaded to learn that.
  if (auto place = georeference_beside(path, 1, 1, options); !place) return place.error();
  static const ImageModule module = load_module();
  if (module.decode == nullptr)
    return bad_data(
        path.string() +
        ": expected a format that cairn reads itself, found another, and cairn-oiio.so cannot be loaded");
  const auto header = module.read_header(path);
  if (!header) return header.error();
  return open_scanline_raster("oiio", path, *header, module.decode, options);
}

}  // namespace

extern const RasterFormat oiio_format;
const RasterFormat oiio_format = {"oiio", 900, claims, open};

extern const RasterNames oiio_names;
const RasterNames oiio_names = {kExtensions};

}  // namespace cairn
