#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "cairn/status.h"

namespace cairn {

/// How far a bake is.
struct Progress {
  std::string stage;
  std::uint64_t done = 0;  ///< samples
  std::uint64_t total = 0;
  std::uint64_t bytes_written = 0;
};

/// Is told after each unit of tiles how far the bake is, and returns whether the bake goes on. Called from
/// one thread at a time, never concurrently with itself; the bake waits for it.
using ProgressCallback = std::function<bool(const Progress&)>;

/// The error that a bake ends with after the callback has returned false.
inline Error cancelled(const Progress& progress) {
  return failed("bake: cancelled in " + progress.stage + " after " + std::to_string(progress.done) + " of " +
                std::to_string(progress.total) + " samples");
}

}  // namespace cairn
