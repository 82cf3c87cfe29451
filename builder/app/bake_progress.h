#pragma once

#include <chrono>

#include "cairn/progress.h"

namespace cairn {

/// Tells a person on stderr how far a bake or another long verb is: one line that is written over on a
/// terminal, plain lines every ten seconds otherwise.
class BakeProgress {
 public:
  BakeProgress();
  ~BakeProgress();  ///< ends the line
  void show(const Progress& progress);

 private:
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point shown_;
  bool terminal_;
  bool line_open_ = false;
};

}  // namespace cairn
