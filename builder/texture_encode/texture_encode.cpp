#include "builder/texture_encode/texture_encode.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>

#include "builder/texture_encode/bc1_holes.h"
#include "builder/texture_encode/kernels.h"

namespace cairn {

namespace {

constexpr std::size_t kGroup = kKernelBlocks;
constexpr std::size_t kGroupRow = 16 * kGroup;  // bytes of a row of a group

const KernelSet& kernel_set(KernelIsa isa) {
  switch (isa) {
#if defined(__x86_64__)
    case KernelIsa::avx512:
      return avx512::kernels;
    case KernelIsa::avx2:
      return avx2::kernels;
#endif
    default:
      return portable::kernels;
  }
}

struct Image {
  const std::uint8_t* rgba;
  std::size_t width, height;
};

// The texels of a group of blocks; points into the image, or at `padded` where the group overhangs it.
struct GroupTexels {
  const std::uint8_t* texels;
  std::ptrdiff_t stride;
};

using PaddedGroup = std::array<std::uint8_t, 4 * kGroupRow>;

GroupTexels group_texels(const Image& image, std::size_t left, std::size_t top, PaddedGroup& padded) {
  if (left + 4 * kGroup <= image.width && top + 4 <= image.height) {
    return {image.rgba + 4 * (top * image.width + left), static_cast<std::ptrdiff_t>(4 * image.width)};
  }
  for (std::size_t y = 0; y < 4; ++y) {
    const std::size_t row = std::min(top + y, image.height - 1) * image.width;
    for (std::size_t x = 0; x < 4 * kGroup; ++x) {
      const std::size_t column = std::min(left + x, image.width - 1);
      std::memcpy(&padded[y * kGroupRow + 4 * x], image.rgba + 4 * (row + column), 4);
    }
  }
  return {padded.data(), static_cast<std::ptrdiff_t>(kGroupRow)};
}

bool has_holes(const std::uint8_t* texels, std::ptrdiff_t stride, std::size_t columns) {
  std::uint8_t all = 255;
  for (std::ptrdiff_t y = 0; y < 4; ++y) {
    for (std::size_t x = 0; x < columns; ++x)
      all &= texels[y * stride + static_cast<std::ptrdiff_t>(4 * x + 3)];
  }
  return all < 128;
}

void encode_bc1_group(Kernel colour, const GroupTexels& from, std::byte* out) {
  colour(from.texels, from.stride, out, 8);
  if (!has_holes(from.texels, from.stride, 4 * kGroup)) return;
  for (std::size_t block = 0; block < kGroup; ++block) {
    const std::uint8_t* texels = from.texels + 16 * block;
    if (!has_holes(texels, from.stride, 4)) continue;
    const auto code = encode_bc1_holes(texels, from.stride);
    std::copy(code.begin(), code.end(), out + 8 * block);
  }
}

void encode_group(const KernelSet& kernels, TextureFormat format, TextureQuality quality,
                  const GroupTexels& from, std::byte* out) {
  const auto q = static_cast<std::size_t>(quality);
  switch (format) {
    case TextureFormat::bc1:
      return encode_bc1_group(kernels.colour[q], from, out);
    case TextureFormat::bc3:
      kernels.alpha[q](from.texels, from.stride, out, 16);
      return kernels.four_colour[q](from.texels, from.stride, out + 8, 16);
    case TextureFormat::bc7:
      return kernels.bc7[q](from.texels, from.stride, out, 16);
  }
}

// In vectors of 512 bits the fast search of BC7 encodes a fifth less per second
// (docs/bench-logs/textures.txt).
KernelIsa fastest_isa_for(TextureFormat format, TextureQuality quality) {
  const KernelIsa widest = widest_kernel_isa();
  const bool is_slower_when_wide = format == TextureFormat::bc7 && quality == TextureQuality::fast;
  return is_slower_when_wide && widest == KernelIsa::avx512 ? KernelIsa::avx2 : widest;
}

}  // namespace

KernelIsa widest_kernel_isa() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
    return KernelIsa::avx512;
  if (__builtin_cpu_supports("avx2")) return KernelIsa::avx2;
#endif
  return KernelIsa::portable;
}

void encode_texture(TextureFormat format, TextureQuality quality, std::span<const std::uint8_t> rgba,
                    int width, int height, std::vector<std::byte>& out) {
  encode_texture_with(fastest_isa_for(format, quality), format, quality, rgba, width, height, out);
}

void encode_texture_with(KernelIsa isa, TextureFormat format, TextureQuality quality,
                         std::span<const std::uint8_t> rgba, int width, int height,
                         std::vector<std::byte>& out) {
  assert(width >= 1 && height >= 1);
  const Image image{rgba.data(), static_cast<std::size_t>(width), static_cast<std::size_t>(height)};
  assert(rgba.size() == image.width * image.height * 4);
  const std::size_t bytes = block_bytes(format);
  std::size_t at = out.size();
  out.resize(at + static_cast<std::size_t>(texture_bytes(format, width, height)));

  PaddedGroup padded;
  std::array<std::byte, 16 * kGroup> code;
  const std::size_t columns = (image.width + 3) / 4;
  for (std::size_t top = 0; top < image.height; top += 4) {
    for (std::size_t column = 0; column < columns; column += kGroup) {
      const GroupTexels from = group_texels(image, 4 * column, top, padded);
      encode_group(kernel_set(isa), format, quality, from, code.data());
      const std::size_t used = bytes * std::min(kGroup, columns - column);
      std::memcpy(&out[at], code.data(), used);
      at += used;
    }
  }
}

void bc1_errors(std::span<const std::uint8_t> rgba, int width, int height, std::span<const std::byte> blocks,
                std::vector<std::uint32_t>& errors) {
  bc1_errors_with(widest_kernel_isa(), rgba, width, height, blocks, errors);
}

void bc1_errors_with(KernelIsa isa, std::span<const std::uint8_t> rgba, int width, int height,
                     std::span<const std::byte> blocks, std::vector<std::uint32_t>& errors) {
  const Image image{rgba.data(), static_cast<std::size_t>(width), static_cast<std::size_t>(height)};
  assert(blocks.size() == texture_bytes(TextureFormat::bc1, width, height));
  const std::size_t columns = (image.width + 3) / 4;
  std::size_t at = errors.size();
  errors.resize(at + blocks.size() / 8);
  PaddedGroup padded;
  std::array<std::byte, 8 * kGroup> code{};
  std::array<std::uint32_t, kGroup> found;
  const std::byte* from = blocks.data();
  for (std::size_t top = 0; top < image.height; top += 4) {
    for (std::size_t column = 0; column < columns; column += kGroup) {
      const GroupTexels texels = group_texels(image, 4 * column, top, padded);
      const std::size_t used = std::min(kGroup, columns - column);
      std::memcpy(code.data(), from, 8 * used);
      kernel_set(isa).bc1_errors(texels.texels, texels.stride, code.data(), found.data());
      std::copy_n(found.begin(), used, errors.begin() + static_cast<std::ptrdiff_t>(at));
      at += used;
      from += 8 * used;
    }
  }
}

}  // namespace cairn
