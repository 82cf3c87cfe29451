#include "runtime/surface/frame_workers.h"

namespace cairn {

FrameWorkers::FrameWorkers(int threads) : next_item_(0) {
  for (int i = 0; i < threads; ++i)
    threads_.emplace_back([this](const std::stop_token& stop) { serve(stop); });
}

FrameWorkers::~FrameWorkers() {
  for (std::jthread& thread : threads_) thread.request_stop();
  threads_.clear();
}

void FrameWorkers::run(std::size_t count, const std::function<void(std::size_t)>& work) {
  const Job job{&work, count};
  {
    const std::lock_guard lock(mutex_);
    job_ = job;
    ++job_number_;
    next_item_ = 0;
  }
  wake_.notify_all();
  take_items(job);
  // A thread that has not woken yet finds no job, so that nobody uses `work` after this.
  std::unique_lock lock(mutex_);
  job_ = {};
  all_done_.wait(lock, [this] { return busy_ == 0; });
}

void FrameWorkers::serve(const std::stop_token& stop) {
  std::uint64_t served = 0;
  std::unique_lock lock(mutex_);
  while (wake_.wait(lock, stop, [&] { return job_.work != nullptr && job_number_ != served; })) {
    served = job_number_;
    const Job job = job_;
    ++busy_;
    lock.unlock();
    take_items(job);
    lock.lock();
    if (--busy_ == 0) all_done_.notify_one();
  }
}

void FrameWorkers::take_items(const Job& job) {
  for (std::size_t i = next_item_++; i < job.count; i = next_item_++) (*job.work)(i);
}

}  // namespace cairn
