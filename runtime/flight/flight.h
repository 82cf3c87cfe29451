#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cairn/status.h"
#include "cairn/view_state.h"

namespace cairn::viewer {

/// Where the eye is at a time.
struct FlightKey {
  double time_s = 0;
  ViewState view;  ///< eye, height, heading and pitch count
};

/// A recorded path: {"frames_per_second": 30, "keys": [{"time", "lon", "lat", "height", "heading",
/// "pitch"}…]}, times ascending from 0, in the units of the option --camera.
struct Flight {
  double frames_per_second = 30;
  std::vector<FlightKey> keys;  ///< one at least

  /// Between two keys the eye moves along the straight line in longitude (the short way round), latitude and
  /// the logarithm of height above 1 m below the lower of both, headings turning the short way.
  ViewState at(double time_s) const;
  std::size_t frame_count() const;
};

/// bad_data names the first field that is missing or out of range.
Result<Flight> read_flight(const std::filesystem::path& path);
std::string to_json(const Flight& flight);

}  // namespace cairn::viewer
