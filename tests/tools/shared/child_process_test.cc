#include "tools/shared/child_process.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>

#include "engine/base/error.h"

namespace hpdm {
namespace {

TEST(ChildProcess, ReportsWhyAProgramCannotBeStarted) {
  for (const char* program : {"/no/such/program", "/dev/null"}) {
    EXPECT_THROW(RunChild({program}), MachineError);
    EXPECT_THROW(ChildProcess({program}), MachineError);
  }
  EXPECT_EQ(RunChild({"sh", "-c", "exit 7"}), 7);
  EXPECT_EQ(RunChild({"sh", "-c", "kill -9 $$"}), -1);
}

TEST(ChildProcess, CollectsWhatTheProgramWrites) {
  ChildProcess child({"sh", "-c", "cat; echo out; echo err >&2; exit 3"});
  while (!child.silent()) ChildProcess::Poll({&child}, 1000);
  std::optional<int> status;
  while (!status) status = child.Ended();
  EXPECT_EQ(WEXITSTATUS(*status), 3);
  EXPECT_EQ(child.out(), "out\n");
  EXPECT_EQ(child.err(), "err\n");
}

TEST(ChildProcess, EndsWithAProgramThatIsKilled) {
  std::array<int, 2> alive;  // open until all that have it are gone
  ASSERT_EQ(pipe(alive.data()), 0);
  const pid_t program = fork();
  if (program == 0) {
    const ChildProcess child({"sleep", "20"});
    kill(getpid(), SIGKILL);
  }
  close(alive[1]);
  waitpid(program, nullptr, 0);
  pollfd open{alive[0], POLLIN, 0};
  EXPECT_EQ(poll(&open, 1, 5000), 1) << "killed at once, but by another processor";
  close(alive[0]);
}

}  // namespace
}  // namespace hpdm
