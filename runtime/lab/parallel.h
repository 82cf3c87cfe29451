#pragma once

#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace cairn {

/// Calls work(0) … work(count-1), each once, from this many threads.
template <class Work>
void for_each_index(std::size_t count, int threads, const Work& work) {
  std::atomic<std::size_t> next{0};
  const auto run = [&] {
    for (std::size_t i = next++; i < count; i = next++) work(i);
  };
  std::vector<std::jthread> others;
  for (int i = 1; i < threads; ++i) others.emplace_back(run);
  run();
}

}  // namespace cairn
