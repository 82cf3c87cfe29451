#include "cairn/object_model.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "format/bytes.h"
#include "format/zstd_frame.h"

namespace cairn {
namespace {

constexpr int kModelZstdLevel = 19;  // a model is written once; the level decides bytes, so it never changes
constexpr std::size_t kFixedBytes = 32;
constexpr float kSteps = 32767;  // of a position, from the foot to the largest coordinate
constexpr float kTexels = 65535;
constexpr float kNormalSteps = 127;
constexpr std::size_t kVertexBytes = 12;
constexpr int kSmallestTexture = 4;

Error model_error(const std::string& what, const std::string& expected, const std::string& found) {
  return bad_data("model block: " + what + ": expected " + expected + ", found " + found);
}

/// A vertex as the block has it.
struct PackedVertex {
  std::array<std::int16_t, 3> position{};
  std::array<std::int8_t, 2> normal{};
  std::array<std::uint16_t, 2> texture{};
};

float sign_of(float v) {
  return v < 0 ? -1.0f : 1.0f;
}

std::int8_t pack_signed(float v) {
  return static_cast<std::int8_t>(std::lround(std::clamp(v, -1.0f, 1.0f) * kNormalSteps));
}

// The octahedron |x| + |y| + |z| = 1, its lower half folded outwards over the square (Cigolle et al. 2014,
// §3.1).
std::array<std::int8_t, 2> square_of(const std::array<float, 3>& n) {
  const float sum = std::abs(n[0]) + std::abs(n[1]) + std::abs(n[2]);
  float u = n[0] / sum;
  float v = n[1] / sum;
  if (n[2] < 0) {
    const float folded = (1 - std::abs(v)) * sign_of(u);
    v = (1 - std::abs(u)) * sign_of(v);
    u = folded;
  }
  return {pack_signed(u), pack_signed(v)};
}

std::array<float, 3> unpack_normal(const std::array<std::int8_t, 2>& packed) {
  float x = packed[0] / kNormalSteps;
  float y = packed[1] / kNormalSteps;
  const float z = 1 - std::abs(x) - std::abs(y);
  if (z < 0) {
    const float folded = (1 - std::abs(y)) * sign_of(x);
    y = (1 - std::abs(x)) * sign_of(y);
    x = folded;
  }
  const float length = std::sqrt(x * x + y * y + z * z);
  return {x / length, y / length, z / length};
}

// A power of 2, so that positions are exact and have the same unit when they are written again.
float unit_of(const ObjectModel& model) {
  float largest = 0;
  for (const ModelVertex& vertex : model.vertices) {
    for (const float c : vertex.position_m) largest = std::max(largest, std::abs(c));
  }
  if (largest == 0) return 0;
  float unit = std::exp2(std::ceil(std::log2(largest / kSteps)));
  while (unit * kSteps < largest) unit *= 2;
  while (unit / 2 * kSteps >= largest) unit /= 2;
  return unit;
}

// The border of the square has each direction twice; packed again, either becomes the same one.
std::array<std::int8_t, 2> pack_normal(const std::array<float, 3>& n) {
  return square_of(unpack_normal(square_of(n)));
}

PackedVertex pack_vertex(const ModelVertex& vertex, float unit) {
  PackedVertex packed;
  for (std::size_t i = 0; i < 3; ++i) {
    const long step = unit > 0 ? std::lround(vertex.position_m[i] / unit) : 0;
    packed.position[i] = static_cast<std::int16_t>(std::clamp(step, -32767L, 32767L));
  }
  packed.normal = pack_normal(vertex.normal);
  for (std::size_t i = 0; i < 2; ++i)
    packed.texture[i] =
        static_cast<std::uint16_t>(std::lround(std::clamp(vertex.texture[i], 0.0f, 1.0f) * kTexels));
  return packed;
}

ModelVertex unpack_vertex(const PackedVertex& packed, float unit) {
  ModelVertex vertex;
  for (std::size_t i = 0; i < 3; ++i) vertex.position_m[i] = packed.position[i] * unit;
  vertex.normal = unpack_normal(packed.normal);
  for (std::size_t i = 0; i < 2; ++i) vertex.texture[i] = packed.texture[i] / kTexels;
  return vertex;
}

struct Bounds {
  float radius = 0;
  float bottom = 0;
  float top = 0;
  friend bool operator==(const Bounds&, const Bounds&) = default;
};

Bounds bounds_of(const std::vector<PackedVertex>& vertices, float unit) {
  std::int64_t farthest = 0;
  std::int16_t lowest = std::numeric_limits<std::int16_t>::max();
  std::int16_t highest = std::numeric_limits<std::int16_t>::min();
  for (const PackedVertex& vertex : vertices) {
    const std::int64_t x = vertex.position[0];
    const std::int64_t y = vertex.position[1];
    farthest = std::max(farthest, x * x + y * y);
    lowest = std::min(lowest, vertex.position[2]);
    highest = std::max(highest, vertex.position[2]);
  }
  return {static_cast<float>(std::sqrt(static_cast<double>(farthest)) * unit), lowest * unit, highest * unit};
}

/// All x, then all y, and so on: like follows like.
std::vector<std::byte> geometry_bytes(const std::vector<PackedVertex>& vertices,
                                      const std::vector<std::uint16_t>& indices) {
  std::vector<std::byte> bytes;
  ByteWriter out(bytes);
  for (std::size_t i = 0; i < 3; ++i)
    for (const PackedVertex& vertex : vertices) out.write(vertex.position[i]);
  for (std::size_t i = 0; i < 2; ++i)
    for (const PackedVertex& vertex : vertices) out.write(vertex.normal[i]);
  for (std::size_t i = 0; i < 2; ++i)
    for (const PackedVertex& vertex : vertices) out.write(vertex.texture[i]);
  for (const std::uint16_t index : indices) out.write(index);
  return bytes;
}

std::vector<PackedVertex> read_vertices(ByteReader& in, std::size_t count) {
  std::vector<PackedVertex> vertices(count);
  for (std::size_t i = 0; i < 3; ++i)
    for (PackedVertex& vertex : vertices) vertex.position[i] = in.read<std::int16_t>();
  for (std::size_t i = 0; i < 2; ++i)
    for (PackedVertex& vertex : vertices) vertex.normal[i] = in.read<std::int8_t>();
  for (std::size_t i = 0; i < 2; ++i)
    for (PackedVertex& vertex : vertices) vertex.texture[i] = in.read<std::uint16_t>();
  return vertices;
}

void append_frame(std::span<const std::byte> plain, std::vector<std::byte>& block) {
  std::vector<std::byte> frame;
  append_zstd_frame(plain, {.level = kModelZstdLevel}, frame);
  ByteWriter out(block);
  out.write(static_cast<std::uint32_t>(frame.size()));
  out.append(frame);
}

Status read_frame(ByteReader& in, const char* what, std::span<std::byte> plain) {
  const auto bytes = in.read<std::uint32_t>();
  const auto frame = in.take(bytes);
  if (!in.ok()) return model_error(what, std::to_string(bytes) + " bytes", "fewer");
  const Status status = decode_zstd_frame(frame, plain);
  if (!status) return bad_data(std::string("model block: ") + what + ": " + status.error().message);
  return {};
}

std::uint8_t log2_of(int size) {
  return static_cast<std::uint8_t>(std::bit_width(static_cast<unsigned>(size)) - 1);
}

/// Format and size of a texture; size 0 for none.
Result<TextureTile> read_texture_kind(ByteReader& in, const char* what) {
  const auto format = in.read<std::uint8_t>();
  const auto size = in.read<std::uint8_t>();
  TextureTile texture;
  if (format == 0 && size == 0) return texture;
  if (format != 1 && format != 3 && format != 7)
    return model_error(what, "format 1, 3 or 7", std::to_string(format));
  if (size < log2_of(kSmallestTexture) || size > log2_of(kMostModelTexels))
    return model_error(what, "a width of 2^2 to 2^12 texels", "2^" + std::to_string(size));
  texture.format = static_cast<TextureFormat>(format);
  texture.size = 1 << size;
  return texture;
}

void write_texture_kind(const TextureTile& texture, ByteWriter& out) {
  out.write(texture.size == 0 ? std::uint8_t{0} : static_cast<std::uint8_t>(texture.format));
  out.write(texture.size == 0 ? std::uint8_t{0} : log2_of(texture.size));
}

Status read_texels(ByteReader& in, const char* what, TextureTile& texture) {
  if (texture.size == 0) return {};
  texture.texels.resize(texture_chain_bytes(texture.format, texture.size));
  return read_frame(in, what, texture.texels);
}

/// The fixed part of a block.
struct ModelHeader {
  std::size_t vertices = 0;
  std::size_t levels = 0;
  std::size_t indices = 0;
  float unit = 0;
  Bounds bounds;
  std::size_t name_bytes = 0;
};

Status check_header(const ModelHeader& h, const ObjectModel& model) {
  const bool has_mesh = h.levels != 0;
  if (h.levels > kMostModelLevels)
    return model_error("levels", "at most " + std::to_string(kMostModelLevels), std::to_string(h.levels));
  if ((h.vertices != 0) != has_mesh || (h.indices != 0) != has_mesh ||
      (model.texture.size != 0) != has_mesh || (h.unit != 0) != has_mesh)
    return model_error("levels", "vertices, indices, a unit and a texture with them alone",
                       std::to_string(h.levels) + " levels, " + std::to_string(h.vertices) + " vertices, " +
                           std::to_string(h.indices) + " indices");
  if (h.indices > kMostModelIndices)
    return model_error("indices", "at most " + std::to_string(kMostModelIndices), std::to_string(h.indices));
  if (model.billboard_views != (has_mesh ? kBillboardViews : 1))
    return model_error("billboard views", std::to_string(has_mesh ? kBillboardViews : 1),
                       std::to_string(model.billboard_views));
  if (model.billboard.size == 0) return model_error("billboard", "a texture", "none");
  for (const float v : {h.unit, h.bounds.radius, h.bounds.bottom, h.bounds.top}) {
    if (!std::isfinite(v)) return model_error("bounds", "finite lengths", std::to_string(v));
  }
  if (h.unit < 0 || h.bounds.radius < 0 || h.bounds.bottom > h.bounds.top ||
      (h.bounds.radius == 0 && h.bounds.bottom == h.bounds.top))
    return model_error("bounds", "radius 0 or more, bottom not above top, and an extent", "others");
  if (h.name_bytes == 0) return model_error("name", "1 byte or more", "none");
  return {};
}

Status read_levels(ByteReader& in, const ModelHeader& header, ObjectModel& model) {
  std::uint64_t first = 0;
  for (std::size_t i = 0; i < header.levels; ++i) {
    const auto count = in.read<std::uint32_t>();
    const auto error = in.read<float>();
    if (!in.ok()) return model_error("levels", std::to_string(header.levels), std::to_string(i));
    if (count == 0 || count % 3 != 0 || count > header.indices - first)
      return model_error("indices of level " + std::to_string(i),
                         "3 per triangle, at most " + std::to_string(header.indices - first) + " in all",
                         std::to_string(count));
    const float above = i == 0 ? 0 : model.levels.back().error_m;
    if (!std::isfinite(error) || error < above || (i == 0 && error != 0))
      return model_error("error of level " + std::to_string(i),
                         i == 0 ? "0 m" : std::to_string(above) + " m or more", std::to_string(error) + " m");
    model.levels.push_back({static_cast<std::uint32_t>(first), count, error});
    first += count;
  }
  if (first != header.indices)
    return model_error("indices of all levels", std::to_string(header.indices), std::to_string(first));
  return {};
}

Status read_geometry(ByteReader& in, const ModelHeader& header, ObjectModel& model) {
  if (header.levels == 0) return {};
  std::vector<std::byte> bytes(header.vertices * kVertexBytes + header.indices * sizeof(std::uint16_t));
  if (const Status status = read_frame(in, "geometry", bytes); !status) return status;
  ByteReader geometry(bytes);
  const std::vector<PackedVertex> vertices = read_vertices(geometry, header.vertices);
  if (bounds_of(vertices, header.unit) != header.bounds)
    return model_error("bounds", "those of the vertices", "others");
  for (const PackedVertex& vertex : vertices) {
    const auto is_low = [](std::int16_t step) { return step < -kSteps; };
    if (std::any_of(vertex.position.begin(), vertex.position.end(), is_low) ||
        std::min(vertex.normal[0], vertex.normal[1]) < -kNormalSteps)
      return model_error("vertex", "steps from -32767 (of a normal -127) on", "one below");
    model.vertices.push_back(unpack_vertex(vertex, header.unit));
  }
  model.indices.resize(header.indices);
  for (std::uint16_t& index : model.indices) {
    index = geometry.read<std::uint16_t>();
    if (index >= header.vertices)
      return model_error("index", "one below " + std::to_string(header.vertices), std::to_string(index));
  }
  return {};
}

}  // namespace

float ObjectModel::size_m() const {
  return std::max(2 * radius_m, top_m - bottom_m);
}

std::vector<std::byte> encode_model_block(const ObjectModel& model) {
  assert(!model.name.empty() && model.name.size() <= UINT8_MAX);
  assert(model.vertices.size() <= kMostModelVertices && model.indices.size() <= kMostModelIndices);
  const float unit = unit_of(model);
  std::vector<PackedVertex> vertices;
  for (const ModelVertex& vertex : model.vertices) vertices.push_back(pack_vertex(vertex, unit));
  const Bounds bounds =
      vertices.empty() ? Bounds{model.radius_m, model.bottom_m, model.top_m} : bounds_of(vertices, unit);

  std::vector<std::byte> block;
  ByteWriter out(block);
  out.write(static_cast<std::uint16_t>(vertices.size()));
  out.write(static_cast<std::uint8_t>(model.levels.size()));
  out.write(static_cast<std::uint8_t>(model.billboard_views));
  out.write(static_cast<std::uint32_t>(model.indices.size()));
  for (const float v : {unit, bounds.radius, bounds.bottom, bounds.top}) out.write(v);
  write_texture_kind(model.texture, out);
  write_texture_kind(model.billboard, out);
  out.write(static_cast<std::uint8_t>(model.name.size()));
  for (int i = 0; i < 3; ++i) out.write(std::uint8_t{0});
  out.append(std::as_bytes(std::span(model.name)));
  for (const ModelLevel& level : model.levels) {
    out.write(level.count);
    out.write(level.error_m);
  }
  if (!vertices.empty()) append_frame(geometry_bytes(vertices, model.indices), block);
  if (model.texture.size != 0) append_frame(model.texture.texels, block);
  append_frame(model.billboard.texels, block);
  return block;
}

Result<ObjectModel> decode_model_block(std::span<const std::byte> block) {
  if (block.size() < kFixedBytes)
    return model_error("size", std::to_string(kFixedBytes) + " bytes or more", std::to_string(block.size()));
  ByteReader in(block);
  ModelHeader header;
  ObjectModel model;
  header.vertices = in.read<std::uint16_t>();
  header.levels = in.read<std::uint8_t>();
  model.billboard_views = in.read<std::uint8_t>();
  header.indices = in.read<std::uint32_t>();
  header.unit = in.read<float>();
  header.bounds.radius = model.radius_m = in.read<float>();
  header.bounds.bottom = model.bottom_m = in.read<float>();
  header.bounds.top = model.top_m = in.read<float>();
  for (const auto& [texture, what] :
       {std::pair{&model.texture, "texture"}, {&model.billboard, "billboard"}}) {
    auto kind = read_texture_kind(in, what);
    if (!kind) return kind.error();
    *texture = std::move(*kind);
  }
  header.name_bytes = in.read<std::uint8_t>();
  for (int i = 0; i < 3; ++i) {
    if (in.read<std::uint8_t>() != 0) return model_error("reserved bytes", "0", "others");
  }
  if (const Status status = check_header(header, model); !status) return status.error();
  const auto name = in.take(header.name_bytes);
  model.name.assign(reinterpret_cast<const char*>(name.data()), name.size());
  if (const Status status = read_levels(in, header, model); !status) return status.error();
  if (const Status status = read_geometry(in, header, model); !status) return status.error();
  if (const Status status = read_texels(in, "texture", model.texture); !status) return status.error();
  if (const Status status = read_texels(in, "billboard", model.billboard); !status) return status.error();
  if (in.remaining() != 0)
    return model_error("end", "no bytes after the billboard", std::to_string(in.remaining()));
  return model;
}

}  // namespace cairn
