#include "runtime/viewer/flight_recorder.h"

#include <algorithm>
#include <cstdio>

#include "runtime/viewer/numbered_file.h"

namespace cairn::viewer {

std::string FlightRecorder::toggle() {
  if (!flight_) {
    flight_.emplace();
    time_s_ = 0;
    return "recording; R ends it";
  }
  const std::string json = to_json(*flight_);
  flight_.reset();
  const Result<NumberedFile> file = create_numbered("flight", "json", saved_ + 1);
  if (!file) return file.error().message;
  saved_ = file->number;
  const bool written = std::fwrite(json.data(), 1, json.size(), file->file.get()) == json.size() &&
                       std::fflush(file->file.get()) == 0;
  return written ? "saved " + file->name
                 : file->name + ": flight: expected to write it, found that it cannot be";
}

void FlightRecorder::add(const ViewState& view, double dt_s) {
  if (!flight_) return;
  flight_->keys.push_back({time_s_, view});
  time_s_ += std::max(dt_s, 1e-4);
}

}  // namespace cairn::viewer
