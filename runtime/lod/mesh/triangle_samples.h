#pragma once

#include <array>
#include <span>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "cairn/height_tile.h"
#include "cairn/view_state.h"
#include "runtime/lod/mesh/lod_scene.h"
#include "runtime/lod/mesh/sample_rows.h"
#include "runtime/lod/mesh/square_errors.h"
#include "runtime/lod/mesh/subtriangle_error_ranges.h"
#include "runtime/view/horizon.h"

namespace cairn {

/// What is closer along the view is treated as at the camera, in metres.
constexpr double kNearest_m = 1e-3;

/// One camera and tolerance, as the tests of single triangles read them. Lengths are at depth 1.
struct TriangleView {
  /// `lowest_m` is the lowest height of the scene. What the ellipsoid at that height occludes is invisible.
  TriangleView(const LodView& view, double lowest_m);

  CameraFrame camera;
  SampleCamera sample_camera;
  Horizon horizon;
  double tolerance;
  double half_width;  ///< of the viewport, with half a pixel for what rounding moves over its sides
  double half_height;
};

/// The surface under the triangles of one tile.
struct TileSurface {
  const HeightTile& heights;
  double quantum_m;
  const SquareErrors& errors;
  const SubtriangleErrorRanges& ranges;
  double error_m;  ///< the finest samples are no farther from the heights' bilinear surface, vertically
};

/// (column, row) of a sample of the tile.
using SampleAddress = std::array<int, 2>;
/// The two corners of the base, then the right angle, anticlockwise.
using SampleTriangle = std::array<SampleAddress, 3>;

/// What was stored, when the tile was loaded, about a triangle of its hierarchy.
struct StoredError {
  double error_m;    ///< the largest vertical distance to a sample under the triangle
  double sagitta_m;  ///< SquareErrors::sagitta_m() of the triangle
  int span;          ///< cells along its legs, or along its base where that runs along the grid
  const SubtriangleErrorRanges::Ranges* ranges;  ///< null for small triangles
};
StoredError stored_error_of(const TileSurface& surface, const SampleTriangle& triangle);

/// A triangle's corner, projected.
struct ProjectedSample {
  SampleAddress at{};
  double height_m = 0;
  glm::dvec3 place{0};       ///< geocentric
  glm::dvec3 in_camera{0};   ///< right, up, along the view
  glm::dvec2 ray{0};         ///< in_camera⊥ / in_camera.z, if that is above kNearest_m
  bool in_viewport = false;  ///< above the horizon or not
};

struct CornerSamples {
  CornerSamples(const TriangleView& view, const TileSurface& surface, const SampleTriangle& triangle,
                const StoredError& error);

  StoredError stored;
  ProjectedSample a;  ///< the base
  ProjectedSample b;
  ProjectedSample c;  ///< the right angle
};

/// Returns the unit normal of the ellipsoid at a sample, in camera coordinates.
glm::dvec3 up_at(const TriangleView& view, const TileSurface& surface, const SampleAddress& at);

/// Triangles and parts of at most so many cells are tested sample by sample.
constexpr int kMaxExactSpan = 8;
/// Returns whether any sample within these corners exceeds the tolerance on the triangle's plane. REQUIRES:
/// the horizon hides none of them; the corners span at most kMaxExactSpan cells.
bool any_sample_exceeds(const TriangleView& view, const TileSurface& surface, const CornerSamples& samples,
                        std::span<const SampleAddress> corners);

}  // namespace cairn
