// SRTM's .hgt: the posts of one 1° cell, big-endian int16, north to south, and nothing else; the name says
// which cell. Plain, gzipped (.hgt.gz), or alone in a zip archive; packed ones need no temporary file.
#include <algorithm>
#include <array>
#include <cctype>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include <fmt/format.h>

#include "builder/raster/height_tags.h"
#include "builder/raster/io/gzip_file.h"
#include "builder/raster/io/input_file.h"
#include "builder/raster/io/printable.h"
#include "builder/raster/io/scratch_bytes.h"
#include "builder/raster/io/zip_archive.h"
#include "builder/raster/pam_sidecar.h"
#include "builder/raster/raster_names.h"
#include "builder/raster/raster_placement.h"
#include "builder/raster/raster_source.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr double kNodata = -32768;
constexpr std::array kExtensions = {".hgt"};

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

struct Cell {
  int south = 0;
  int west = 0;
  friend bool operator==(const Cell&, const Cell&) = default;
};

/// The cell of a name that begins as N36E028 does.
std::optional<Cell> cell_of(const fs::path& path) {
  const std::string name = lower(path.filename().string());
  const auto digit = [&](std::size_t i) { return name[i] >= '0' && name[i] <= '9'; };
  if (name.size() < 8 || (name[0] != 'n' && name[0] != 's') || (name[3] != 'e' && name[3] != 'w'))
    return std::nullopt;
  if (!digit(1) || !digit(2) || !digit(4) || !digit(5) || !digit(6) ||
      std::isalnum(static_cast<unsigned char>(name[7])))
    return std::nullopt;
  Cell cell{std::stoi(name.substr(1, 2)), std::stoi(name.substr(4, 3))};
  if (name[0] == 's') cell.south = -cell.south;
  if (name[3] == 'w') cell.west = -cell.west;
  if (cell.south < -90 || cell.south > 89 || cell.west < -180 || cell.west > 179) return std::nullopt;
  return cell;
}

struct CellSize {
  std::int64_t columns = 0;
  std::int64_t rows = 0;
};

/// 3", 1", 1/2" and 1/3"; and 1" with every second meridian, as SRTM has it from 50° of latitude.
std::optional<CellSize> size_of(std::uint64_t bytes) {
  for (const CellSize size : {CellSize{1201, 1201}, CellSize{3601, 3601}, CellSize{7201, 7201},
                              CellSize{10801, 10801}, CellSize{1801, 3601}})
    if (bytes == static_cast<std::uint64_t>(2 * size.columns * size.rows)) return size;
  return std::nullopt;
}

/// What stands around the posts in the file.
struct Plain {};
struct Gzip {};
using Packing = std::variant<Plain, Gzip, ZipEntry>;

struct Contents {
  Packing packing;
  std::uint64_t bytes = 0;
};

bool is_hgt(const ZipEntry& entry) {
  return lower(entry.name).ends_with(".hgt");
}

Result<Contents> look_into_zip(const fs::path& path) {
  const auto entries = list_zip(path);
  if (!entries) return entries.error();
  const auto found = std::find_if(entries->begin(), entries->end(), is_hgt);
  if (found == entries->end())
    return bad_data(path.string() + ": expected a .hgt in the archive, found none");
  if (std::find_if(found + 1, entries->end(), is_hgt) != entries->end())
    return bad_data(path.string() + ": expected one .hgt in the archive, found several");
  return Contents{*found, found->bytes};
}

/// A gzip file ends with its contents' length, modulo 2^32.
Result<Contents> look_into_gzip(const InputFile& file) {
  constexpr std::uint64_t kLeast = 18;
  if (file.size() < kLeast)
    return bad_data(
        fmt::format("{}: expected a gzip file, found {} bytes", file.path().string(), file.size()));
  std::uint32_t bytes = 0;
  if (auto read = file.read_at(file.size() - 4, std::as_writable_bytes(std::span(&bytes, 1))); !read)
    return read.error();
  return Contents{Gzip{}, bytes};
}

Result<Contents> look_into(const InputFile& file) {
  const std::string name = lower(file.path().filename().string());
  if (name.ends_with(".zip")) return look_into_zip(file.path());
  if (name.ends_with(".gz")) return look_into_gzip(file);
  return Contents{Plain{}, file.size()};
}

/// The name of an archive's entry without its folders.
fs::path file_name_of(const ZipEntry& entry) {
  return fs::path(entry.name).filename();
}

/// The cell by the file's name, by the name inside the archive, or by both where they agree.
Result<Cell> agreed_cell(const fs::path& path, const Packing& packing) {
  const auto* entry = std::get_if<ZipEntry>(&packing);
  const auto outer = cell_of(path);
  const auto inner = entry != nullptr ? cell_of(file_name_of(*entry)) : std::nullopt;
  if (outer && inner && !(*outer == *inner))
    return bad_data(fmt::format("{}: expected the archive's own cell, found {} in it", path.string(),
                                printable(entry->name)));
  if (outer) return *outer;
  if (inner) return *inner;
  return bad_data(path.string() + ": name: expected a cell such as N36E028.hgt, found none that is on Earth");
}

class HgtSource final : public RasterSource {
 public:
  HgtSource(RasterInfo info, const HeightEncoding& encoding, InputFile file, Packing packing,
            std::size_t cache_bytes)
      : RasterSource(std::move(info)),
        encoding_(encoding),
        file_(std::move(file)),
        packing_(std::move(packing)),
        unpacked_(cache_bytes) {}

  Status read_heights(const PostWindow& window, std::span<float> out) const override;
  Status read_colours(const PostWindow&, std::span<std::uint8_t>) const override {
    return bad_data(info_.path.string() + ": expected an image, found heights (hgt)");
  }

 private:
  Status prepare() const;
  Status unpack() const;
  Status check_plausible() const;
  Status read_at(std::uint64_t offset, std::span<std::byte> out) const {
    return std::holds_alternative<Plain>(packing_) ? file_.read_at(offset, out)
                                                   : unpacked_.read_at(offset, out);
  }

  HeightEncoding encoding_;
  InputFile file_;
  Packing packing_;
  mutable std::once_flag once_;
  mutable Status prepared_;
  mutable ScratchBytes unpacked_;
};

Status HgtSource::prepare() const {
  std::call_once(once_, [this] {
    prepared_ = unpack();
    if (prepared_) prepared_ = check_plausible();
  });
  return prepared_;
}

Status HgtSource::unpack() const {
  const auto expected = static_cast<std::uint64_t>(2 * info_.columns * info_.rows);
  const fs::path& path = file_.path();
  const auto too = [&](const char* found) {
    return bad_data(fmt::format("{}: expected {} bytes inside, found {}", path.string(), expected, found));
  };
  const ByteSink keep = [&](std::span<const std::byte> bytes) -> Status {
    return unpacked_.size() + bytes.size() > expected ? Status(too("more")) : unpacked_.append(bytes);
  };
  Status status;
  if (const auto* entry = std::get_if<ZipEntry>(&packing_)) status = unpack_zip_entry(path, *entry, keep);
  if (std::holds_alternative<Gzip>(packing_)) status = unpack_gzip(path, keep);
  if (!status || std::holds_alternative<Plain>(packing_)) return status;
  return unpacked_.size() == expected ? Status() : Status(too("fewer"));
}

/// The format has no mark to know it by. Bytes that are something else, or in the other order, show as
/// heights that no place has.
Status HgtSource::check_plausible() const {
  constexpr std::int64_t kRowsLookedAt = 16;
  std::vector<std::byte> row(static_cast<std::size_t>(2 * info_.columns));
  std::vector<float> metres(static_cast<std::size_t>(info_.columns));
  std::int64_t heights = 0, impossible = 0;
  for (std::int64_t i = 0; i < kRowsLookedAt; ++i) {
    const std::int64_t r = i * (info_.rows - 1) / (kRowsLookedAt - 1);
    if (auto read = read_at(static_cast<std::uint64_t>(r) * row.size(), row); !read) return read;
    decode_heights({.swapped = true}, row.data(), metres.size(), 1, metres.data());
    for (const float m : metres) {
      heights += m == m;
      impossible += m < -12000 || m > 9000;
    }
  }
  if (4 * impossible <= heights) return {};
  return bad_data(fmt::format("{}: expected heights from -12000 to 9000 m, found {} of {} outside",
                              info_.path.string(), impossible, heights));
}

Status HgtSource::read_heights(const PostWindow& window, std::span<float> out) const {
  if (auto prepared = prepare(); !prepared) return prepared;
  const auto columns = static_cast<std::size_t>(window.columns);
  std::vector<std::byte> row(2 * columns);
  for (std::int64_t r = 0; r < window.rows; ++r) {
    const std::int64_t at = 2 * ((window.row + r) * info_.columns + window.column);
    if (auto read = read_at(static_cast<std::uint64_t>(at), row); !read) return read;
    decode_heights(encoding_, row.data(), columns, 1, out.data() + static_cast<std::size_t>(r) * columns);
  }
  return {};
}

bool claims(const fs::path& path, std::span<const std::byte>) {
  const std::string name = lower(path.filename().string());
  if (name.ends_with(".hgt") || name.ends_with(".hgt.gz")) return true;
  if (!name.ends_with(".zip")) return false;
  const auto entries = list_zip(path);
  return entries && std::any_of(entries->begin(), entries->end(), is_hgt);
}

Result<std::unique_ptr<RasterSource>> open(const fs::path& path, const OpenOptions& options) {
  auto file = InputFile::open(path);
  if (!file) return file.error();
  auto contents = look_into(*file);
  if (!contents) return contents.error();
  const auto cell = agreed_cell(path, contents->packing);
  if (!cell) return cell.error();
  const auto size = size_of(contents->bytes);
  if (!size)
    return bad_data(fmt::format(
        "{}: size: expected the bytes of 1201×1201, 3601×3601, 1801×3601, 7201×7201 or 10801×10801 posts, "
        "found {}",
        path.string(), contents->bytes));
  HeightTags tags;
  tags.nodata = kNodata;
  apply_pam(read_pam_beside(path, 1), tags);
  apply_overrides(options.overrides, tags);
  if (auto band = check_band(path, 1, options.overrides); !band) return band.error();
  auto encoding = height_encoding_of(path, SampleType::int16, tags);
  if (!encoding) return encoding.error();
  encoding->swapped = true;
  RasterInfo info;
  info.path = path;
  info.format = "hgt";
  info.columns = size->columns;
  info.rows = size->rows;
  info.whole_metres = encoding->whole_metres();
  info.nodata = encoding->nodata;
  info.unit = tags.unit;
  info.overrides = options.overrides;
  info.georeference.x0 = cell->west;
  info.georeference.y0 = cell->south + 1;
  info.georeference.dx = 1.0 / static_cast<double>(size->columns - 1);
  info.georeference.dy = -1.0 / static_cast<double>(size->rows - 1);
  if (auto placed = place_raster(info); !placed) return placed.error();
  std::unique_ptr<RasterSource> source = std::make_unique<HgtSource>(
      std::move(info), *encoding, std::move(*file), std::move(contents->packing), options.cache_bytes);
  return source;
}

}  // namespace

extern const RasterFormat hgt_format;
const RasterFormat hgt_format = {"hgt", 10, claims, open, true};

extern const RasterNames hgt_names;
const RasterNames hgt_names = {kExtensions};

}  // namespace cairn
