#include "runtime/viewer/ground_probe.h"

#include <array>
#include <cstdio>
#include <utility>

namespace cairn::viewer {

GroundProbe::GroundProbe(std::shared_ptr<const PackReader> pack)
    : pack_(std::move(pack)), thread_([this] { run(); }) {}

GroundProbe::~GroundProbe() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  asked_.notify_one();
  thread_.join();
}

void GroundProbe::ask(LonLat place) {
  {
    const std::lock_guard lock(mutex_);
    due_ = place;
  }
  asked_.notify_one();
}

std::optional<ProbedGround> GroundProbe::latest() {
  const std::lock_guard lock(mutex_);
  return latest_;
}

void GroundProbe::run() {
  PackSampler sampler(*pack_);
  std::unique_lock lock(mutex_);
  while (true) {
    asked_.wait(lock, [this] { return ends_ || due_; });
    if (ends_) return;
    const LonLat place = *std::exchange(due_, std::nullopt);
    lock.unlock();
    const auto height = sampler.height_at(place);
    lock.lock();
    latest_ = ProbedGround{place, height ? *height : std::nullopt};
  }
}

std::string text_of(const ProbedGround& ground) {
  std::array<char, 128> text{};
  if (ground.height) {
    std::snprintf(text.data(), text.size(), "%.6f, %.6f: %.2f m, posts within %.2f m (level %d)",
                  ground.place.lon, ground.place.lat, ground.height->metres,
                  static_cast<double>(ground.height->error_m), ground.height->level);
  } else {
    std::snprintf(text.data(), text.size(), "%.6f, %.6f: no height", ground.place.lon, ground.place.lat);
  }
  return text.data();
}

}  // namespace cairn::viewer
