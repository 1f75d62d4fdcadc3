#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/base/check.h"

namespace hpdm {

/// A bounded queue from one producing thread to one consuming thread that keeps every item, in
/// order. Wait-free on both sides: no lock, no allocation after construction. A push into a full
/// queue is refused and counted, so the producer never blocks.
///
/// The ring has a power-of-two number of slots; head_ and tail_ only grow. Each side keeps the
/// other's last known position and reads the shared one only if the ring looks full (or empty). The
/// two positions have cache lines of their own.
template <typename T>
class SpscQueue {
 public:
  /// Room for at least `capacity` items (rounded up to a power of two).
  explicit SpscQueue(std::size_t capacity) : ring_(std::bit_ceil(capacity)) {
    HPDM_CHECK(capacity > 0);
  }
  SpscQueue(const SpscQueue&) = delete;
  SpscQueue& operator=(const SpscQueue&) = delete;

  /// Producer only. Returns false and counts an overflow if the queue is full. Wait-free.
  bool Push(const T& item) {
    const std::uint64_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - head_seen_ == ring_.size()) {
      head_seen_ = head_.load(std::memory_order_acquire);
      if (tail - head_seen_ == ring_.size()) {
        overflows_.store(overflows_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
        return false;
      }
    }
    ring_[tail & (ring_.size() - 1)] = item;
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  /// Consumer only. Returns false if the queue is empty. Wait-free.
  bool Pop(T* item) {
    const std::uint64_t head = head_.load(std::memory_order_relaxed);
    if (head == tail_seen_) {
      tail_seen_ = tail_.load(std::memory_order_acquire);
      if (head == tail_seen_) return false;
    }
    *item = ring_[head & (ring_.size() - 1)];
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  /// Items refused so far. Any thread, wait-free.
  std::uint64_t Overflows() const { return overflows_.load(std::memory_order_relaxed); }

 private:
  std::vector<T> ring_;
  alignas(64) std::atomic<std::uint64_t> tail_ = 0;  // written by the producer
  std::uint64_t head_seen_ = 0;                      // producer's
  std::atomic<std::uint64_t> overflows_ = 0;         // written by the producer
  alignas(64) std::atomic<std::uint64_t> head_ = 0;  // written by the consumer
  std::uint64_t tail_seen_ = 0;                      // consumer's
};

}  // namespace hpdm
