// Any bytes are opened as PNG and as JPEG, with a place beside them.
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include <catch2/catch.hpp>
#include <jpeglib.h>
#include <png.h>

#include "tests/support/dem_files.h"
#include "tests/support/fuzz.h"
#include "tests/support/raster_fuzz.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

void png(std::span<const std::byte> input) {
  open_and_read("png", "a.png", input, GeoBounds{28, 36, 29, 37});
}

void jpeg(std::span<const std::byte> input) {
  open_and_read("jpeg", "a.jpg", input, GeoBounds{28, 36, 29, 37});
}

Bytes png_bytes(png_uint_32 format) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = 12;
  image.height = 9;
  image.format = format;
  std::vector<std::uint8_t> pixels(PNG_IMAGE_SIZE(image));
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint8_t>(i * 37);
  image.colormap_entries = 256;  // every byte is an index then
  std::vector<std::uint8_t> map(PNG_IMAGE_COLORMAP_SIZE(image) + 1);
  png_alloc_size_t size = 0;
  REQUIRE(png_image_write_to_memory(&image, nullptr, &size, 0, pixels.data(), 0, map.data()) != 0);
  Bytes file(size);
  REQUIRE(png_image_write_to_memory(&image, file.data(), &size, 0, pixels.data(), 0, map.data()) != 0);
  file.resize(size);
  return file;
}

Bytes jpeg_bytes(bool progressive) {
  jpeg_compress_struct encoder{};
  jpeg_error_mgr errors{};
  encoder.err = jpeg_std_error(&errors);
  jpeg_create_compress(&encoder);
  unsigned char* out = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&encoder, &out, &size);
  encoder.image_width = 20;
  encoder.image_height = 11;
  encoder.input_components = 3;
  encoder.in_color_space = JCS_RGB;
  jpeg_set_defaults(&encoder);
  if (progressive) jpeg_simple_progression(&encoder);
  jpeg_start_compress(&encoder, TRUE);
  std::vector<JSAMPLE> row(60);
  for (std::size_t i = 0; i < row.size(); ++i) row[i] = static_cast<JSAMPLE>(i * 53);
  JSAMPROW rows = row.data();
  while (encoder.next_scanline < encoder.image_height) jpeg_write_scanlines(&encoder, &rows, 1);
  jpeg_finish_compress(&encoder);
  jpeg_destroy_compress(&encoder);
  const auto* first = reinterpret_cast<const std::byte*>(out);
  Bytes file(first, first + size);
  std::free(out);
  return file;
}

}  // namespace

TEST_CASE("no bytes make reading a PNG crash") {
  run_fuzz("png", png,
           {png_bytes(PNG_FORMAT_RGB), png_bytes(PNG_FORMAT_GA), png_bytes(PNG_FORMAT_LINEAR_Y),
            png_bytes(PNG_FORMAT_RGBA_COLORMAP)},
           3000);
}

TEST_CASE("no bytes make reading a JPEG crash") {
  run_fuzz("jpeg", jpeg, {jpeg_bytes(false), jpeg_bytes(true)}, 3000);
}

}  // namespace cairn::test
