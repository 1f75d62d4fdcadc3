#include "tools/run/set_up_interrupt.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <optional>
#include <thread>

namespace hpdm {
namespace {

void EndedBy(int signal) {
  const StopSignals signals;
  const SetUpInterrupt interrupt(signals);
  kill(getpid(), signal);
  std::this_thread::sleep_for(std::chrono::seconds(20));  // a long computation
}

TEST(SetUpInterrupt, EndsTheProgramWhileTheMainThreadComputes) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(EndedBy(SIGINT), testing::ExitedWithCode(SetUpInterrupt::kExitCode),
              "no session was begun");
  EXPECT_EXIT(EndedBy(SIGTERM), testing::ExitedWithCode(143), "no session was begun");
}

TEST(SetUpInterrupt, LeavesALaterSignalToTheSession) {
  const StopSignals signals;
  std::optional<SetUpInterrupt> interrupt(signals);
  interrupt.reset();
  kill(getpid(), SIGINT);
  EXPECT_EQ(signals.SignalWithin(0), SIGINT);
}

}  // namespace
}  // namespace hpdm
