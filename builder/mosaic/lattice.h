#pragma once

#include <cstdint>
#include <optional>

#include "builder/raster/raster_source.h"
#include "builder/resample/lattice_axis.h"

namespace cairn {

/// A regular grid of posts in lat/long that covers the Earth: post (i, j) lies at
/// lon = (i + lon.phase) / lon.posts_per_degree - 180, lat = (j + lat.phase) / lat.posts_per_degree - 90.
struct Lattice {
  LatticeAxis lon;
  LatticeAxis lat;

  double lon_of(std::int64_t i) const {
    return (static_cast<double>(i) + lon.phase) / lon.posts_per_degree - 180.0;
  }
  double lat_of(std::int64_t j) const {
    return (static_cast<double>(j) + lat.phase) / lat.posts_per_degree - 90.0;
  }
  /// Posts around the Earth, or nullopt where 360 degrees are no whole number of posts.
  std::optional<std::int64_t> posts_around() const;
};

/// A raster's place on a lattice: its south-west post, and which way its rows run.
struct LatticePlacement {
  Lattice lattice;
  std::int64_t i0 = 0;
  std::int64_t j0 = 0;
  bool north_up = true;  ///< row 0 is the northernmost
};

/// The place of a geographic raster whose columns run east; nullopt for others.
std::optional<LatticePlacement> place_on_lattice(const RasterInfo& info);

/// `b` re-expressed on `a`'s lattice, where posts of both coincide to 1e-4 of a post.
std::optional<LatticePlacement> rebase(const LatticePlacement& b, const Lattice& a);

}  // namespace cairn
