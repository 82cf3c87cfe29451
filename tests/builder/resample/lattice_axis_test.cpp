#include "builder/resample/lattice_axis.h"

#include <catch2/catch.hpp>

namespace cairn {

TEST_CASE("decimals as files carry them give the whole lattice that was meant") {
  // N46E008.tif: pixel-is-point, its corner half a pixel out.
  const LatticeSpan swiss =
      lattice_of(180 + 7.999583333333334 + 0.5 * 0.000833333333333, 0.000833333333333, 1201, 1e-4);
  CHECK(swiss.axis == LatticeAxis{1200, 0});
  CHECK(swiss.first == 188 * 1200);
  const LatticeSpan etopo = lattice_of(0.0, 0.083333333333333, 4320, 1e-4);
  CHECK(etopo.axis == LatticeAxis{12, 0});
  CHECK(etopo.first == 0);
}

TEST_CASE("pixel-is-area rasters lie half a post off") {
  const LatticeSpan span =
      lattice_of(180 - 122.000416666666666 + 0.00041666666666666 * 2, 0.000833333333333, 1201, 1e-4);
  CHECK(span.axis.posts_per_degree == 1200);
  CHECK(span.axis.phase == 0.5);
  CHECK(span.first == 58 * 1200);
}

TEST_CASE("spacings that fit no whole number of posts stay as they are") {
  const LatticeSpan span = lattice_of(180 + 20.068568081999999, 0.000838829990207, 919, 1e-3);
  CHECK(span.axis.posts_per_degree == 1 / 0.000838829990207);
  CHECK((static_cast<double>(span.first) + span.axis.phase) / span.axis.posts_per_degree ==
        Approx(200.068568081999999).epsilon(1e-14));
  CHECK(lattice_of(0, 1.0 / 1201, 100000, 1e-4).axis.posts_per_degree == 1201);
  CHECK(lattice_of(0, 1.0 / 1200.01, 1201, 1e-3).axis.posts_per_degree != 1200);
  // Nine decimals move the last of 1201 posts by 4.8e-4 of a spacing.
  CHECK(lattice_of(0, 0.000833333, 1201, 1e-3).axis.posts_per_degree == 1200);
  CHECK(lattice_of(0, 0.000833333, 1201, 1e-4).axis.posts_per_degree == 1 / 0.000833333);
}

}  // namespace cairn
