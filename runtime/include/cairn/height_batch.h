#pragma once

#include <future>
#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "cairn/pack_sampler.h"

namespace cairn {

/// Looks up heights at full detail on threads of its own, so that the caller never waits for a disk.
///
/// Threads: sample() may be called from any thread. The destructor stops all batches and waits for the reads
/// in progress, one per worker.
class HeightBatches {
 public:
  using Heights = std::vector<std::optional<PackSampler::Height>>;

  /// REQUIRES: a pack, workers >= 1. More than one worker works on several batches, not on one.
  explicit HeightBatches(std::shared_ptr<const PackReader> pack, int workers = 1);
  HeightBatches(HeightBatches&&) noexcept;
  HeightBatches& operator=(HeightBatches&&) noexcept;
  ~HeightBatches();

  /// Returns at once. The future has what PackSampler::height_at() returns for each place, in their order;
  /// each tile is read once, in whatever order the places are. A batch that is stopped, by `stop` or by the
  /// destructor, has ErrorCode::failed, with the tile in work finished first.
  std::future<Result<Heights>> sample(std::vector<LonLat> places, std::stop_token stop = {});

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cairn
