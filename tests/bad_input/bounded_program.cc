#include "tests/bad_input/bounded_program.h"

#include <fcntl.h>
#include <linux/securebits.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <stdexcept>

#include "tests/support/program.h"

namespace hpdm {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

void Limit(int resource, rlim_t most) {
  const rlimit limit{most, most};
  if (setrlimit(static_cast<__rlimit_resource>(resource), &limit) != 0) _exit(125);
}

// Run this way, a superuser's program can use its files but lacks root's rights.
bool DropRights() {
  return geteuid() != 0 || prctl(PR_SET_SECUREBITS, SECBIT_NOROOT | SECBIT_NOROOT_LOCKED) == 0;
}

[[noreturn]] void Become(const BoundedRun& run, const std::string& out, const std::string& err) {
  const auto redirect = [](const std::string& path, int flags, int to) {
    const int descriptor = open(path.c_str(), flags, 0600);
    if (descriptor < 0 || dup2(descriptor, to) < 0) _exit(125);
  };
  redirect("/dev/null", O_RDONLY, STDIN_FILENO);
  redirect(out, O_WRONLY | O_CREAT | O_TRUNC, STDOUT_FILENO);
  redirect(err, O_WRONLY | O_CREAT | O_TRUNC, STDERR_FILENO);
  if (chdir(run.folder.c_str()) != 0) _exit(125);
  for (const auto& [name, value] : run.environment) {
    value ? setenv(name.c_str(), value->c_str(), 1) : unsetenv(name.c_str());
  }
  Limit(RLIMIT_CORE, 0);
  Limit(RLIMIT_CPU, static_cast<rlim_t>(run.cpu_seconds * (kSanitized ? 10 : 1)));
  if (!kSanitized) Limit(RLIMIT_AS, run.memory);
  if (run.as_nobody_else && !DropRights()) _exit(125);
  std::vector<char*> words = {const_cast<char*>(kHpdmProgram.c_str())};
  for (const std::string& word : run.words) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  execv(words[0], words.data());
  _exit(127);
}

}  // namespace

BoundedOutcome RunBounded(const BoundedRun& run) {
  const std::string err = run.folder.string() + ".stderr", collected = run.folder.string() + ".out";
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no process");
  if (child == 0) Become(run, run.out.empty() ? collected : run.out, err);
  const int process = static_cast<int>(syscall(SYS_pidfd_open, child, 0));
  pollfd ended{process, POLLIN, 0};
  const int patience_ms = 6000 * run.cpu_seconds * (kSanitized ? 10 : 1);
  if (process < 0 || poll(&ended, 1, patience_ms) != 1) kill(child, SIGKILL);
  if (process >= 0) close(process);
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  BoundedOutcome outcome;
  if (WIFEXITED(status)) outcome.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) outcome.signal = WTERMSIG(status);
  outcome.cpu_s = static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
                  1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
  if (run.out.empty()) outcome.out = ReadFile(collected);
  outcome.err = ReadFile(err);
  unlink(err.c_str());
  unlink(collected.c_str());
  return outcome;
}

}  // namespace hpdm
