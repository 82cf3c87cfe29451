#include "runtime/gl/method_batch.h"

#include <cstddef>
#include <vector>

#include "cairn/geodesy.h"

namespace cairn::gl {
namespace {

/// What terrain.vert takes of a vertex.
struct Vertex {
  std::uint32_t patch = 0;
  glm::vec3 from_eye{0};
  glm::vec3 place_and_height{0};  ///< 0…1 from the area's south-west corner; metres
};

Vertex vertex_of(const LodVertex& vertex, std::size_t tile, const TileId& area, const glm::dvec3& eye) {
  const LatticePoint corner = south_west_of(area);
  const auto width = static_cast<double>(lattice_width(area.level));
  LonLat place = place_of(vertex.point);
  if (place.lon == 180) place.lon = -180;  // so that both sides of the antimeridian have the same bits
  return {static_cast<std::uint32_t>(tile), glm::vec3(to_geocentric(place, vertex.height_m) - eye),
          glm::vec3(static_cast<double>(vertex.point.x - corner.x) / width,
                    static_cast<double>(vertex.point.y - corner.y) / width, vertex.height_m)};
}

}  // namespace

MethodBatch::MethodBatch() {
  const GLuint vao = vertex_array_.name();
  glVertexArrayVertexBuffer(vao, 0, vertices_.name(), 0, sizeof(Vertex));
  glVertexArrayElementBuffer(vao, indices_.name());
  for (GLuint location = 0; location < 3; ++location) {
    glEnableVertexArrayAttrib(vao, location);
    glVertexArrayAttribBinding(vao, location, 0);
  }
  glVertexArrayAttribIFormat(vao, 0, 1, GL_UNSIGNED_INT, offsetof(Vertex, patch));
  glVertexArrayAttribFormat(vao, 1, 3, GL_FLOAT, GL_FALSE, offsetof(Vertex, from_eye));
  glVertexArrayAttribFormat(vao, 2, 3, GL_FLOAT, GL_FALSE, offsetof(Vertex, place_and_height));
}

std::size_t MethodBatch::draw(const LodMesh& mesh, const LodScene& scene,
                              std::span<const PatchRecord> records, const glm::dvec3& eye, bool calls) {
  std::vector<Vertex> vertices;
  std::vector<std::uint32_t> indices;
  for (const LodTileMesh& part : mesh.tiles) {
    const auto first = static_cast<std::uint32_t>(vertices.size());
    const TileId& area = scene.tiles[part.tile].area;
    for (const LodVertex& vertex : part.vertices) {
      vertices.push_back(vertex_of(vertex, part.tile, area, eye));
    }
    for (const LodTriangle& triangle : part.triangles) {
      for (const std::uint32_t corner : triangle) indices.push_back(first + corner);
    }
  }
  fill(patches_, records);
  fill<Vertex>(vertices_, vertices);
  fill<std::uint32_t>(indices_, indices);
  glBindVertexArray(vertex_array_.name());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, patches_.name());
  if (calls) {
    glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(indices.size()), GL_UNSIGNED_INT, nullptr);
  }
  return indices.size() / 3;
}

}  // namespace cairn::gl
