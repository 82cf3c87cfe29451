#include "builder/raster/raster_source.h"

#include <algorithm>

#include "builder/raster/gdal_name.h"
#include "builder/raster/io/input_file.h"
#include "builder/raster/source_overrides.h"

namespace cairn {
namespace {

constexpr std::size_t kFirstBytes = 4096;

std::vector<const RasterFormat*> formats_in_order() {
  const auto table = raster_formats();
  std::vector<const RasterFormat*> formats(table.begin(), table.end());
  std::stable_sort(formats.begin(), formats.end(),
                   [](const RasterFormat* a, const RasterFormat* b) { return a->order < b->order; });
  return formats;
}

std::string known_formats() {
  std::string names;
  for (const RasterFormat* format : formats_in_order())
    names += (names.empty() ? "" : ", ") + std::string(format->name);
  return names;
}

}  // namespace

Result<std::unique_ptr<RasterSource>> open_raster(const std::filesystem::path& path,
                                                  const OpenOptions& asked) {
  OpenOptions options = asked;
  if (!options.rules.empty()) options.overrides = overrides_of(path, options.rules);
  if (file_of_gdal_name(path)) return formats_in_order().back()->open(path, options);
  auto file = InputFile::open(path);
  if (!file) return file.error();
  std::vector<std::byte> first(static_cast<std::size_t>(std::min<std::uint64_t>(file->size(), kFirstBytes)));
  if (auto read = file->read_at(0, first); !read) return read.error();
  std::optional<Error> first_error;
  for (const RasterFormat* format : formats_in_order()) {
    if (!format->claims(path, first)) continue;
    auto source = format->open(path, options);
    if (source) return source;
    if (!first_error) first_error = source.error();
    if (format->exclusive) break;
  }
  if (first_error) return *first_error;
  return bad_data(path.string() + ": expected a raster (" + known_formats() +
                  "), found no format that knows its first bytes");
}

}  // namespace cairn
