#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "builder/raster/raster_source.h"

namespace cairn {

/// How a file writes a pixel's colour. Channels are samples of a pixel, by their number.
struct ColourEncoding {
  SampleType type = SampleType::uint8;  ///< uint8 or uint16
  int bits = 8;                         ///< of a sample, which scale to 0…255: 1, 2, 4, 8 or 16
  /// Samples that become 0 and 255, in place of 0 and the most of `bits`.
  std::optional<std::pair<double, double>> range;
  std::vector<int> channels;  ///< one (grey or palette) or three (red, green, blue)
  std::optional<int> alpha;
  bool premultiplied = false;
  bool white_is_zero = false;
  std::vector<std::uint8_t> palette;  ///< R, G, B of each index; empty where samples are colours
  std::optional<double> nodata;       ///< a pixel whose channels all have it is void
};

/// The range that the user says an image has, where something is said.
std::optional<std::pair<double, double>> said_range(const SourceOverrides& said, int bits);

/// Whether pixels are red, green and blue of 8 bits side by side, which expand_rgb() turns to RGBA at once.
bool is_plain_rgb(const ColourEncoding& encoding);

/// `count` pixels, `stride` bytes apart. Alpha is 0 where the pixel is nodata or the file stores nothing
/// (samples null), else 255. REQUIRES: is_plain_rgb(encoding).
void expand_rgb(const ColourEncoding& encoding, const std::byte* samples, std::size_t stride,
                std::size_t count, std::uint8_t* rgba);

/// Puts pixels together from their channels, which may come in any order and in pieces.
class ColourAssembly {
 public:
  /// `rgba`: 4 bytes a pixel.
  ColourAssembly(const ColourEncoding& encoding, std::span<std::uint8_t> rgba);

  /// Takes one channel of `count` pixels from pixel `first` on: samples in this machine's byte order,
  /// `stride` samples apart; null where the file stores nothing.
  void add(int channel, std::size_t first, std::size_t count, const std::byte* samples, std::size_t stride);

  /// Applies palette, alpha and nodata, once every channel is there.
  void finish();

 private:
  const ColourEncoding& encoding_;
  std::span<std::uint8_t> rgba_;
  std::vector<std::uint8_t> absent_;  // channels of a pixel that have no value
};

}  // namespace cairn
