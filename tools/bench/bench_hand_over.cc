#include <atomic>
#include <chrono>
#include <cstdint>
#include <latch>
#include <thread>

#include "engine/base/check.h"
#include "engine/snapshots.h"
#include "engine/threads/realtime.h"
#include "engine/threads/triple_buffer.h"
#include "tools/bench/bench_results.h"

namespace hpdm {
namespace {

Nanoseconds Now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(TimingClock::now().time_since_epoch())
      .count();
}

// Returns the number of a snapshot. Both sides touch it, so its cache line moves as in a session.
template <typename Snapshot>
auto& Number(Snapshot& snapshot) {
  if constexpr (requires { snapshot.sequence; }) {
    return snapshot.sequence;
  } else if constexpr (requires { snapshot.tick; }) {
    return snapshot.tick;
  } else {
    return snapshot.step.number;
  }
}

// One thread publishes every two microseconds while the other polls. Each finds the shared word in
// the other's cache, as in a session.
template <typename Snapshot>
HandOverResults TimeHandOver(const char* name, int exchanges) {
  constexpr Nanoseconds kApart = 2000;
  TripleBuffer<Snapshot> buffer;
  HandOverResults results{.snapshot = name, .bytes = sizeof(Snapshot), .publish = {}, .update = {}};
  std::atomic<bool> over = false;
  std::latch both_run(2);
  std::jthread reader([&] {
    RequestRealtime({.fifo_priority = 80});
    both_run.arrive_and_wait();
    std::uint64_t seen = 0;
    while (!over.load(std::memory_order_relaxed)) {
      const Nanoseconds start = Now();
      const bool is_new = buffer.Update();
      const Nanoseconds took = Now() - start;
      if (!is_new) continue;
      results.update.Add(took);
      HPDM_CHECK(Number(buffer.Front()) > seen);
      seen = Number(buffer.Front());
    }
  });
  std::jthread writer([&] {
    RequestRealtime({.fifo_priority = 80});
    both_run.arrive_and_wait();
    for (int i = 1; i <= exchanges; ++i) {
      Number(buffer.Back()) = static_cast<std::uint64_t>(i);
      const Nanoseconds start = Now();
      buffer.Publish();
      results.publish.Add(Now() - start);
      while (Now() - start < kApart) {
      }
    }
    over = true;
  });
  writer.join();
  reader.join();
  return results;
}

}  // namespace

std::vector<HandOverResults> TimeHandOvers(bool quick) {
  const int exchanges = quick ? 20'000 : 200'000;
  return {TimeHandOver<ToolState>("ToolState", exchanges),
          TimeHandOver<ContactPatch>("ContactPatch", exchanges),
          TimeHandOver<SceneSnapshot>("SceneSnapshot", exchanges),
          TimeHandOver<DeviceSample>("DeviceSample", exchanges)};
}

double ClockReadingNanoseconds() {
  Histogram readings;
  for (int i = 0; i < 100'000; ++i) {
    const Nanoseconds start = Now();
    readings.Add(Now() - start);
  }
  return static_cast<double>(readings.Percentile(0.5));
}

}  // namespace hpdm
