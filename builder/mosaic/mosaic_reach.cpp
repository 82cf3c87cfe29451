#include "builder/mosaic/mosaic_reach.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "builder/mosaic/fade_weight.h"
#include "builder/mosaic/lattice.h"

namespace cairn {
namespace {

constexpr std::array<double, 3> kTurns = {0.0, -360.0, 360.0};
constexpr std::int64_t kMostCells = 1024;

// More posts than any sample's weights and the edges beyond a group look at together: 34 and 69 on each side.
// What the filling of a void looks at does not count, since then all members do.
constexpr double kPostsAround = 128;
// Of the blocks in which a projected group is resampled, halos included.
constexpr double kSamplesAround = 384;

// Calls visit(cell) for each cell of 1° that the area touches, whatever turn of longitudes it has.
template <class Visit>
void for_each_cell(const GeoBounds& area, const Visit& visit) {
  const auto first = static_cast<std::int64_t>(std::floor(area.west));
  const auto last = std::min(static_cast<std::int64_t>(std::floor(area.east)), first + 359);
  const auto south = static_cast<std::int64_t>(std::floor(std::max(area.south, -91.0)));
  const auto north = static_cast<std::int64_t>(std::floor(std::min(area.north, 91.0)));
  for (std::int64_t y = south; y <= north; ++y) {
    for (std::int64_t x = first; x <= last; ++x) visit(y * 360 + ((x % 360) + 360) % 360);
  }
}

std::int64_t cells_of(const GeoBounds& area) {
  return static_cast<std::int64_t>((area.width() + 2) * (area.height() + 2));
}

GeoBounds grown(const GeoBounds& b, double by) {
  return {b.west - by, b.south - by, b.east + by, b.north + by};
}

bool touches_on_any_turn(const GeoBounds& a, const GeoBounds& b) {
  return std::any_of(kTurns.begin(), kTurns.end(), [&](double turn) {
    return a.touches({b.west + turn, b.south, b.east + turn, b.north});
  });
}

}  // namespace

MosaicReach::MosaicReach(const Mosaic& mosaic) : mosaic_(mosaic), places_(mosaic.groups().size()) {
  for (std::size_t g = 0; g < places_.size(); ++g) {
    const auto& sources = mosaic.groups()[g]->sources();
    for (std::size_t m = 0; m < sources.size(); ++m) {
      const GeoBounds& bounds = mosaic.pool().info(sources[m]).bounds;
      const auto number = static_cast<std::uint32_t>(m);
      if (cells_of(bounds) > kMostCells) {
        places_[g].large.push_back(number);
      } else {
        for_each_cell(bounds, [&](std::int64_t cell) { places_[g].by_cell[cell].push_back(number); });
      }
    }
  }
}

// Degrees around an area up to which a group by itself is looked at, for samples of the area. Into its voids
// it may fade as far as beyond its rim.
double MosaicReach::margin_of(std::size_t group) const {
  const SourceGroup& g = *mosaic_.groups()[group];
  const GroupOverlay::Layer& layer = mosaic_.overlaid()[group];
  const double fade = std::min(layer.fade_degrees, kMostFadePosts * g.spacing_degrees());
  const double posts = kPostsAround * g.spacing_degrees() + fade;
  if (place_on_lattice(mosaic_.pool().info(g.sources().front()))) return posts;
  return posts + kSamplesAround / layer.samples_per_degree * std::exp2(layer.level - g.native_level());
}

std::vector<std::size_t> MosaicReach::members_near(std::size_t group, const GeoBounds& area) const {
  const Places& places = places_[group];
  std::vector<std::uint32_t> found = places.large;
  if (cells_of(area) > 360 * 180) {
    for (const auto& [cell, members] : places.by_cell)
      found.insert(found.end(), members.begin(), members.end());
  } else {
    for_each_cell(area, [&](std::int64_t cell) {
      const auto members = places.by_cell.find(cell);
      if (members != places.by_cell.end())
        found.insert(found.end(), members->second.begin(), members->second.end());
    });
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  std::vector<std::size_t> sources;
  for (const std::uint32_t m : found) {
    const std::size_t source = mosaic_.groups()[group]->sources()[m];
    if (touches_on_any_turn(mosaic_.pool().info(source).bounds, area)) sources.push_back(source);
  }
  return sources;
}

// A group that lies over others is laid upon samples of theirs around its own rim, so each group that counts
// widens the area in which those beneath it do.
std::vector<MosaicReach::Members> MosaicReach::near(const GeoBounds& area) const {
  std::vector<Members> all;
  GeoBounds around = area;
  for (std::size_t g = 0; g < places_.size(); ++g) {
    const GroupOverlay::Layer& layer = mosaic_.overlaid()[g];
    Members members{g, members_near(g, grown(around, margin_of(g) + layer.margin())), false};
    if (members.sources.empty()) continue;
    const RasterPool& pool = mosaic_.pool();
    members.has_voids = std::any_of(members.sources.begin(), members.sources.end(),
                                    [&](std::size_t source) { return pool.has_voids(source); });
    if (members.has_voids) members.sources = mosaic_.groups()[g]->sources();
    around = grown(around, layer.margin() + layer.fade_degrees + 128 / layer.samples_per_degree +
                               4 * mosaic_.groups()[g]->spacing_degrees());
    all.push_back(std::move(members));
  }
  return all;
}

}  // namespace cairn
