#include "builder/objects/model_stream.h"

#include <cmath>

#include "format/bytes.h"

namespace cairn {
namespace {

constexpr std::uint32_t kStreamMark = 0x4C444D43;

template <class T, class Read>
bool read_all(ByteReader& in, std::vector<T>& out, std::size_t most, std::size_t bytes_each,
              const Read& read) {
  const auto count = in.read<std::uint32_t>();
  if (!in.ok() || count > most || in.remaining() / bytes_each < count) return false;
  out.reserve(count);
  for (std::uint32_t i = 0; i < count; ++i) out.push_back(read());
  return in.ok();
}

SourceMesh::Vertex read_vertex(ByteReader& in) {
  SourceMesh::Vertex v;
  for (float& f : v.position) f = in.read<float>();
  for (float& f : v.normal) f = in.read<float>();
  for (float& f : v.texture) f = in.read<float>();
  return v;
}

SourceMesh::Material read_material(ByteReader& in) {
  SourceMesh::Material m;
  for (std::uint8_t& c : m.colour) c = in.read<std::uint8_t>();
  m.image = in.read<std::uint32_t>();
  return m;
}

SourceMesh::Image read_image(ByteReader& in) {
  SourceMesh::Image image;
  image.width = in.read<std::uint32_t>();
  image.height = in.read<std::uint32_t>();
  if (image.width > kMostSourceTexels || image.height > kMostSourceTexels) return {};
  const auto texels = in.take(std::uint64_t{image.width} * image.height * 4);
  image.rgba.reserve(texels.size());
  for (const std::byte b : texels) image.rgba.push_back(std::to_integer<std::uint8_t>(b));
  return image;
}

bool is_usable(const SourceMesh& mesh) {
  if (mesh.indices.size() != 3 * mesh.materials.size()) return false;
  for (const auto& v : mesh.vertices) {
    for (const auto& values : {std::span<const float>(v.position), std::span<const float>(v.normal),
                               std::span<const float>(v.texture)})
      for (const float f : values)
        if (!std::isfinite(f) || std::abs(f) > 1e6f) return false;
  }
  for (const std::uint32_t i : mesh.indices)
    if (i >= mesh.vertices.size()) return false;
  for (const std::uint32_t m : mesh.materials)
    if (m >= mesh.palette.size()) return false;
  for (const auto& m : mesh.palette)
    if (m.image != SourceMesh::kNoImage && m.image >= mesh.images.size()) return false;
  for (const auto& image : mesh.images)
    if (image.width == 0 || image.height == 0) return false;
  return true;
}

}  // namespace

std::vector<std::byte> encode_mesh(const SourceMesh& mesh) {
  std::vector<std::byte> bytes;
  ByteWriter out(bytes);
  out.write(kStreamMark);
  out.write(static_cast<std::uint32_t>(mesh.vertices.size()));
  for (const auto& v : mesh.vertices) {
    for (const float f : v.position) out.write(f);
    for (const float f : v.normal) out.write(f);
    for (const float f : v.texture) out.write(f);
  }
  out.write(static_cast<std::uint32_t>(mesh.indices.size()));
  for (const std::uint32_t i : mesh.indices) out.write(i);
  out.write(static_cast<std::uint32_t>(mesh.materials.size()));
  for (const std::uint32_t m : mesh.materials) out.write(m);
  out.write(static_cast<std::uint32_t>(mesh.palette.size()));
  for (const auto& m : mesh.palette) {
    for (const std::uint8_t c : m.colour) out.write(c);
    out.write(m.image);
  }
  out.write(static_cast<std::uint32_t>(mesh.images.size()));
  for (const auto& image : mesh.images) {
    out.write(image.width);
    out.write(image.height);
    out.append(std::as_bytes(std::span(image.rgba)));
  }
  return bytes;
}

Result<SourceMesh> decode_mesh(std::span<const std::byte> bytes) {
  ByteReader in(bytes);
  SourceMesh mesh;
  const bool whole =
      in.read<std::uint32_t>() == kStreamMark &&
      read_all(in, mesh.vertices, kMostSourceVertices, 32, [&in] { return read_vertex(in); }) &&
      read_all(in, mesh.indices, 3 * kMostSourceTriangles, 4, [&in] { return in.read<std::uint32_t>(); }) &&
      read_all(in, mesh.materials, kMostSourceTriangles, 4, [&in] { return in.read<std::uint32_t>(); }) &&
      read_all(in, mesh.palette, kMostSourceMaterials, 8, [&in] { return read_material(in); }) &&
      read_all(in, mesh.images, kMostSourceMaterials, 8, [&in] { return read_image(in); }) &&
      in.remaining() == 0;
  if (!whole || !is_usable(mesh))
    return bad_data("model: expected a finite mesh of at most " + std::to_string(kMostSourceTriangles) +
                    " triangles within 1000 km, found another");
  return mesh;
}

}  // namespace cairn
