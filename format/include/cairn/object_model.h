#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "cairn/status.h"
#include "cairn/texture_tile.h"
#include "cairn/tile_id.h"

namespace cairn {

inline constexpr std::size_t kMostModels = 65536;         ///< in a pack
inline constexpr std::size_t kMostModelVertices = 65535;  ///< of a model
inline constexpr std::size_t kMostModelIndices = std::size_t{1} << 22;
inline constexpr std::size_t kMostModelLevels = 8;
inline constexpr int kMostModelTexels = 4096;  ///< along a side of a texture
inline constexpr int kBillboardViews = 8;      ///< of a model that has triangles

/// A corner of triangles. The origin is the foot: x points east, y north and z up where the heading is 0.
struct ModelVertex {
  std::array<float, 3> position_m{};
  std::array<float, 3> normal{};   ///< of unit length
  std::array<float, 2> texture{};  ///< 0 to 1: right and DOWN from the texture's upper left corner

  friend bool operator==(const ModelVertex&, const ModelVertex&) = default;
};

/// One level of detail: a run of ObjectModel::indices.
struct ModelLevel {
  std::uint32_t first = 0;
  std::uint32_t count = 0;  ///< three per triangle
  float error_m = 0;        ///< how far it is off the model, at scale 1; 0 for the finest

  friend bool operator==(const ModelLevel&, const ModelLevel&) = default;
};

/// What an object looks like: triangles in levels of detail with one texture, and pictures for when it is
/// far.
///
/// The billboard is a square texture with one view or eight. Eight stand in four columns and two rows, view k
/// in column k mod 4, row k / 4 from above: the model as seen from the horizon, by an eye k/8 turns clockwise
/// from north of it, without light. A view is 2·radius_m wide, centred on the foot, and reaches from bottom_m
/// to top_m. A model of an image has no triangles, and one view that turns to the eye.
///
/// Textures are sRGB with straight alpha. Draw what is at least half opaque, on both sides of a triangle.
struct ObjectModel {
  std::string name;    ///< UTF-8, 1 to 255 bytes: what the places call it
  float radius_m = 0;  ///< the largest distance of a vertex from the vertical through the foot
  float bottom_m = 0;  ///< of the lowest vertex
  float top_m = 0;     ///< of the highest
  std::vector<ModelVertex> vertices;
  std::vector<std::uint16_t> indices;  ///< counter-clockwise from outside
  std::vector<ModelLevel> levels;      ///< the finest first, errors ascending; none for a model of an image
  TextureTile texture;                 ///< of the triangles; size 0 where there are none
  int billboard_views = 0;             ///< 1 or kBillboardViews
  TextureTile billboard;               ///< size 4 or more

  /// The largest extent, across or upwards, at scale 1.
  float size_m() const;
};

/// Returns where in Layer::models the pack has its model of this number.
constexpr TileId model_address(std::uint32_t model) {
  return {9, static_cast<std::int32_t>(model), 0};
}

/// Returns the block of a model. Equal models give equal bytes.
///
/// Positions are rounded to a power of 2 that is below 1/16383 of the largest coordinate, texture coordinates
/// to 1/65535, normals to 1/127 of an octahedron's square; radius, bottom and top are then taken from the
/// positions. REQUIRES: what decode_model_block() accepts.
std::vector<std::byte> encode_model_block(const ObjectModel& model);

/// Decodes a block. The error is bad_data if it is no block of a model, or if bytes are left over: every
/// index has a vertex, every number is finite, the bounds are those of the vertices.
Result<ObjectModel> decode_model_block(std::span<const std::byte> block);

}  // namespace cairn
