#include "tools/python/native/worker_pool.h"

#include <algorithm>

namespace hpdm {

WorkerPool::WorkerPool(int threads) {
  for (int t = 1; t < threads; ++t) threads_.emplace_back([this] { Run(); });
}

WorkerPool::~WorkerPool() {
  {
    const std::lock_guard lock(mutex_);
    stops_ = true;
  }
  begins_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void WorkerPool::ForEach(int count, const std::function<void(int)>& work) {
  {
    const std::lock_guard lock(mutex_);
    work_ = &work;
    count_ = count;
    next_ = 0;
    failed_ = -1;
    busy_ = static_cast<int>(threads_.size());
    ++round_;
  }
  begins_.notify_all();
  Work();
  std::unique_lock lock(mutex_);
  ends_.wait(lock, [this] { return busy_ == 0; });
  if (failed_ >= 0) std::rethrow_exception(failure_);
}

void WorkerPool::Run() {
  std::uint64_t done = 0;
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      begins_.wait(lock, [&] { return stops_ || round_ != done; });
      if (stops_) return;
      done = round_;
    }
    Work();
    const std::lock_guard lock(mutex_);
    if (--busy_ == 0) ends_.notify_one();
  }
}

void WorkerPool::Work() {
  for (int i = next_++; i < count_; i = next_++) {
    try {
      (*work_)(i);
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (failed_ >= 0 && failed_ <= i) continue;
      failed_ = i;
      failure_ = std::current_exception();
    }
  }
}

}  // namespace hpdm
