#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "cairn/status.h"

namespace cairn {

/// What a model's file holds: triangles of many materials, in metres, the foot at the origin.
struct SourceMesh {
  struct Vertex {
    std::array<float, 3> position{};  ///< east, north, up
    std::array<float, 3> normal{};
    std::array<float, 2> texture{};  ///< right and down; beyond 0 to 1 the picture repeats
  };
  struct Material {
    std::array<std::uint8_t, 4> colour{255, 255, 255, 255};  ///< sRGB, of the picture or alone
    std::uint32_t image = kNoImage;
  };
  struct Image {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<std::uint8_t> rgba;  ///< rows from above
  };
  static constexpr std::uint32_t kNoImage = UINT32_MAX;

  std::vector<Vertex> vertices;
  std::vector<std::uint32_t> indices;    ///< three per triangle
  std::vector<std::uint32_t> materials;  ///< one per triangle
  std::vector<Material> palette;
  std::vector<Image> images;
};

inline constexpr std::size_t kMostSourceVertices = 4'000'000;
inline constexpr std::size_t kMostSourceTriangles = 8'000'000;
inline constexpr std::size_t kMostSourceMaterials = 4096;
inline constexpr std::uint32_t kMostSourceTexels = 16384;  ///< along a side of an image

/// How the reader of models, which is a process of its own, hands over what it read.
std::vector<std::byte> encode_mesh(const SourceMesh& mesh);
/// The error is bad_data where an index leads nowhere, a number is not finite, or a limit is exceeded.
Result<SourceMesh> decode_mesh(std::span<const std::byte> bytes);

}  // namespace cairn
