// The method `soar` (Lindstrom & Pascucci 2001; Melkisetoğlu 2005, §4.3).
//
// Each vertex of the bisection hierarchy has an error and a sphere, grown until they contain those of all
// vertices below it, so that the error projected from the sphere's nearest point grows towards the coarse
// levels. One pass from coarse to fine then finds the mesh, and a sphere outside the viewport ends it early.
// The triangles are drawn as one generalised strip per tile (their mesh-refine, submesh-refine and
// tristrip-append).
//
// Departures: a vertex's error is the largest distance of the samples from the triangles bisected there
// (bisection_errors()), with what lies between samples and the Earth's curvature, not the distance of the
// vertex from the middle of its edge, so that the tolerance holds at every sample. It is projected
// isotropically, as theirs, but so that the bound holds up to the viewport's corners (Screen). Spheres of
// neighbouring tiles are not nested in each other; a border gets the vertices of both sides.
//
// Guarantee: every finest sample in the viewport is within the tolerance, as far as the tiles' own error
// allows, which is added to each vertex's.

#include <memory>

#include "runtime/lod/lod_method.h"
#include "runtime/lod/mesh/bisection_forest.h"
#include "runtime/lod/mesh/index_forms.h"
#include "runtime/lod/mesh/nested_spheres.h"
#include "runtime/lod/mesh/prepared_tiles.h"
#include "runtime/lod/mesh/tile_culling.h"
#include "runtime/lod/mesh/tile_window.h"
#include "runtime/lod/mesh/vertex_numbers.h"
#include "runtime/view/screen_error_budget.h"

namespace cairn {
namespace {

/// One pass over a tile, from coarse to fine.
class Refinement {
 public:
  Refinement(const LodScene& scene, std::size_t number, const NestedSpheres& spheres,
             const ScreenErrorBudget& budget, const LodView& view, BisectionForest& forest)
      : tile_(scene.tiles[number]),
        window_(scene, tile_),
        number_(number),
        spheres_(spheres),
        budget_(budget),
        cull_(view.cull),
        forest_(forest) {}

  void run() {
    const int k = forest_.levels(number_);
    if (k == 0) return;
    forest_.enable_centre(number_, k, 0, 0);  // the paper's strip begins with four triangles
    refine(k, 0, 0);
  }

 private:
  void refine(int k, int x, int y) {
    const int h = 1 << (k - 1), c = (2 * x + 1) * h, r = (2 * y + 1) * h;
    if (!is_active(c, r)) return;
    forest_.enable_centre(number_, k, x, y);
    if (is_active(c, r - h)) forest_.enable_middle(number_, k, x, y, BisectionForest::south);
    if (is_active(c + h, r)) forest_.enable_middle(number_, k, x, y, BisectionForest::east);
    if (is_active(c, r + h)) forest_.enable_middle(number_, k, x, y, BisectionForest::north);
    if (is_active(c - h, r)) forest_.enable_middle(number_, k, x, y, BisectionForest::west);
    for (int q = 0; k > 1 && q < 4; ++q) refine(k - 1, 2 * x + (q & 1), 2 * y + (q >> 1));
  }

  bool is_active(int c, int r) const {
    const int column = window_.column() + c, row = window_.row() + r;
    const std::size_t i = static_cast<std::size_t>(row) * static_cast<std::size_t>(tile_.heights->size) +
                          static_cast<std::size_t>(column);
    const SquareSphere sphere{spheres_.positions.at(column, row, window_.height_m(c, r)),
                              static_cast<double>(spheres_.radii_m[i])};
    if (cull_ && !budget_.may_be_visible(sphere)) return false;
    const ScreenErrorBudget::ProjectedScale scale = budget_.isotropic(budget_.scale_of(sphere));
    return static_cast<double>(spheres_.errors_m[i]) > budget_.error_m(scale, tile_.error_m, 0);
  }

  const LodTile& tile_;
  TileWindow window_;
  std::size_t number_;
  const NestedSpheres& spheres_;
  const ScreenErrorBudget& budget_;
  bool cull_;
  BisectionForest& forest_;
};

/// Makes the strip of a tile from its vertices (the paper's mesh-refine).
class Strip {
 public:
  Strip(const BisectionForest& forest, std::size_t tile, const TileWindow& window, VertexNumbers& numbers)
      : forest_(forest), tile_(tile), n_(window.cells()), numbers_(numbers) {}

  std::vector<std::uint32_t> run() {
    const Place south_west{0, 0}, south_east{n_, 0}, north_east{n_, n_}, north_west{0, n_},
        centre{n_ / 2, n_ / 2};
    strip_ = {number(south_west), number(south_west)};
    const bool fans = n_ > 1;
    // Clockwise, so that the triangles face up.
    if (fans) refine(south_west, north_west, centre, 0);
    append(north_west, 1);
    if (fans) refine(north_west, north_east, centre, 0);
    append(north_east, 1);
    if (fans) refine(north_east, south_east, centre, 0);
    append(south_east, 1);
    if (fans) refine(south_east, south_west, centre, 0);
    strip_.push_back(number(south_west));
    return std::move(strip_);
  }

 private:
  struct Place {
    int c;
    int r;
  };

  std::uint32_t number(const Place& p) { return numbers_.number(p.c, p.r); }

  // The paper's submesh-refine, for the triangle with this hypotenuse.
  void refine(const Place& left, const Place& right, const Place& apex, int depth) {
    if (!forest_.has(tile_, apex.c, apex.r)) return;
    const int c = left.c + right.c, r = left.r + right.r;
    const bool has_base = (c & 1) == 0 && (r & 1) == 0;
    const Place base{c / 2, r / 2};
    if (has_base) refine(left, apex, base, depth + 1);
    append(apex, depth & 1);
    if (has_base) refine(apex, right, base, depth + 1);
  }

  // The paper's tristrip-append.
  void append(const Place& place, int parity) {
    const std::uint32_t v = number(place), last = strip_.back(), before = strip_[strip_.size() - 2];
    if (v == last || v == before) return;
    if (parity != parity_) {
      parity_ = parity;
    } else {
      strip_.push_back(before);
    }
    strip_.push_back(v);
  }

  const BisectionForest& forest_;
  std::size_t tile_;
  int n_;
  VertexNumbers& numbers_;
  std::vector<std::uint32_t> strip_;
  int parity_ = 0;
};

class Soar : public LodMethod {
 public:
  void prepare(const LodScene& scene) override {
    spheres_.prepare(scene);
    forest_.prepare(scene);
  }
  std::uint64_t prepared_bytes() const override { return spheres_.bytes() + forest_.bytes(); }

  LodMesh build(const LodScene& scene, const LodView& view) override {
    const auto select = [&] {
      const ScreenErrorBudget budget(view.view, view.tolerance_px, scene.lowest_m);
      const std::vector<std::size_t> drawn = tiles_in_view(scene, view);
      forest_.begin();
      for (const std::size_t i : drawn)
        Refinement(scene, i, spheres_.of(scene.tiles[i]), budget, view, forest_).run();
      forest_.join_corners();
      return drawn;
    };
    return mesh_of_forest(scene, forest_, select,
                          [&](std::size_t i, LodMesh& mesh) { append(scene, i, mesh); });
  }

 private:
  void append(const LodScene& scene, std::size_t i, LodMesh& mesh) {
    const TileWindow window(scene, scene.tiles[i]);
    LodTileMesh out{i, {}, {}};
    numbers_.begin(window, out);
    const std::vector<std::uint32_t> strip = Strip(forest_, i, window, numbers_).run();
    out.triangles = triangles_of_strip(strip);
    mesh.count(IndexForm::degenerate_strip, {strip.size(), 1});
    mesh.tiles.push_back(std::move(out));
  }

  PreparedTiles<NestedSpheres> spheres_;
  BisectionForest forest_;
  VertexNumbers numbers_;
};

}  // namespace

extern const LodMethodInfo soar_lod_method;
const LodMethodInfo soar_lod_method{"soar", true, create_without_options<Soar>};

}  // namespace cairn
