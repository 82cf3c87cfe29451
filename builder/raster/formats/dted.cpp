// DTED levels 0, 1 and 2, after MIL-PRF-89020B: one column of posts a record, from south to north, columns
// from west to east.
#include <array>
#include <cstring>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "builder/raster/crs.h"
#include "builder/raster/height_tags.h"
#include "builder/raster/io/chunk_cache.h"
#include "builder/raster/io/input_file.h"
#include "builder/raster/io/printable.h"
#include "builder/raster/pam_sidecar.h"
#include "builder/raster/raster_names.h"
#include "builder/raster/raster_placement.h"
#include "builder/raster/raster_source.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr double kNodata = -32767;
constexpr std::array kExtensions = {".dt0", ".dt1", ".dt2"};
constexpr std::size_t kLabelBytes = 80;
constexpr std::size_t kHeaderBytes = 80 + 648 + 2700;  // UHL, DSI, ACC
constexpr std::size_t kRecordHeader = 8;
constexpr std::size_t kChecksum = 4;
constexpr std::byte kSentinel{0xAA};

/// The user header label: where the data begin and how they lie.
struct Header {
  std::uint64_t data_offset = 0;
  double west = 0;
  double south = 0;
  std::int64_t lon_interval = 0;  // tenths of an arc second
  std::int64_t lat_interval = 0;
  std::int64_t columns = 0;
  std::int64_t rows = 0;
  bool above_egm96 = false;
  bool on_wgs72 = false;  // else on WGS84
};

std::optional<std::int64_t> digits(std::string_view text) {
  std::int64_t value = 0;
  bool any = false;
  for (const char c : text) {
    if (c == ' ' && !any) continue;
    if (c < '0' || c > '9') return std::nullopt;
    value = value * 10 + (c - '0');
    any = true;
  }
  return any ? std::optional(value) : std::nullopt;
}

/// DDDMMSSH, up to `most` degrees either way.
std::optional<double> angle(std::string_view text, double most, char negative, char positive) {
  const auto d = digits(text.substr(0, 3)), m = digits(text.substr(3, 2)), s = digits(text.substr(5, 2));
  const char side = text[7];
  if (!d || !m || !s || *m > 59 || *s > 59 || (side != negative && side != positive)) return std::nullopt;
  const double value = static_cast<double>(*d * 3600 + *m * 60 + *s) / 3600;
  if (value > most) return std::nullopt;
  return side == negative ? -value : value;
}

/// Tape labels (VOL, HDR), which some files still carry, stand before the header.
std::uint64_t skip_labels(std::string_view bytes) {
  std::size_t at = 0;
  while (bytes.size() >= at + kLabelBytes) {
    const auto kind = bytes.substr(at, 3);
    if (kind != "VOL" && kind != "HDR") break;
    at += kLabelBytes;
  }
  return at;
}

Result<Header> parse_header(const fs::path& path, std::string_view label, std::uint64_t offset) {
  const auto bad = [&](const char* what, std::string_view found) {
    return bad_data(
        fmt::format("{}: header: expected {}, found \"{}\"", path.string(), what, printable(found)));
  };
  if (!label.starts_with("UHL1")) return bad("UHL1", label.substr(0, 4));
  const auto west = angle(label.substr(4, 8), 180, 'W', 'E');
  if (!west) return bad("a longitude DDDMMSSH", label.substr(4, 8));
  const auto south = angle(label.substr(12, 8), 90, 'S', 'N');
  if (!south) return bad("a latitude DDDMMSSH", label.substr(12, 8));
  const auto dx = digits(label.substr(20, 4)), dy = digits(label.substr(24, 4));
  if (!dx || !dy || *dx == 0 || *dy == 0) return bad("intervals in tenths of a second", label.substr(20, 8));
  const auto columns = digits(label.substr(47, 4)), rows = digits(label.substr(51, 4));
  if (!columns || !rows || *columns == 0 || *rows == 0)
    return bad("counts of columns and rows", label.substr(47, 8));
  return Header{offset + kHeaderBytes, *west, *south, *dx, *dy, *columns, *rows};
}

/// The data set identification, the label after the first, names the datums (MIL-PRF-89020B, table III).
void read_datums(std::string_view identification, Header& header) {
  constexpr std::size_t kVertical = 141, kHorizontal = 144;
  if (!identification.starts_with("DSI") || identification.size() < kHorizontal + 5) return;
  header.above_egm96 = identification.substr(kVertical, 3) == "E96";
  header.on_wgs72 = identification.substr(kHorizontal, 5) == "WGS72";
}

Result<Header> read_header(const InputFile& file) {
  std::array<char, 16 * kLabelBytes> first{};
  const std::size_t count = std::min<std::size_t>(first.size(), static_cast<std::size_t>(file.size()));
  if (auto read = file.read_at(0, std::as_writable_bytes(std::span(first).first(count))); !read)
    return read.error();
  const std::string_view bytes(first.data(), count);
  const std::uint64_t at = skip_labels(bytes);
  if (at + kLabelBytes > count)
    return bad_data(fmt::format("{}: expected a header of {} bytes, found {}", file.path().string(),
                                kHeaderBytes, file.size()));
  auto header = parse_header(file.path(), bytes.substr(at, kLabelBytes), at);
  if (header) read_datums(bytes.substr(at + kLabelBytes), *header);
  return header;
}

std::size_t record_bytes(const RasterInfo& info) {
  return kRecordHeader + 2 * static_cast<std::size_t>(info.rows) + kChecksum;
}

unsigned big16(const std::byte* at) {
  return std::to_integer<unsigned>(at[0]) << 8 | std::to_integer<unsigned>(at[1]);
}

std::uint32_t big32(const std::byte* at) {
  return big16(at) << 16 | big16(at + 2);
}

/// Signed magnitude. Some producers wrote two's complement, which then reads as a depth that no place has
/// (GDAL's DTED reader knows the same); -32767 is the void.
std::int16_t elevation(unsigned raw) {
  const int magnitude = static_cast<int>(raw & 0x7FFF);
  const int value = (raw & 0x8000) != 0 ? -magnitude : magnitude;
  if (value < -16000 && value != -32767) return static_cast<std::int16_t>(static_cast<std::uint16_t>(raw));
  return static_cast<std::int16_t>(value);
}

class DtedSource final : public RasterSource {
 public:
  DtedSource(RasterInfo info, const HeightEncoding& encoding, InputFile file, std::uint64_t data_offset,
             std::size_t cache_bytes)
      : RasterSource(std::move(info)),
        encoding_(encoding),
        file_(std::move(file)),
        data_offset_(data_offset),
        columns_(cache_bytes) {}

  Status read_heights(const PostWindow& window, std::span<float> out) const override;
  Status read_colours(const PostWindow&, std::span<std::uint8_t>) const override {
    return bad_data(info_.path.string() + ": expected an image, found heights (DTED)");
  }

 private:
  Result<ChunkCache::Chunk> read_column(std::int64_t column) const;
  Status check_column(std::int64_t column, std::span<const std::byte> record) const;

  HeightEncoding encoding_;
  InputFile file_;
  std::uint64_t data_offset_;
  mutable ChunkCache columns_;
};

Status DtedSource::check_column(std::int64_t column, std::span<const std::byte> record) const {
  const std::string place = fmt::format("{}: column {}", info_.path.string(), column);
  if (record[0] != kSentinel)
    return bad_data(fmt::format("{}: expected a record's mark 0xAA, found {:#04x}", place,
                                std::to_integer<int>(record[0])));
  std::uint32_t sum = 0;
  for (const std::byte b : record.first(record.size() - kChecksum)) sum += std::to_integer<std::uint32_t>(b);
  const std::uint32_t stored = big32(record.data() + record.size() - kChecksum);
  if (sum != stored)
    return bad_data(fmt::format("{}: expected the checksum {}, found {}", place, stored, sum));
  return {};
}

/// The heights of a column as int16, south to north.
Result<ChunkCache::Chunk> DtedSource::read_column(std::int64_t column) const {
  std::vector<std::byte> record(record_bytes(info_));
  const std::uint64_t at = data_offset_ + static_cast<std::uint64_t>(column) * record.size();
  if (auto read = file_.read_at(at, record); !read) return read.error();
  if (auto checked = check_column(column, record); !checked) return checked.error();
  ChunkCache::Chunk heights(2 * static_cast<std::size_t>(info_.rows));
  for (std::size_t i = 0; i < heights.size(); i += 2) {
    const std::int16_t value = elevation(big16(record.data() + kRecordHeader + i));
    std::memcpy(heights.data() + i, &value, 2);
  }
  return heights;
}

Status DtedSource::read_heights(const PostWindow& window, std::span<float> out) const {
  const auto rows = static_cast<std::size_t>(window.rows), columns = static_cast<std::size_t>(window.columns);
  std::vector<float> metres(rows);
  for (std::size_t c = 0; c < columns; ++c) {
    const std::int64_t column = window.column + static_cast<std::int64_t>(c);
    const auto heights =
        columns_.get(static_cast<std::uint64_t>(column), [&] { return read_column(column); });
    if (!heights) return heights.error();
    const std::int64_t south = info_.rows - window.row - window.rows;
    decode_heights(encoding_, (*heights)->data() + 2 * south, rows, 1, metres.data());
    for (std::size_t r = 0; r < rows; ++r) out[(rows - 1 - r) * columns + c] = metres[r];
  }
  return {};
}

bool claims(const fs::path&, std::span<const std::byte> first_bytes) {
  const std::string_view bytes(reinterpret_cast<const char*>(first_bytes.data()), first_bytes.size());
  return bytes.substr(static_cast<std::size_t>(skip_labels(bytes))).starts_with("UHL");
}

Result<std::unique_ptr<RasterSource>> open(const fs::path& path, const OpenOptions& options) {
  auto file = InputFile::open(path);
  if (!file) return file.error();
  const auto header = read_header(*file);
  if (!header) return header.error();
  HeightTags tags;
  tags.nodata = kNodata;
  apply_pam(read_pam_beside(path, 1), tags);
  apply_overrides(options.overrides, tags);
  if (auto band = check_band(path, 1, options.overrides); !band) return band.error();
  const auto encoding = height_encoding_of(path, SampleType::int16, tags);
  if (!encoding) return encoding.error();
  RasterInfo info;
  info.path = path;
  info.format = "dted";
  info.columns = header->columns;
  info.rows = header->rows;
  info.whole_metres = encoding->whole_metres();
  info.nodata = encoding->nodata;
  info.unit = tags.unit;
  info.overrides = options.overrides;
  const double dx = static_cast<double>(header->lon_interval) / 36000;
  const double dy = static_cast<double>(header->lat_interval) / 36000;
  info.georeference.x0 = header->west;
  info.georeference.y0 = header->south + static_cast<double>(info.rows - 1) * dy;
  info.georeference.dx = dx;
  info.georeference.dy = -dy;
  constexpr int kEgm96Height = 5773;
  if (header->above_egm96) info.vertical = vertical_reference(kEgm96Height);
  if (header->on_wgs72) set_other_crs(info.georeference, "EPSG:4322");
  if (auto placed = place_raster(info); !placed) return placed.error();
  const std::uint64_t expected =
      header->data_offset + static_cast<std::uint64_t>(info.columns) * record_bytes(info);
  if (file->size() < expected)
    return bad_data(fmt::format("{}: size: expected {} bytes for {}×{} posts, found {}", path.string(),
                                expected, info.columns, info.rows, file->size()));
  std::unique_ptr<RasterSource> source = std::make_unique<DtedSource>(
      std::move(info), *encoding, std::move(*file), header->data_offset, options.cache_bytes);
  return source;
}

}  // namespace

extern const RasterFormat dted_format;
const RasterFormat dted_format = {"dted", 20, claims, open, true};

extern const RasterNames dted_names;
const RasterNames dted_names = {kExtensions};

}  // namespace cairn
