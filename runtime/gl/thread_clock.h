#pragma once

#include <ctime>

namespace cairn::gl {

/// CPU time of this thread, in milliseconds: what work took, whatever else the machine does.
inline double thread_cpu_ms() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

}  // namespace cairn::gl
