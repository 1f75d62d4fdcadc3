#include "engine/threads/realtime.h"

#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <thread>

#include "engine/threads/session_clock.h"

namespace hpdm {
namespace {

// Makes each request on a thread of its own, so that no test inherits another's scheduler.
RealtimeReport RequestOnAThread(const RealtimeOptions& options, int* policy) {
  RealtimeReport report;
  std::jthread([&] {
    report = RequestRealtime(options);
    sched_param parameters;
    pthread_getschedparam(pthread_self(), policy, &parameters);
  }).join();
  return report;
}

TEST(Realtime, NothingAskedForIsCompleteAndChangesNothing) {
  int policy = -1;
  const RealtimeReport report = RequestOnAThread({}, &policy);
  EXPECT_TRUE(report.Complete());
  EXPECT_EQ(policy, SCHED_OTHER);
  EXPECT_EQ(report.fifo_priority, 0);
  EXPECT_EQ(report.core, -1);
}

TEST(Realtime, TheReportAgreesWithTheScheduler) {
  RealtimeOptions options;
  options.fifo_priority = 5;
  int policy = -1;
  const RealtimeReport report = RequestOnAThread(options, &policy);
  EXPECT_TRUE(report.fifo.asked);
  EXPECT_EQ(report.fifo.granted, policy == SCHED_FIFO);
  EXPECT_EQ(report.fifo.granted, report.fifo.why_not.empty());
  EXPECT_EQ(report.Complete(), report.fifo.granted);
}

TEST(Realtime, AnImpossiblePriorityIsRefusedWithItsReason) {
  RealtimeOptions options;
  options.fifo_priority = 1000;
  int policy = -1;
  const RealtimeReport report = RequestOnAThread(options, &policy);
  EXPECT_FALSE(report.fifo.granted);
  EXPECT_FALSE(report.Complete());
  EXPECT_EQ(policy, SCHED_OTHER);
  EXPECT_NE(report.fifo.why_not.find("1 to 99"), std::string::npos) << report.fifo.why_not;
  EXPECT_NE(report.Lines()[0].find("refused"), std::string::npos);
  EXPECT_EQ(report.FirstRefusal(), report.Lines()[0]);
}

TEST(Realtime, FirstRefusalSkipsRequestsThatWereNotMade) {
  RealtimeReport report;
  report.locked_memory = {.asked = true, .granted = false, .why_not = "the limit is 8 kB"};
  EXPECT_FALSE(report.Complete());
  EXPECT_EQ(report.FirstRefusal(), "locked memory: refused (the limit is 8 kB)");
}

TEST(Realtime, DeepIdleIsRefusedOrGrantedOnceForAllAndNeverSilently) {
  RealtimeOptions options;
  options.keep_awake = true;
  int policy = -1;
  const RealtimeReport first = RequestOnAThread(options, &policy);
  const RealtimeReport second = RequestOnAThread(options, &policy);
  EXPECT_EQ(first.kept_awake.asked, access("/dev/cpu_dma_latency", F_OK) == 0);
  EXPECT_EQ(first.kept_awake.granted, first.kept_awake.why_not.empty());
  EXPECT_EQ(second.kept_awake.granted, first.kept_awake.granted);
  EXPECT_EQ(second.kept_awake.why_not, first.kept_awake.why_not);
}

TEST(Realtime, TheStackIsTouchedWithoutHarm) {
  RealtimeOptions options;
  options.prefault_stack = true;
  int policy = -1;
  EXPECT_TRUE(RequestOnAThread(options, &policy).prefaulted_stack.granted);
}

TEST(Realtime, PinningIsLeftOutOnTwoCoresAndGrantedOnMore) {
  cpu_set_t allowed;
  ASSERT_EQ(sched_getaffinity(getpid(), sizeof allowed, &allowed), 0);
  RealtimeOptions options;
  options.core_from_last = 0;
  int policy = -1;
  const RealtimeReport report = RequestOnAThread(options, &policy);
  EXPECT_EQ(report.pinned.granted, CPU_COUNT(&allowed) > 2);
  EXPECT_EQ(report.core >= 0, report.pinned.granted);
  EXPECT_TRUE(report.Complete()) << "too few cores is no refusal";
}

// Runs in a child process: locked memory stays locked, and a sanitizer's shadow memory cannot be.
TEST(Realtime, MemoryIsNotLockedUnderAFiniteLimitWithoutTheRight) {
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const rlimit limit = {64 * 1024, 64 * 1024};
    if (setrlimit(RLIMIT_MEMLOCK, &limit) != 0 || (geteuid() == 0 && setuid(65534) != 0)) _exit(77);
    RealtimeOptions options;
    options.lock_memory = true;
    const RealtimeReport first = RequestRealtime(options);
    const RealtimeReport second = RequestRealtime(options);
    // NOLINTNEXTLINE(cppcoreguidelines-no-malloc): would fail under MCL_FUTURE
    void* memory = std::malloc(10'000'000);
    _exit(!first.locked_memory.granted && !first.locked_memory.why_not.empty() &&
                  second.locked_memory.why_not == first.locked_memory.why_not && memory != nullptr
              ? 0
              : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 77) GTEST_SKIP() << "rights cannot be dropped";
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
}

TEST(SessionClock, NeverWakesEarlyAndKeepsAnAbsoluteSchedule) {
  const SessionClock clock;
  Nanoseconds last = 0;
  for (int i = 1; i <= 20; ++i) {
    clock.SleepUntil(i * 1'000'000);
    const Nanoseconds now = clock.Now();
    EXPECT_GE(now, i * 1'000'000);
    EXPECT_GE(now, last);
    last = now;
  }
  clock.SleepUntil(-5);  // long past: returns at once
}

TEST(SessionClock, CopiesShareTheStart) {
  const SessionClock clock;
  const SessionClock copy = clock;
  const Nanoseconds a = clock.Now();
  const Nanoseconds b = copy.Now();
  const Nanoseconds c = clock.Now();
  EXPECT_LE(a, b);
  EXPECT_LE(b, c);
}

TEST(SessionClock, SleepingCostsNoProcessorTime) {
  const SessionClock clock;
  const Nanoseconds cpu = ThreadCpuTime();
  clock.SleepUntil(clock.Now() + 20'000'000);
  // A sleep and its wake-up cost some 10 us; 10 ms leaves room for a sanitizer on a busy machine.
  EXPECT_LT(ThreadCpuTime() - cpu, 10'000'000);
}

}  // namespace
}  // namespace hpdm
