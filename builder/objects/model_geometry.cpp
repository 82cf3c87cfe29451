#include "builder/objects/model_geometry.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include <meshoptimizer.h>

namespace cairn {
namespace {

using Indices = std::vector<unsigned>;

constexpr std::size_t kFewestIndices = 36;  // of a level worth having beside a billboard
constexpr float kMostError = 0.2f;          // of the model's extent
constexpr std::size_t kLevelsWanted = 5;

std::vector<ModelVertex> vertices_of(const SourceMesh& mesh,
                                     const std::vector<std::array<float, 2>>& texture) {
  std::vector<ModelVertex> vertices;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    ModelVertex vertex{mesh.vertices[v].position, mesh.vertices[v].normal, texture[v]};
    float length = 0;
    for (const float n : vertex.normal) length += n * n;
    length = std::sqrt(length);
    if (!(length > 1e-6f)) vertex.normal = {0, 0, 1};
    if (length > 1e-6f)
      for (float& n : vertex.normal) n /= length;
    vertices.push_back(vertex);
  }
  return vertices;
}

std::size_t used_vertices(const Indices& indices) {
  return std::unordered_set<unsigned>(indices.begin(), indices.end()).size();
}

struct Simplified {
  Indices indices;
  float error_m = 0;
};

Simplified simplify(const Indices& from, const std::vector<ModelVertex>& vertices, std::size_t target,
                    float most) {
  Simplified out{Indices(from.size()), 0};
  const float* positions = vertices[0].position_m.data();
  float error = 0;
  const std::size_t count =
      meshopt_simplify(out.indices.data(), from.data(), from.size(), positions, vertices.size(),
                       sizeof(ModelVertex), target / 3 * 3, most, 0, &error);
  out.indices.resize(count);
  out.error_m = error * meshopt_simplifyScale(positions, vertices.size(), sizeof(ModelVertex));
  return out;
}

/// As many vertices and indices as a model may have, all levels together.
Indices within_limits(Indices indices, const std::vector<ModelVertex>& vertices) {
  while (used_vertices(indices) > kMostModelVertices || indices.size() > kMostModelIndices / 2) {
    const Indices fewer = simplify(indices, vertices, indices.size() / 2, 1).indices;
    if (fewer.size() >= indices.size()) return {};
    indices = fewer;
  }
  return indices;
}

std::vector<Simplified> levels_of(const Indices& finest, const std::vector<ModelVertex>& vertices) {
  std::vector<Simplified> levels{{finest, 0}};
  while (levels.size() < kLevelsWanted && levels.back().indices.size() > kFewestIndices) {
    const std::size_t target = finest.size() >> levels.size();
    Simplified next = simplify(finest, vertices, std::max(target, kFewestIndices), kMostError);
    if (next.indices.empty() || next.indices.size() * 5 > levels.back().indices.size() * 4) break;
    next.error_m = std::max(next.error_m, levels.back().error_m);
    levels.push_back(std::move(next));
  }
  return levels;
}

bool is_degenerate(const std::array<unsigned, 3>& t, const std::vector<ModelVertex>& vertices) {
  const auto& a = vertices[t[0]].position_m;
  const auto& b = vertices[t[1]].position_m;
  const auto& c = vertices[t[2]].position_m;
  return a == b || b == c || c == a;
}

Indices drawn_indices(const SourceMesh& mesh, const std::vector<ModelVertex>& vertices) {
  Indices drawn;
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const std::array<unsigned, 3> t{mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]};
    if (!is_degenerate(t, vertices)) drawn.insert(drawn.end(), t.begin(), t.end());
  }
  return drawn;
}

}  // namespace

Status make_geometry(const SourceMesh& mesh, const std::vector<std::array<float, 2>>& texture,
                     ObjectModel& model) {
  const std::vector<ModelVertex> vertices = vertices_of(mesh, texture);
  const Indices finest = within_limits(drawn_indices(mesh, vertices), vertices);
  if (finest.empty())
    return bad_data("expected triangles with an area, at most 65535 vertices of them, found others");
  Indices all;
  for (Simplified& level : levels_of(finest, vertices)) {
    const auto first = static_cast<std::uint32_t>(all.size());
    model.levels.push_back({first, static_cast<std::uint32_t>(level.indices.size()), level.error_m});
    Indices ordered(level.indices.size());
    meshopt_optimizeVertexCache(ordered.data(), level.indices.data(), level.indices.size(), vertices.size());
    all.insert(all.end(), ordered.begin(), ordered.end());
  }
  model.vertices.resize(vertices.size());
  const std::size_t used = meshopt_optimizeVertexFetch(model.vertices.data(), all.data(), all.size(),
                                                       vertices.data(), vertices.size(), sizeof(ModelVertex));
  model.vertices.resize(used);
  for (const unsigned index : all) model.indices.push_back(static_cast<std::uint16_t>(index));
  return {};
}

}  // namespace cairn
