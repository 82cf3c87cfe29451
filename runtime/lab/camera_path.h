#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "cairn/status.h"
#include "runtime/lab/lab_terrain.h"
#include "cairn/view_state.h"

namespace cairn {

/// The views of a flight, one per frame.
struct CameraPath {
  std::string name;
  std::vector<ViewState> views;
};

/// Returns the names of the built-in flights, which lead around the pack's finest tile of the greatest relief
/// or over all of the Earth:
///   hover           300 m above the corner of four tiles, shaking by some metres
///   low             100 m above the ground along 20 km of it, looking ahead
///   orbit-to-ground from 20,000 km down to 200 m, looking down and then ahead
///   spin            1 km above the ground, turning by 15 degrees per frame
///   mach3           3 km above the ground at 1029 m/s, 10 frames per second
///   antimeridian    60 km high, from 178°E to 178°W at 16.5°S
///   pole            60 km high, from 88.5°N over the pole to 88.5°N on the other side
///   pitch           2 km above the ground, from looking ahead to looking down (Melkisetoğlu 2005, §8.3,
///   §8.4)
const std::vector<std::string_view>& built_in_flights();

/// Returns a built-in flight, or one from a file that cairn-view recorded, in this many frames. The error is
/// usage if it is neither, bad_data if the pack has nothing to fly over. REQUIRES: frames >= 2.
Result<CameraPath> camera_path(const std::string& name_or_file, LabTerrain& terrain, std::size_t frames);

}  // namespace cairn
