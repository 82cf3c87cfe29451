#pragma once

#include <chrono>

#include "cairn/progress.h"

namespace cairn {

/// What Progress counts.
enum class ProgressUnit { samples, parts };

/// Tells a person on stderr how far a bake or another long verb is: one line that is written over on a
/// terminal, plain lines every ten seconds otherwise.
class BakeProgress {
 public:
  explicit BakeProgress(ProgressUnit unit = ProgressUnit::samples);
  ~BakeProgress();  ///< ends the line
  void show(const Progress& progress);

 private:
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point shown_;
  ProgressUnit unit_;
  bool terminal_;
  bool line_open_ = false;
};

}  // namespace cairn
