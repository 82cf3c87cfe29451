#pragma once

#include <optional>
#include <string>

#include "runtime/flight/flight.h"

namespace cairn::viewer {

/// Records what the eye does, a key a frame.
class FlightRecorder {
 public:
  /// Begins, or ends and writes flight-N.json, a new file, into the working folder; returns what to tell the
  /// user.
  std::string toggle();
  void add(const ViewState& view, double dt_s);

 private:
  std::optional<Flight> flight_;
  double time_s_ = 0;
  int saved_ = 0;  // the number of the last file
};

}  // namespace cairn::viewer
