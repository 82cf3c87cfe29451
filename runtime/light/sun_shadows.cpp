#include "runtime/light/sun_shadows.h"

#include <algorithm>
#include <utility>

#include "runtime/light/tile_shadow.h"

namespace cairn {

SunShadows::SunShadows(std::shared_ptr<const PackReader> pack, int threads) : ground_(std::move(pack)) {
  for (int i = 0; i < threads; ++i) {
    threads_.emplace_back([this](const std::stop_token& stop) { serve(stop); });
  }
}

SunShadows::~SunShadows() = default;

void SunShadows::request(std::vector<ShadowRequest> due) {
  std::reverse(due.begin(), due.end());
  {
    const std::lock_guard lock(mutex_);
    const auto is_under_way = [this](const ShadowRequest& request) {
      return std::any_of(in_progress_.begin(), in_progress_.end(), [&](const ShadowRequest& begun) {
        return begun.id == request.id && begun.to_sun == request.to_sun;
      });
    };
    std::erase_if(due, is_under_way);
    due_ = std::move(due);
  }
  wake_.notify_all();
}

std::vector<TileShadow> SunShadows::take() {
  const std::lock_guard lock(mutex_);
  for (const TileShadow& shadow : done_) {
    std::erase_if(in_progress_, [&](const ShadowRequest& begun) {
      return begun.id == shadow.id && begun.to_sun == shadow.to_sun;
    });
  }
  return std::exchange(done_, {});
}

void SunShadows::serve(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (wake_.wait(lock, stop, [this] { return !due_.empty(); })) {
    const ShadowRequest request = std::move(due_.back());
    due_.pop_back();
    in_progress_.push_back(request);
    lock.unlock();
    TileShadow shadow{request.id, request.to_sun,
                      tile_shadow(ground_, request.id, *request.heights, request.to_sun)};
    lock.lock();
    done_.push_back(std::move(shadow));
    if (stop.stop_requested()) return;
  }
}

}  // namespace cairn
