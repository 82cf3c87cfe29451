#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace cairn {

/// Threads that share the work of one frame with the thread that the frame belongs to.
///
/// One thread calls run(). Between two calls the others sleep.
class FrameWorkers {
 public:
  explicit FrameWorkers(int threads);
  /// Waits for the threads to end. REQUIRES: no run() is in progress.
  ~FrameWorkers();

  /// Calls work(i) for every i below count, on these threads and on the caller's, and returns when all calls
  /// have. REQUIRES: `work` throws nothing and may be called from several threads at once.
  void run(std::size_t count, const std::function<void(std::size_t)>& work);

 private:
  struct Job {
    const std::function<void(std::size_t)>* work = nullptr;
    std::size_t count = 0;
  };

  void serve(const std::stop_token& stop);
  void take_items(const Job& job);

  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::condition_variable_any all_done_;
  Job job_;                             // guarded by mutex_; no work between two calls of run()
  std::uint64_t job_number_ = 0;        // guarded by mutex_
  std::size_t busy_ = 0;                // threads with the job; guarded by mutex_
  std::atomic<std::size_t> next_item_;  // of the job
  std::vector<std::jthread> threads_;
};

}  // namespace cairn
