#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace cairn {

/// How far a bake is. Called from one thread at a time.
struct Progress {
  std::string stage;
  std::uint64_t done = 0;  ///< samples
  std::uint64_t total = 0;
  std::uint64_t bytes_written = 0;
};
using ProgressCallback = std::function<void(const Progress&)>;

}  // namespace cairn
