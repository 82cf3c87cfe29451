#include "runtime/viewer/flight_recorder.h"

#include <algorithm>
#include <fstream>

namespace cairn::viewer {

std::string FlightRecorder::toggle() {
  if (!flight_) {
    flight_.emplace();
    time_s_ = 0;
    return "recording; R ends it";
  }
  const std::string name = "flight-" + std::to_string(++saved_) + ".json";
  std::ofstream out(name, std::ios::trunc);
  out << to_json(*flight_);
  flight_.reset();
  return out.flush() ? "saved " + name : name + ": flight: expected to write it, found that it cannot be";
}

void FlightRecorder::add(const ViewState& view, double dt_s) {
  if (!flight_) return;
  flight_->keys.push_back({time_s_, view});
  time_s_ += std::max(dt_s, 1e-4);
}

}  // namespace cairn::viewer
