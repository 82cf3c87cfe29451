#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include <glm/vec3.hpp>

#include "cairn/height_tile.h"
#include "cairn/pack_reader.h"
#include "cairn/tile_id.h"
#include "runtime/light/shadow_ground.h"

namespace cairn {

/// A tile whose shadow is due, and the sun that casts it.
struct ShadowRequest {
  TileId id;
  std::shared_ptr<const HeightTile> heights;
  glm::dvec3 to_sun{};
};

/// A tile's shadow, as tile_shadow() has it.
struct TileShadow {
  TileId id;
  glm::dvec3 to_sun{};
  std::vector<std::int8_t> texels;
};

/// Threads that make shadows beside those that load tiles.
inline constexpr int kShadowThreads = 2;

/// Makes the shadows of tiles on threads of its own. One thread calls it.
class SunShadows {
 public:
  SunShadows(std::shared_ptr<const PackReader> pack, int threads);
  /// Waits for the shadows in progress, one per thread.
  ~SunShadows();

  /// Takes what is due in place of what was due before and has not been begun, the most urgent first. What is
  /// being made for the sun that is asked for goes on.
  void request(std::vector<ShadowRequest> due);

  /// Returns the shadows that are done since the last call.
  std::vector<TileShadow> take();

 private:
  void serve(const std::stop_token& stop);

  ShadowGround ground_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::vector<ShadowRequest> due_;          // guarded by mutex_; the most urgent last
  std::vector<ShadowRequest> in_progress_;  // guarded by mutex_; until taken
  std::vector<TileShadow> done_;            // guarded by mutex_
  std::vector<std::jthread> threads_;       // the last: they use all of the others
};

}  // namespace cairn
