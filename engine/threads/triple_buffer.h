#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace hpdm {

/// Hands the latest value from one writing thread to one reading thread. Wait-free on both sides:
/// one atomic exchange each, no lock, no fence, no copy and no allocation. The reader never sees a
/// value half written and never an older one than before; values in between may be skipped.
///
///     writer                     shared                     reader
///     back_  -----Publish----->  middle_  -----Update----->  front_
///                                index and "new" bit
///
/// Each of the three slots belongs to exactly one of writer, middle and reader at any time. The
/// exchange with acquire-release order passes ownership, so plain reads and writes of the slot are
/// race-free. Values stay in place: the writer's slot holds the value of an earlier Publish, so the
/// writer must set every field.
template <typename T>
class TripleBuffer {
 public:
  /// All three slots start as copies of `initial`, so arrays inside T keep their sizes.
  TripleBuffer() { Add(3, Initial()); }
  explicit TripleBuffer(const T& initial) { Add(3, initial); }
  /// For a writer and a reader in one thread, neither of which holds on to a value while the other
  /// works: all three are one slot.
  static TripleBuffer OfOneThread() { return OfOneThread(Initial()); }
  static TripleBuffer OfOneThread(const T& initial) { return TripleBuffer(initial, kShared); }
  TripleBuffer(const TripleBuffer&) = delete;
  TripleBuffer& operator=(const TripleBuffer&) = delete;

  /// Writer only: the slot to fill in. Wait-free.
  T& Back() { return slots_[back_].value; }

  /// Writer only: hands the filled slot over. Wait-free, one atomic exchange.
  void Publish() { back_ = middle_.exchange(back_ | kNew, std::memory_order_acq_rel) & kIndex; }

  /// Reader only: takes the newest value if there is one since the last call; true if there was.
  /// Wait-free, at most one atomic exchange.
  bool Update() {
    if ((middle_.load(std::memory_order_relaxed) & kNew) == 0) return false;
    front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
    return true;
  }

  /// Reader only: the value of the last successful Update (the initial one before). Wait-free.
  const T& Front() const { return slots_[front_].value; }

 private:
  enum Sharing { kShared };
  TripleBuffer(const T& initial, Sharing) : back_(0), middle_(0), front_(0) { Add(1, initial); }
  // A value may be too large for the stack. A copy may take over less than all of it, so that most of
  // a slot's pages are never touched: those of a value that is freed would come back in other slots.
  static const T& Initial() {
    static const auto initial = std::make_unique<const T>();
    return *initial;
  }
  void Add(std::size_t count, const T& initial) {
    slots_.reserve(count);
    while (slots_.size() < count) slots_.emplace_back(initial);
  }

  static constexpr std::uint32_t kIndex = 3;
  static constexpr std::uint32_t kNew = 4;

  // Has cache lines of its own, so that the writer and the reader never share one.
  struct alignas(64) Slot {
    explicit Slot(const T& initial) : value(initial) {}
    T value;
  };

  std::vector<Slot> slots_;                            // 3, or 1 of one thread
  alignas(64) std::uint32_t back_ = 0;                 // writer's
  alignas(64) std::atomic<std::uint32_t> middle_ = 1;  // shared
  alignas(64) std::uint32_t front_ = 2;                // reader's
};

}  // namespace hpdm
