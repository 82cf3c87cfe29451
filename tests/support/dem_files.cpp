#include "tests/support/dem_files.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include <catch2/catch.hpp>
#include <tiffio.h>
#include <zlib.h>

#include "builder/raster/height_encoding.h"
#include "format/bytes.h"

namespace cairn::test {
namespace {

namespace fs = std::filesystem;

void put_big16(Bytes& out, int value) {
  out.push_back(static_cast<std::byte>(value >> 8 & 255));
  out.push_back(static_cast<std::byte>(value & 255));
}

void put_text(Bytes& out, const std::string& text) {
  for (const char c : text) out.push_back(static_cast<std::byte>(c));
}

Bytes deflated(const Bytes& bytes, int window_bits) {
  z_stream stream{};
  if (deflateInit2(&stream, 6, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::runtime_error("zlib");
  Bytes out(deflateBound(&stream, bytes.size()) + 64);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

std::string degrees(int value, int width, char negative, char positive) {
  std::string digits = std::to_string(std::abs(value));
  digits.insert(0, static_cast<std::size_t>(std::max(0, width - static_cast<int>(digits.size()))), '0');
  return digits + "0000" + (value < 0 ? negative : positive);
}

std::string padded(int value, int width) {
  std::string digits = std::to_string(value);
  return std::string(static_cast<std::size_t>(width) - digits.size(), '0') + digits;
}

template <class T>
void put_sample(std::byte* at, double value) {
  const T sample = static_cast<T>(value);
  std::memcpy(at, &sample, sizeof sample);
}

void put_sample(std::byte* at, SampleType type, double value) {
  switch (type) {
    case SampleType::uint8:
      return put_sample<std::uint8_t>(at, value);
    case SampleType::int8:
      return put_sample<std::int8_t>(at, value);
    case SampleType::uint16:
      return put_sample<std::uint16_t>(at, value);
    case SampleType::int16:
      return put_sample<std::int16_t>(at, value);
    case SampleType::uint32:
      return put_sample<std::uint32_t>(at, value);
    case SampleType::int32:
      return put_sample<std::int32_t>(at, value);
    case SampleType::float32:
      return put_sample<float>(at, value);
    case SampleType::float64:
      return put_sample<double>(at, value);
  }
}

/// The samples of a rectangle, `bands` of them a pixel from band `band` on; past the image's edge they repeat
/// zero.
Bytes block(const TiffRecipe& r, int band, int bands, int left, int top, int columns, int rows) {
  const std::size_t size = size_of(r.type);
  const int bits = r.bits == 0 ? static_cast<int>(8 * size) : r.bits;
  const std::size_t row_bytes = (static_cast<std::size_t>(columns * bands * bits) + 7) / 8;
  Bytes out(row_bytes * static_cast<std::size_t>(rows));
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x)
      for (int b = 0; b < bands; ++b) {
        const bool inside = left + x < r.columns && top + y < r.rows;
        const double value = !inside    ? 0
                             : r.sample ? r.sample(band + b, left + x, top + y)
                                        : test_height(left + x, top + y);
        std::byte* row = out.data() + static_cast<std::size_t>(y) * row_bytes;
        const auto i = static_cast<std::size_t>(x * bands + b);
        if (bits >= 8) {
          put_sample(row + i * size, r.type, value);
        } else {
          const std::size_t bit = i * static_cast<std::size_t>(bits);
          row[bit / 8] |= static_cast<std::byte>(static_cast<unsigned>(value)
                                                 << (8 - static_cast<unsigned>(bits) - bit % 8));
        }
      }
  return out;
}

void write_pixels(TIFF* tiff, const TiffRecipe& r) {
  const int planes = r.planar ? r.bands : 1, together = r.planar ? 1 : r.bands;
  for (int plane = 0; plane < planes; ++plane) {
    if (r.tile > 0) {
      for (int top = 0; top < r.rows; top += r.tile)
        for (int left = 0; left < r.columns; left += r.tile) {
          if (r.leave_out_last_tile && top + r.tile >= r.rows && left + r.tile >= r.columns) continue;
          Bytes tile = block(r, plane, together, left, top, r.tile, r.tile);
          TIFFWriteTile(tiff, tile.data(), static_cast<std::uint32_t>(left), static_cast<std::uint32_t>(top),
                        0, static_cast<std::uint16_t>(plane));
        }
    } else {
      for (int row = 0; row < r.rows; ++row) {
        Bytes line = block(r, plane, together, 0, row, r.columns, 1);
        TIFFWriteScanline(tiff, line.data(), static_cast<std::uint32_t>(row),
                          static_cast<std::uint16_t>(plane));
      }
    }
  }
}

void declare_tags(TIFF* tiff) {
  static char name[] = "GeoTIFF";
  static const TIFFFieldInfo fields[] = {
      {33550, -1, -1, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1, name},
      {33922, -1, -1, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1, name},
      {34264, -1, -1, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1, name},
      {34735, -1, -1, TIFF_SHORT, FIELD_CUSTOM, 1, 1, name},
      {34736, -1, -1, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1, name},
      {34737, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, name},
      {42112, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, name},
      {42113, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, name},
  };
  TIFFMergeFieldInfo(tiff, fields, 8);
}

void write_keys(TIFF* tiff, const TiffRecipe& r) {
  std::map<int, std::vector<std::uint16_t>> entries;
  std::vector<double> doubles;
  const auto u16 = [](auto v) { return static_cast<std::uint16_t>(v); };
  for (const auto& [key, value] : r.keys) entries[key] = {u16(key), 0, 1, u16(value)};
  for (const auto& [key, value] : r.double_keys) {
    entries[key] = {u16(key), 34736, 1, u16(doubles.size())};
    doubles.push_back(value);
  }
  if (!r.citation.empty()) entries[1026] = {1026, 34737, u16(r.citation.size() + 1), 0};
  if (entries.empty()) return;
  std::vector<std::uint16_t> directory{1, 1, 0, u16(entries.size())};
  for (const auto& [key, entry] : entries) directory.insert(directory.end(), entry.begin(), entry.end());
  TIFFSetField(tiff, 34735, static_cast<int>(directory.size()), directory.data());
  if (!doubles.empty()) TIFFSetField(tiff, 34736, static_cast<int>(doubles.size()), doubles.data());
  if (!r.citation.empty()) TIFFSetField(tiff, 34737, (r.citation + "|").c_str());
}

void write_layout(TIFF* tiff, const TiffRecipe& r) {
  const bool floating = r.type == SampleType::float32 || r.type == SampleType::float64;
  const bool is_signed =
      r.type == SampleType::int8 || r.type == SampleType::int16 || r.type == SampleType::int32;
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, r.columns);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, r.rows);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, r.bands);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, r.bits == 0 ? static_cast<int>(8 * size_of(r.type)) : r.bits);
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT,
               floating    ? SAMPLEFORMAT_IEEEFP
               : is_signed ? SAMPLEFORMAT_INT
                           : SAMPLEFORMAT_UINT);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, r.planar ? PLANARCONFIG_SEPARATE : PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, r.photometric);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, r.compression);
  if (r.predictor != 1) TIFFSetField(tiff, TIFFTAG_PREDICTOR, r.predictor);
  if (r.photometric == PHOTOMETRIC_YCBCR) TIFFSetField(tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
  if (!r.extra_samples.empty())
    TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, static_cast<int>(r.extra_samples.size()),
                 r.extra_samples.data());
  if (r.photometric == PHOTOMETRIC_PALETTE) {
    std::vector<std::uint16_t> ramp(std::size_t{1} << (r.bits == 0 ? 8 : r.bits));
    for (std::size_t i = 0; i < ramp.size(); ++i) ramp[i] = static_cast<std::uint16_t>(i * 257);
    std::vector<std::uint16_t> down(ramp.rbegin(), ramp.rend());
    TIFFSetField(tiff, TIFFTAG_COLORMAP, ramp.data(), down.data(), ramp.data());
  }
  if (r.tile > 0) {
    TIFFSetField(tiff, TIFFTAG_TILEWIDTH, r.tile);
    TIFFSetField(tiff, TIFFTAG_TILELENGTH, r.tile);
  } else {
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, r.rows_per_strip);
  }
}

}  // namespace

void write_text(const fs::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

int test_height(std::int64_t column, std::int64_t row) {
  const double x = static_cast<double>(column), y = static_cast<double>(row);
  return static_cast<int>(1350 + 1000 * std::sin(x / 17) + 600 * std::cos(y / 11 + x / 50) +
                          static_cast<double>((column * 7 + row * 13) % 41));
}

Bytes hgt_bytes(int posts, const std::function<int(std::int64_t, std::int64_t)>& height) {
  Bytes out;
  out.reserve(static_cast<std::size_t>(2 * posts * posts));
  for (int r = 0; r < posts; ++r)
    for (int c = 0; c < posts; ++c) put_big16(out, height(c, r));
  return out;
}

Bytes gzipped(const Bytes& bytes) {
  return deflated(bytes, MAX_WBITS + 16);
}

Bytes zipped(const std::vector<ZipMember>& members) {
  Bytes out, directory;
  ByteWriter file(out), list(directory);
  for (const ZipMember& m : members) {
    const Bytes packed = m.deflate ? deflated(m.bytes, -MAX_WBITS) : m.bytes;
    const auto sum = static_cast<std::uint32_t>(
        crc32(0, reinterpret_cast<const Bytef*>(m.bytes.data()), static_cast<uInt>(m.bytes.size())));
    const auto at = static_cast<std::uint32_t>(out.size());
    const auto common = [&](ByteWriter& w) {
      w.write<std::uint16_t>(20), w.write<std::uint16_t>(0), w.write<std::uint16_t>(m.deflate ? 8 : 0),
          w.write<std::uint32_t>(0);
      w.write(sum), w.write(static_cast<std::uint32_t>(packed.size())),
          w.write(static_cast<std::uint32_t>(m.bytes.size()));
      w.write(static_cast<std::uint16_t>(m.name.size())), w.write<std::uint16_t>(0);
    };
    file.write<std::uint32_t>(0x04034b50), common(file);
    put_text(out, m.name);
    out.insert(out.end(), packed.begin(), packed.end());
    list.write<std::uint32_t>(0x02014b50), list.write<std::uint16_t>(20), common(list);
    list.write<std::uint16_t>(0), list.write<std::uint16_t>(0), list.write<std::uint16_t>(0),
        list.write<std::uint32_t>(0), list.write(at);
    put_text(directory, m.name);
  }
  const auto start = static_cast<std::uint32_t>(out.size());
  out.insert(out.end(), directory.begin(), directory.end());
  const auto count = static_cast<std::uint16_t>(members.size());
  file.write<std::uint32_t>(0x06054b50), file.write<std::uint32_t>(0), file.write(count), file.write(count);
  file.write(static_cast<std::uint32_t>(directory.size())), file.write(start), file.write<std::uint16_t>(0);
  return out;
}

Bytes dted_bytes(const DtedRecipe& d) {
  Bytes out;
  put_text(out, "UHL1" + degrees(d.lon, 3, 'W', 'E') + degrees(d.lat, 3, 'S', 'N') +
                    padded(d.lon_interval, 4) + padded(d.lat_interval, 4) + "0000" + "U  " + "            " +
                    padded(d.columns, 4) + padded(d.rows, 4) + "0");
  out.resize(80, std::byte{' '});
  out.resize(80 + 648 + 2700, std::byte{' '});
  for (int c = 0; c < d.columns; ++c) {
    const std::size_t start = out.size();
    out.push_back(std::byte{0xAA});
    out.push_back(std::byte{0});
    put_big16(out, c);
    put_big16(out, c);
    put_big16(out, 0);
    for (int r = d.rows - 1; r >= 0; --r) {
      const int h = d.height(c, r);
      put_big16(out, h >= 0 ? h : d.twos_complement ? h & 0xFFFF : 0x8000 | -h);
    }
    std::uint32_t sum = 0;
    for (std::size_t i = start; i < out.size(); ++i) sum += std::to_integer<std::uint32_t>(out[i]);
    put_big16(out, static_cast<int>(sum >> 16));
    put_big16(out, static_cast<int>(sum & 0xFFFF));
  }
  return out;
}

void write_tiff(const fs::path& path, const TiffRecipe& r) {
  const std::string mode = std::string("w") + (r.big_endian ? "b" : "l") + (r.big_tiff ? "8" : "");
  TIFF* tiff = TIFFOpen(path.c_str(), mode.c_str());
  if (tiff == nullptr) throw std::runtime_error("cannot write " + path.string());
  declare_tags(tiff);
  write_layout(tiff, r);
  if (!r.pixel_scale.empty())
    TIFFSetField(tiff, 33550, static_cast<int>(r.pixel_scale.size()), r.pixel_scale.data());
  if (!r.tiepoint.empty()) TIFFSetField(tiff, 33922, static_cast<int>(r.tiepoint.size()), r.tiepoint.data());
  if (!r.transformation.empty()) TIFFSetField(tiff, 34264, 16, r.transformation.data());
  write_keys(tiff, r);
  if (!r.gdal_metadata.empty()) TIFFSetField(tiff, 42112, r.gdal_metadata.c_str());
  if (!r.nodata.empty()) TIFFSetField(tiff, 42113, r.nodata.c_str());
  write_pixels(tiff, r);
  if (r.mask) {
    TIFFWriteDirectory(tiff);
    TiffRecipe mask;
    mask.columns = r.columns;
    mask.rows = r.rows;
    mask.type = SampleType::uint8;
    mask.bits = 1;
    mask.photometric = PHOTOMETRIC_MASK;
    mask.sample = [](int, std::int64_t column, std::int64_t) { return column % 2 == 0 ? 1.0 : 0.0; };
    TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, FILETYPE_MASK);
    write_layout(tiff, mask);
    write_pixels(tiff, mask);
  }
  TIFFClose(tiff);
}

std::vector<float> all_heights(const RasterSource& source) {
  const RasterInfo& info = source.info();
  std::vector<float> heights(static_cast<std::size_t>(info.columns * info.rows));
  const Status read = source.read_heights({0, 0, info.columns, info.rows}, heights);
  if (!read) FAIL(read.error().message);
  return heights;
}

std::vector<std::uint8_t> all_colours(const RasterSource& source) {
  const RasterInfo& info = source.info();
  std::vector<std::uint8_t> rgba(static_cast<std::size_t>(4 * info.columns * info.rows));
  const Status read = source.read_colours({0, 0, info.columns, info.rows}, rgba);
  if (!read) FAIL(read.error().message);
  return rgba;
}

std::unique_ptr<RasterSource> opened(const fs::path& path, const OpenOptions& options) {
  auto source = open_raster(path, options);
  if (!source) FAIL(source.error().message);
  return std::move(*source);
}

std::string complaint_of(const fs::path& path, const OpenOptions& options) {
  const auto source = open_raster(path, options);
  if (!source) return source.error().message;
  const RasterInfo& info = (*source)->info();
  constexpr std::int64_t kMost = 16 << 20;  // of a raster whose size lies
  const std::int64_t rows = std::min(info.rows, std::max<std::int64_t>(1, kMost / info.columns));
  const std::int64_t columns = std::min(info.columns, kMost);
  std::vector<float> heights(static_cast<std::size_t>(columns * rows));
  for (const std::int64_t top : {std::int64_t{0}, info.rows - rows}) {
    const Status read = (*source)->read_heights({0, top, columns, rows}, heights);
    if (!read) return read.error().message;
  }
  return {};
}

}  // namespace cairn::test
