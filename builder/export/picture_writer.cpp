#include "builder/export/picture_writer.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "builder/export/jpeg_writer.h"
#include "builder/export/png_writer.h"

namespace cairn {
namespace {

enum class Format { none, tiff, png, jpeg };

Format format_of(const std::filesystem::path& target) {
  std::string extension = target.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".tif" || extension == ".tiff") return Format::tiff;
  if (extension == ".png") return Format::png;
  return extension == ".jpg" || extension == ".jpeg" ? Format::jpeg : Format::none;
}

/// The six lines of a world file: the steps of columns and rows, and the first pixel's centre.
Status write_world_file(const std::filesystem::path& target, const char* extension, const GeoGrid& area) {
  const auto path = std::filesystem::path(target).replace_extension(extension);
  std::ofstream out(path);
  out << fmt::format("{}\n0\n0\n{}\n{}\n{}\n", area.column_degrees, -area.row_degrees,
                     area.west + area.column_degrees / 2, area.north - area.row_degrees / 2);
  return out.flush() ? Status() : Status(failed(path.string() + ": world file: cannot be written"));
}

class TiffPicture final : public PictureWriter {
 public:
  explicit TiffPicture(TiffWriter writer) : writer_(std::move(writer)) {}
  Status write_row(std::span<const std::uint8_t> rgba) override {
    row_.assign(rgba.begin(), rgba.end());
    return writer_.write_row(std::as_writable_bytes(std::span(row_)));
  }
  Status finish() override { return writer_.finish(); }

 private:
  TiffWriter writer_;
  std::vector<std::uint8_t> row_;
};

class PngPicture final : public PictureWriter {
 public:
  PngPicture(PngWriter writer, std::filesystem::path target, const GeoGrid& area)
      : writer_(std::move(writer)), target_(std::move(target)), area_(area) {}
  Status write_row(std::span<const std::uint8_t> rgba) override {
    return writer_.write_row(std::as_bytes(rgba));
  }
  Status finish() override {
    const Status status = writer_.finish();
    return status ? write_world_file(target_, ".pgw", area_) : status;
  }

 private:
  PngWriter writer_;
  std::filesystem::path target_;
  GeoGrid area_;
};

class JpegPicture final : public PictureWriter {
 public:
  JpegPicture(JpegWriter writer, std::filesystem::path target, const GeoGrid& area)
      : writer_(std::move(writer)), target_(std::move(target)), area_(area) {}
  Status write_row(std::span<const std::uint8_t> rgba) override {
    row_.resize(rgba.size() / 4 * 3);
    for (std::size_t i = 0; i < rgba.size() / 4; ++i) {
      const unsigned alpha = rgba[4 * i + 3];
      for (std::size_t k = 0; k < 3; ++k)
        row_[3 * i + k] =
            static_cast<std::uint8_t>((rgba[4 * i + k] * alpha + 255 * (255 - alpha) + 127) / 255);
    }
    return writer_.write_row(row_);
  }
  Status finish() override {
    const Status status = writer_.finish();
    return status ? write_world_file(target_, ".jgw", area_) : status;
  }

 private:
  JpegWriter writer_;
  std::filesystem::path target_;
  GeoGrid area_;
  std::vector<std::uint8_t> row_;
};

}  // namespace

bool is_picture_name(const std::filesystem::path& target) {
  return format_of(target) != Format::none;
}

Result<std::unique_ptr<PictureWriter>> create_picture(const std::filesystem::path& target,
                                                      const GeoGrid& area) {
  switch (format_of(target)) {
    case Format::tiff: {
      auto writer = TiffWriter::create(target, area, TiffWriter::Pixel::rgba8);
      if (!writer) return writer.error();
      return std::unique_ptr<PictureWriter>(new TiffPicture(std::move(*writer)));
    }
    case Format::png: {
      auto writer = PngWriter::create(target, area.columns, area.rows, PngWriter::Pixel::rgba8);
      if (!writer) return writer.error();
      return std::unique_ptr<PictureWriter>(new PngPicture(std::move(*writer), target, area));
    }
    case Format::jpeg: {
      auto writer = JpegWriter::create(target, area.columns, area.rows);
      if (!writer) return writer.error();
      return std::unique_ptr<PictureWriter>(new JpegPicture(std::move(*writer), target, area));
    }
    case Format::none:
      break;
  }
  return usage_error(target.string() + ": expected a name that ends in .tif, .png or .jpg");
}

}  // namespace cairn
