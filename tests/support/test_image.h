#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "format/block_texture.h"

namespace cairn::test {

/// An RGBA picture.
struct TestImage {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgba;
};

/// Hills of a few sizes in each channel, partly together, and noise of ±grain: what a photo's blocks look
/// like.
TestImage landscape(int width, int height, double grain, unsigned seed);

/// Every byte at random.
TestImage noise(int width, int height, unsigned seed);

/// At most width×height texels of the top left corner of a picture file, opaque; empty where it cannot be
/// read.
TestImage photo(const std::filesystem::path& path, int width, int height);

/// Encodes nothing: only decodes `blocks` and takes the peak signal-to-noise ratio over channels [first,
/// last).
double psnr_db(const TestImage& image, TextureFormat format, const std::vector<std::byte>& blocks,
               std::size_t first = 0, std::size_t last = 3);

}  // namespace cairn::test
