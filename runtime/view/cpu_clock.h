#pragma once

#include <ctime>

namespace cairn {

/// Returns the CPU seconds that the calling thread has used since some fixed moment.
/// Unlike wall-clock time it does not count what other threads and programs did meanwhile.
inline double thread_cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace cairn
