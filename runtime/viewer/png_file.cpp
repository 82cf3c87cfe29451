#include "runtime/viewer/png_file.h"

#include <png.h>

namespace cairn::viewer {

namespace {

png_image image_of(const gl::Picture& picture) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(picture.width);
  image.height = static_cast<png_uint_32>(picture.height);
  image.format = PNG_FORMAT_RGB;
  return image;
}

}  // namespace

Status write_png(const std::filesystem::path& path, const gl::Picture& picture) {
  png_image image = image_of(picture);
  if (png_image_write_to_file(&image, path.c_str(), 0, picture.rgb.data(), 0, nullptr)) return {};
  return failed(path.string() + ": picture: expected to write it, found: " + image.message);
}

Status write_png(const NumberedFile& file, const gl::Picture& picture) {
  png_image image = image_of(picture);
  const bool written =
      png_image_write_to_stdio(&image, file.file.get(), 0, picture.rgb.data(), 0, nullptr) != 0;
  if (written && std::fflush(file.file.get()) == 0) return {};
  return failed(file.name + ": picture: expected to write it, found: " + image.message);
}

}  // namespace cairn::viewer
