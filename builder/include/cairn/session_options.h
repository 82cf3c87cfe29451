#pragma once

#include <cstddef>
#include <filesystem>

namespace cairn {

/// Where a bake writes and what it may use. None of these changes a byte of the pack.
struct SessionOptions {
  std::filesystem::path target;
  std::size_t memory_bytes = std::size_t{1024} << 20;  ///< cap on the resident size of the program
  int threads = 0;                                     ///< 0 = all
  bool resume = false;  ///< goes on from an interrupted bake of equal inputs and options, where there is one
  bool force = false;   ///< replaces an existing target
};

}  // namespace cairn
