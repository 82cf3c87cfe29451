#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "cairn/surface_mesh.h"
#include "runtime/surface/surface_patch.h"

namespace cairn {

/// Makes the vertices of one patch. Vertices that patches share have equal bits from each of them.
class PatchVertices {
 public:
  explicit PatchVertices(const SurfacePatch& patch);

  struct Vertex {
    SurfaceVertex vertex;
    bool is_void = false;
  };
  /// Of the lattice: i columns from the west, j rows from the south.
  Vertex at(int i, int j) const;

 private:
  ShownHeight height(int i, int j) const;

  const SurfacePatch& patch_;
  int samples_log2_;
  int column_ = 0;  // of the tile's samples, at the south-west corner; where the lattice has no others
  int row_ = 0;
  std::int64_t spacing_;
  LatticePoint corner_;
};

/// Which vertices of a patch's lattice are drawn, and the triangles between them.
///
/// A triangle is bisected at the middle of its base where that is a vertex: the hierarchy of RqtSteps.
/// REQUIRES: the patch outlives it.
class PatchTriangulation {
 public:
  static constexpr int kMostSamples = ((1 << kPatchCellsLog2) + 1) * ((1 << kPatchCellsLog2) + 1);

  struct Corner {
    int column;
    int row;
  };
  /// Counter-clockwise seen from above: the base runs from `from` to `to`.
  struct Triangle {
    Corner from;
    Corner to;
    Corner apex;
  };

  /// Takes the vertices of the sides, and all that the patch's step has.
  PatchTriangulation(const SurfacePatch& patch, const SideVertices& sides);

  int size() const { return size_; }
  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(size_) + static_cast<std::size_t>(column);
  }
  std::array<Triangle, 2> halves() const;
  /// Returns where the triangle is bisected; nullopt where it is drawn.
  std::optional<Corner> middle_of(const Triangle& triangle) const;
  /// Returns the drawn triangle that contains a place, in columns and rows of the lattice; of several, one.
  Triangle triangle_at(double column, double row) const;

 private:
  void take_own();
  void take_forced();
  void take_sides(const SideVertices& sides);
  void raise(int column, int row);

  const SurfacePatch& patch_;
  int size_;
  bool rising_;
  std::array<std::uint8_t, kMostSamples> is_vertex_;  // of size_ × size_ samples
};

struct PatchMesh {
  std::vector<SurfaceVertex> vertices;
  std::vector<std::uint16_t> indices;  ///< three a triangle, counter-clockwise seen from above
};

/// Returns the triangulation of a patch that has these vertices on its sides and all that its step has. Void
/// samples are part of it, at the height of their filling. 2 to 10 µs for the usual hundred triangles.
PatchMesh build_patch_mesh(const SurfacePatch& patch, const SideVertices& sides);

}  // namespace cairn
