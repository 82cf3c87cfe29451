#include "runtime/lab/mesh_file.h"

#include <array>
#include <charconv>
#include <fstream>
#include <string>
#include <unordered_map>

#include "runtime/lab/watertight.h"
#include "runtime/lod/mesh/screen.h"

namespace cairn {
namespace {

/// Shortest text that reads back as the same double.
void append(double value, std::string& out) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  out.append(text.data(), end);
}

struct WholeMesh {
  std::vector<LodVertex> vertices;
  std::vector<LodTriangle> triangles;
};

WholeMesh joined(const LodMesh& mesh) {
  WholeMesh whole;
  std::unordered_map<LodVertex, std::uint32_t, LodVertexHash> numbers;
  const auto add = [&](const LodTileMesh& tile) {
    std::vector<std::uint32_t> own;
    for (const LodVertex& v : tile.vertices) {
      const LodVertex key{canonical(v.point), v.height_m};
      const auto [it, fresh] = numbers.emplace(key, static_cast<std::uint32_t>(whole.vertices.size()));
      if (fresh) whole.vertices.push_back(key);
      own.push_back(it->second);
    }
    for (const LodTriangle& t : tile.triangles) whole.triangles.push_back({own[t[0]], own[t[1]], own[t[2]]});
  };
  for (const LodTileMesh& tile : mesh.tiles) add(tile);
  add(mesh.walls);
  return whole;
}

void append_vertex(const LodVertex& v, const std::optional<Ellipsoid>& ecef, std::string& out) {
  const LonLat place = place_of(v.point);
  const glm::dvec3 p =
      ecef ? to_geocentric(v.point, v.height_m, *ecef) : glm::dvec3(place.lon, place.lat, v.height_m);
  append(p.x, out);
  append(p.y, out += ' ');
  append(p.z, out += ' ');
  out += '\n';
}

std::string obj_text(const WholeMesh& mesh, const std::optional<Ellipsoid>& ecef) {
  std::string out = ecef ? "# geocentric metres\n" : "# longitude, latitude in degrees, height in metres\n";
  for (const LodVertex& v : mesh.vertices) append_vertex(v, ecef, out += "v ");
  for (const LodTriangle& t : mesh.triangles) {
    out += 'f';
    for (const std::uint32_t v : t) out.append(1, ' ').append(std::to_string(v + 1));
    out += "\n";
  }
  return out;
}

std::string ply_text(const WholeMesh& mesh, const std::optional<Ellipsoid>& ecef) {
  std::string out = "ply\nformat ascii 1.0\ncomment ";
  out += ecef ? "geocentric metres" : "x longitude, y latitude in degrees, z height in metres";
  out += "\nelement vertex " + std::to_string(mesh.vertices.size()) +
         "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
         std::to_string(mesh.triangles.size()) + "\nproperty list uchar uint vertex_indices\nend_header\n";
  for (const LodVertex& v : mesh.vertices) append_vertex(v, ecef, out);
  for (const LodTriangle& t : mesh.triangles) {
    out += '3';
    for (const std::uint32_t v : t) out.append(1, ' ').append(std::to_string(v));
    out += "\n";
  }
  return out;
}

}  // namespace

Status write_mesh(const LodMesh& mesh, const std::filesystem::path& path,
                  const std::optional<Ellipsoid>& ecef) {
  const std::string ending = path.extension().string();
  if (ending != ".obj" && ending != ".ply") {
    return usage_error(path.string() + ": expected a name ending in .obj or .ply, found \"" + ending + "\"");
  }
  const WholeMesh whole = joined(mesh);
  std::ofstream out(path, std::ios::binary);
  out << (ending == ".obj" ? obj_text(whole, ecef) : ply_text(whole, ecef));
  out.close();
  if (!out) return failed(path.string() + ": expected to write the mesh, found no room or no right to");
  return {};
}

}  // namespace cairn
