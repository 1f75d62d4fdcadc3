#pragma once

#include <time.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <functional>
#include <vector>

namespace hpdm {

using TimingClock = std::chrono::steady_clock;

inline double MillisecondsSince(TimingClock::time_point start) {
  return std::chrono::duration<double, std::milli>(TimingClock::now() - start).count();
}

/// Returns the CPU time of the calling thread, ms. It stands still while another thread has the
/// core.
inline double ThreadMilliseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

/// Times of repeated runs of one function, us. The minimum is the machine's best, the median its
/// usual time.
struct Timing {
  double median_us = 0;
  double minimum_us = 0;
};

/// Returns the time of `a` and then `b`, `times_b` times.
inline Timing Sum(const Timing& a, const Timing& b, double times_b = 1) {
  return {a.median_us + times_b * b.median_us, a.minimum_us + times_b * b.minimum_us};
}

/// Returns minimum and median. `times_us` has at least one value.
inline Timing Summary(std::vector<double> times_us) {
  const auto middle = times_us.begin() + static_cast<std::ptrdiff_t>(times_us.size() / 2);
  std::nth_element(times_us.begin(), middle, times_us.end());
  return {*middle, *std::min_element(times_us.begin(), times_us.end())};
}

/// Number of repeats: at least `least`, then until `budget_ms` are spent or `most` is reached.
struct RepeatOptions {
  int least = 3;
  int most = 200;
  double budget_ms = 20;
};

/// Repeats the works in turn (a, b, a, b, ...), so that a temporary slowdown of the machine affects
/// all of them. Returns the times of each, us, without those in which another thread had the core.
/// The first round is not measured.
inline std::vector<std::vector<double>> TimeInTurn(const std::vector<std::function<void()>>& works,
                                                   const RepeatOptions& options = {}) {
  std::vector<std::vector<double>> times(works.size());
  for (const std::function<void()>& work : works) work();
  const TimingClock::time_point start = TimingClock::now();
  for (int round = 0; round < options.most; ++round) {
    if (round >= options.least && MillisecondsSince(start) > options.budget_ms) break;
    for (std::size_t i = 0; i < works.size(); ++i) {
      // Reading the thread's clock costs a system call, so it is read outside the measured time.
      const double ran = ThreadMilliseconds();
      const TimingClock::time_point began = TimingClock::now();
      works[i]();
      const double passed = MillisecondsSince(began);
      times[i].push_back(1000 * std::min(passed, ThreadMilliseconds() - ran));
    }
  }
  return times;
}

inline Timing Time(const std::function<void()>& work, const RepeatOptions& options = {}) {
  return Summary(TimeInTurn({work}, options)[0]);
}

}  // namespace hpdm
