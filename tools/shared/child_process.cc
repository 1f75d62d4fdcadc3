#include "tools/shared/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "engine/base/error.h"

namespace hpdm {
namespace {

int WaitFor(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

/// What becomes standard input, output and error; -1: as here.
using Files = std::array<int, 3>;

/// The new process until it is the program. It ends with this one however that ends, by SIGKILL
/// too, and obeys signals that are blocked here. Calls nothing but the system.
[[noreturn]] void Become(char* const* argv, const Files& files, bool own_group, pid_t parent,
                         int report_pipe) {
  if (own_group) setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(127);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  for (int i = 0; i < 3; ++i) {
    const int file = files[static_cast<std::size_t>(i)];
    if (file == i) fcntl(file, F_SETFD, 0);
    if (file >= 0 && file != i) dup2(file, i);
  }
  execvp(argv[0], argv);
  const int error = errno;
  [[maybe_unused]] const ssize_t written = write(report_pipe, &error, sizeof error);
  _exit(127);
}

/// Starts the program; with `own_group` it leads a group of all that it starts.
pid_t Spawn(const std::vector<std::string>& words, const Files& files, bool own_group) {
  std::vector<std::string> kept = words;
  std::vector<char*> argv;
  argv.reserve(kept.size() + 1);
  for (std::string& word : kept) argv.push_back(word.data());
  argv.push_back(nullptr);
  // Closes when the program has been started, or tells why it cannot.
  std::array<int, 2> report_pipe{-1, -1};
  if (pipe2(report_pipe.data(), O_CLOEXEC) != 0) {
    throw MachineError(words[0] + ": " + std::strerror(errno));
  }
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child == 0) Become(argv.data(), files, own_group, parent, report_pipe[1]);
  int error = child < 0 ? errno : 0;
  close(report_pipe[1]);
  while (child > 0 && read(report_pipe[0], &error, sizeof error) < 0 && errno == EINTR) {
  }
  close(report_pipe[0]);
  if (error != 0) {
    if (child > 0) WaitFor(child);
    throw MachineError(words[0] + ": " + std::strerror(error));
  }
  return child;
}

}  // namespace

int RunChild(const std::vector<std::string>& words, bool quiet) {
  const int nowhere = quiet ? open("/dev/null", O_WRONLY | O_CLOEXEC) : -1;
  const auto tidy = [nowhere] {
    if (nowhere >= 0) close(nowhere);
  };
  pid_t child = 0;
  try {
    child = Spawn(words, {-1, nowhere, nowhere}, false);
  } catch (...) {
    tidy();
    throw;
  }
  tidy();
  const int status = WaitFor(child);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

ChildProcess::ChildProcess(const std::vector<std::string>& words) {
  std::array<int, 2> out{-1, -1}, err{-1, -1};
  const int in = open("/dev/null", O_RDONLY | O_CLOEXEC);
  const auto tidy = [&] {
    for (const int descriptor : {in, out[1], err[1]}) {
      if (descriptor >= 0) close(descriptor);
    }
  };
  try {
    if (in < 0 || pipe2(out.data(), O_CLOEXEC) != 0 || pipe2(err.data(), O_CLOEXEC) != 0) {
      throw MachineError(words[0] + ": " + std::strerror(errno));
    }
    child_ = Spawn(words, {in, out[1], err[1]}, true);
  } catch (...) {
    tidy();
    for (const int descriptor : {out[0], err[0]}) {
      if (descriptor >= 0) close(descriptor);
    }
    throw;
  }
  tidy();
  out_.descriptor = out[0];
  err_.descriptor = err[0];
  for (const int descriptor : {out_.descriptor, err_.descriptor}) {
    fcntl(descriptor, F_SETFL, O_NONBLOCK);
  }
}

ChildProcess::~ChildProcess() {
  out_.Close();
  err_.Close();
  Kill();
}

void ChildProcess::Poll(const std::vector<ChildProcess*>& children, int timeout_ms) {
  std::vector<pollfd> waiting;
  std::vector<Pipe*> pipes;
  for (ChildProcess* child : children) {
    for (Pipe* pipe : {&child->out_, &child->err_}) {
      if (pipe->descriptor < 0) continue;
      waiting.push_back({pipe->descriptor, POLLIN, 0});
      pipes.push_back(pipe);
    }
  }
  if (poll(waiting.data(), waiting.size(), timeout_ms) <= 0) return;
  for (std::size_t i = 0; i < waiting.size(); ++i) {
    if (waiting[i].revents != 0) pipes[i]->Take();
  }
}

std::optional<int> ChildProcess::Ended() {
  int status = 0;
  if (!silent() || waitpid(child_, &status, WNOHANG) != child_) return std::nullopt;
  child_ = -1;
  return status;
}

void ChildProcess::Kill() {
  if (child_ < 0) return;
  kill(-child_, SIGKILL);  // its group
  WaitFor(child_);
  child_ = -1;
}

void ChildProcess::Pipe::Take() {
  std::array<char, 65536> bytes;
  for (;;) {
    const ssize_t count = read(descriptor, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno == EAGAIN) return;
    if (count <= 0) return Close();
    const std::size_t space = kMaxOutput - text.size();
    const auto size = static_cast<std::size_t>(count);
    text.append(bytes.data(), std::min(size, space));
    too_much |= size > space;
  }
}

void ChildProcess::Pipe::Close() {
  if (descriptor >= 0) close(descriptor);
  descriptor = -1;
}

}  // namespace hpdm
