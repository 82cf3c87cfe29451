#pragma once

#include <span>

#include "builder/resample/index_window.h"
#include "builder/voids/fill_pyramid.h"

namespace cairn {

/// Fills voids smoothly from their rims, however large, also beyond the raster's edge: pull-push (Gortler et
/// al., The Lumigraph, 1996, §3.4) with two relaxation sweeps a level, so that the fill comes near a membrane
/// spanned by the valid posts. It starts at the rim's height and never leaves the range of the raster's
/// heights.
///
/// The pyramid stands on the posts' absolute indices, its fine levels made from the window and the coarse
/// ones given, so any two windows give the same bits. Works for any field on a lattice, differences of
/// rasters too.

/// The posts that filling a window depends on: 140 to 176 more on each side. Beyond the raster they are void.
IndexWindow posts_to_fill(IndexWindow window);

/// `posts`: heights of posts_to_fill(window), NaN where void; `out`: the window's heights, the valid ones as
/// they were. No post is left void unless the pyramid is empty, when none is filled.
void fill_voids(const FillPyramid& pyramid, std::span<const float> posts, IndexWindow window,
                std::span<float> out);

}  // namespace cairn
