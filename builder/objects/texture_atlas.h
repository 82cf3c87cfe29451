#pragma once

#include <array>
#include <vector>

#include "builder/objects/model_stream.h"
#include "builder/objects/picture.h"

namespace cairn {

/// One picture for all materials of a mesh.
struct TextureAtlas {
  Picture picture;
  /// For each vertex of the mesh, where it is in the picture: 0 to 1, right and down.
  std::vector<std::array<float, 2>> texture;
};

/// Gives every vertex one material: those of several become several vertices.
void split_by_material(SourceMesh& mesh);

/// Puts the pictures and colours of all materials into one square picture, at most 2048 texels wide. A
/// picture that repeats across the triangles is repeated in it; pictures become smaller where they have no
/// room. REQUIRES: split_by_material().
TextureAtlas make_atlas(const SourceMesh& mesh);

}  // namespace cairn
