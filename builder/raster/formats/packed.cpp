// A raster of any other format in a gzip file, or alone in a zip archive. It is unpacked to a temporary
// folder while it is open, with the files of its own name beside it (world file, .prj, .hdr, .aux.xml), and
// opened there by the reader that claims it.
#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "builder/raster/io/gzip_file.h"
#include "builder/raster/io/printable.h"
#include "builder/raster/io/temp_folder.h"
#include "builder/raster/io/zip_archive.h"
#include "builder/raster/packed_raster.h"
#include "builder/raster/raster_names.h"
#include "builder/raster/raster_source.h"
#include "format/file.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

/// What may lie beside a gzipped raster and say more of it.
constexpr std::array kSideCars = {".prj", ".hdr", ".tfw", ".wld", ".aux.xml", ".clr"};

/// Errors speak of the packed file, not of the folder that it is unpacked to.
struct Places {
  fs::path packed;
  fs::path unpacked;

  Error error(Error error) const {
    const std::string there = unpacked.string();
    const std::string here = packed.string() + ": " + printable(unpacked.filename().string());
    for (std::size_t at = error.message.find(there); at != std::string::npos;
         at = error.message.find(there, at + here.size()))
      error.message.replace(at, there.size(), here);
    return error;
  }
  Status status(const Status& status) const { return status ? status : Status(error(status.error())); }
};

class PackedSource final : public RasterSource {
 public:
  PackedSource(Places places, TempFolder folder, std::unique_ptr<RasterSource> raster)
      : RasterSource(raster->info()),
        places_(std::move(places)),
        folder_(std::move(folder)),
        raster_(std::move(raster)) {
    info_.path = places_.packed;
  }

  Status read_heights(const PostWindow& window, std::span<float> out) const override {
    return places_.status(raster_->read_heights(window, out));
  }
  Status read_colours(const PostWindow& window, std::span<std::uint8_t> rgba) const override {
    return places_.status(raster_->read_colours(window, rgba));
  }

 private:
  Places places_;
  TempFolder folder_;
  std::unique_ptr<RasterSource> raster_;  // closed before its folder is removed
};

/// Unpacks to a new file through `unpack`, which takes a sink.
template <class Unpack>
Status unpack_to(const fs::path& path, const Unpack& unpack) {
  auto file = File::open_to_write(path);
  if (!file) return file.error();
  std::uint64_t written = 0;
  return unpack([&](std::span<const std::byte> bytes) -> Status {
    if (auto status = file->write(written, bytes); !status) return status;
    written += bytes.size();
    return {};
  });
}

Result<ZipEntry> only_raster_in(const fs::path& path) {
  const auto rasters = rasters_in_zip(path);
  if (!rasters) return rasters.error();
  if (rasters->size() == 1) return rasters->front();
  std::string found = rasters->empty() ? "none" : "";
  for (std::size_t i = 0; i < std::min<std::size_t>(rasters->size(), 3); ++i)
    found += (i > 0 ? ", " : "") + printable((*rasters)[i].name);
  if (rasters->size() > 3) found += fmt::format(" and {} more", rasters->size() - 3);
  return bad_data(path.string() + ": expected one raster in the archive, found " + found);
}

/// Returns the raster's path in the folder.
Result<fs::path> unpack_archive(const fs::path& path, const fs::path& folder) {
  const auto raster = only_raster_in(path);
  if (!raster) return raster.error();
  const auto entries = list_zip(path);
  if (!entries) return entries.error();
  const fs::path raster_name = fs::path(raster->name).filename();
  for (const ZipEntry& entry : *entries) {
    const fs::path name = fs::path(entry.name).filename();
    const bool is_raster = entry.index == raster->index;
    const bool beside =
        !is_raster && name != raster_name && name.string().starts_with(raster_name.stem().string() + ".");
    if (!is_raster && !beside) continue;
    const Status status =
        unpack_to(folder / name, [&](const ByteSink& sink) { return unpack_zip_entry(path, entry, sink); });
    if (!status) return status.error();
  }
  return folder / raster_name;
}

void link_side_cars(const fs::path& path, const fs::path& folder) {
  std::error_code error;
  const fs::path absolute = fs::absolute(path, error);
  const fs::path raster = fs::path(absolute).replace_extension();
  for (const char* side_car : kSideCars) {
    for (const fs::path& stem : {raster, fs::path(raster).replace_extension()}) {
      const fs::path beside = fs::path(stem).concat(side_car);
      if (fs::exists(beside, error)) fs::create_symlink(beside, folder / beside.filename(), error);
    }
  }
}

Status refuse_tar(const fs::path& path, const fs::path& unpacked) {
  constexpr std::uint64_t kMarkAt = 257;
  std::array<std::byte, 5> mark{};
  const auto file = File::open_to_read(unpacked);
  if (!file || !file->read(kMarkAt, mark) || std::memcmp(mark.data(), "ustar", mark.size()) != 0) return {};
  return bad_data(path.string() + ": expected a packed raster, found a packed tar archive: unpack it first");
}

Result<fs::path> unpack_gzipped(const fs::path& path, const fs::path& folder) {
  const fs::path unpacked = folder / path.stem().filename();
  const Status status = unpack_to(unpacked, [&](const ByteSink& sink) { return unpack_gzip(path, sink); });
  if (!status) return status.error();
  if (auto refused = refuse_tar(path, unpacked); !refused) return refused.error();
  link_side_cars(path, folder);
  return unpacked;
}

bool claims(const fs::path& path, std::span<const std::byte>) {
  return is_zip_name(path) || is_gzip_name(path);
}

Result<std::unique_ptr<RasterSource>> open(const fs::path& path, const OpenOptions& options) {
  auto folder = TempFolder::make();
  if (!folder) return folder.error();
  const auto unpacked =
      is_zip_name(path) ? unpack_archive(path, folder->path()) : unpack_gzipped(path, folder->path());
  if (!unpacked) return unpacked.error();
  const Places places{path, *unpacked};
  OpenOptions inside = options;  // its overrides are those of the packed file's name
  inside.rules.clear();
  auto raster = open_raster(*unpacked, inside);
  if (!raster) return places.error(raster.error());
  std::unique_ptr<RasterSource> source =
      std::make_unique<PackedSource>(places, std::move(*folder), std::move(*raster));
  return source;
}

}  // namespace

extern const RasterFormat packed_format;
const RasterFormat packed_format = {"packed", 15, claims, open, true};

extern const RasterNames packed_names;
const RasterNames packed_names = {};

}  // namespace cairn
