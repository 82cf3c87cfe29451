#pragma once

#include <cstddef>

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

namespace cairn {

/// Calls `work(threads)` in an arena of this many threads, the calling one included, and returns what it
/// returns. 0 asks for all threads of the machine.
template <class Work>
auto with_threads(int asked, const Work& work) {
  const int threads = asked > 0 ? asked : tbb::info::default_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  return arena.execute([&] { return work(threads); });
}

}  // namespace cairn
