#include "builder/objects/reader/decode_image.h"

#include <fstream>
#include <iterator>
#include <memory>
#include <vector>

#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#pragma GCC diagnostic ignored "-Wsign-compare"
#endif
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#include <stb/stb_image.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

namespace cairn {

Result<SourceMesh::Image> decode_image(std::span<const std::byte> bytes, const std::string& name) {
  struct FreeTexels {
    void operator()(stbi_uc* texels) const { stbi_image_free(texels); }
  };
  int width = 0, height = 0, channels = 0;
  const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
  const int size = bytes.size() > INT32_MAX ? 0 : static_cast<int>(bytes.size());
  const bool known = stbi_info_from_memory(data, size, &width, &height, &channels) != 0;
  const int most = static_cast<int>(kMostSourceTexels);
  if (known && (width > most || height > most))
    return bad_data(name + ": expected an image of at most " + std::to_string(most) +
                    " pixels a side, found " + std::to_string(width) + "x" + std::to_string(height));
  const std::unique_ptr<stbi_uc, FreeTexels> texels(
      known ? stbi_load_from_memory(data, size, &width, &height, &channels, 4) : nullptr);
  if (!texels)
    return bad_data(name + ": expected a PNG, JPEG, TGA or BMP image, found another or a damaged one");
  SourceMesh::Image image{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), {}};
  image.rgba.assign(texels.get(), texels.get() + std::size_t{image.width} * image.height * 4);
  return image;
}

Result<SourceMesh::Image> decode_image_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(in), {}};
  return decode_image(std::as_bytes(std::span(bytes)), file.filename().string());
}

}  // namespace cairn
