#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

namespace hpdm {

/// Threads that share the work on numbered items. One thread at a time gives work.
class WorkerPool {
 public:
  /// `threads`: how many work, the caller's among them; at least 1.
  explicit WorkerPool(int threads);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// Calls work(0) .. work(count - 1), each once, and returns when all have returned. If some throw,
  /// rethrows the exception of the lowest number.
  void ForEach(int count, const std::function<void(int)>& work);

  int threads() const { return static_cast<int>(threads_.size()) + 1; }

 private:
  void Run();
  void Work();

  std::vector<std::thread> threads_;
  std::mutex mutex_;
  std::condition_variable begins_, ends_;
  std::uint64_t round_ = 0;  // of work; the mutex guards this and the next three
  int busy_ = 0;
  bool stops_ = false;
  int failed_ = -1;  // lowest number that threw
  std::exception_ptr failure_;
  const std::function<void(int)>* work_ = nullptr;
  int count_ = 0;
  std::atomic<int> next_ = 0;
};

}  // namespace hpdm
