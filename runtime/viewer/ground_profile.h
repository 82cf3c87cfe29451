#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cairn/pack_reader.h"
#include "cairn/pack_sampler.h"
#include "cairn/status.h"

namespace cairn::viewer {

/// A place of a profile.
struct ProfileRow {
  double distance_m = 0;  ///< along the ellipsoid, from the first place
  LonLat place;
  std::optional<PackSampler::Height> height;  ///< the pack's finest; nullopt where there is none
};

/// Returns the places of a line that is straight in longitude and latitude from place to place, `steps` in
/// each leg, with their heights. Distances are sums of chords. Errors are those of reading a tile.
Result<std::vector<ProfileRow>> ground_profile(const PackReader& pack, const std::vector<LonLat>& line,
                                               int steps = 500);

/// Returns the length of such a line along the ellipsoid, metres.
double length_m(const PackReader& pack, const std::vector<LonLat>& line);

/// Returns the profile as CSV: distance_m,lon,lat,height_m,error_m,level; the last three are empty where
/// there is no height.
std::string to_csv(const std::vector<ProfileRow>& rows);

}  // namespace cairn::viewer
