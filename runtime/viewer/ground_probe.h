#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "cairn/pack_reader.h"
#include "cairn/pack_sampler.h"

namespace cairn::viewer {

/// A place and the pack's finest height there.
struct ProbedGround {
  LonLat place;
  std::optional<PackSampler::Height> height;  ///< nullopt where the pack has none, or it cannot be read
};

/// Looks up the height under the cursor on a thread of its own, so that no frame waits for a disk. One
/// caller.
class GroundProbe {
 public:
  explicit GroundProbe(std::shared_ptr<const PackReader> pack);
  ~GroundProbe();
  GroundProbe(const GroundProbe&) = delete;
  GroundProbe& operator=(const GroundProbe&) = delete;

  /// Asks for a place, instead of what was asked for before.
  void ask(LonLat place);
  /// Returns the latest place that was looked up; nullopt before the first.
  std::optional<ProbedGround> latest();

 private:
  void run();

  std::shared_ptr<const PackReader> pack_;
  std::mutex mutex_;
  std::condition_variable asked_;
  std::optional<LonLat> due_;
  std::optional<ProbedGround> latest_;
  bool ends_ = false;
  std::thread thread_;
};

/// Returns "8.450120, 46.350230: 1234.5 m, posts within 0.5 m (level 3)".
std::string text_of(const ProbedGround& ground);

}  // namespace cairn::viewer
