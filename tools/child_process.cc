#include "tools/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "engine/error.h"

extern char** environ;

namespace hpdm {
namespace {

/// Starts the program; `actions` say what becomes of its files.
pid_t Spawn(const std::vector<std::string>& words, const posix_spawn_file_actions_t& actions) {
  std::vector<std::string> kept = words;
  std::vector<char*> argv;
  for (std::string& word : kept) argv.push_back(word.data());
  argv.push_back(nullptr);
  // A signal that ends this program must reach the child too, whatever is blocked here.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  pid_t child = 0;
  const int error = posix_spawnp(&child, argv[0], &actions, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  if (error != 0) throw MachineError(words[0] + ": " + std::strerror(error));
  return child;
}

int WaitFor(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

}  // namespace

int RunChild(const std::vector<std::string>& words, bool quiet) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  for (const int output : {1, 2}) {
    if (quiet) posix_spawn_file_actions_addopen(&actions, output, "/dev/null", O_WRONLY, 0);
  }
  pid_t child = 0;
  try {
    child = Spawn(words, actions);
  } catch (...) {
    posix_spawn_file_actions_destroy(&actions);
    throw;
  }
  posix_spawn_file_actions_destroy(&actions);
  const int status = WaitFor(child);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

ChildProcess::ChildProcess(const std::vector<std::string>& words) {
  std::array<int, 2> out{-1, -1}, err{-1, -1};
  if (pipe2(out.data(), O_CLOEXEC) != 0 || pipe2(err.data(), O_CLOEXEC) != 0) {
    const int error = errno;
    for (const int descriptor : {out[0], out[1]}) {
      if (descriptor >= 0) close(descriptor);
    }
    throw MachineError(words[0] + ": " + std::strerror(error));
  }
  out_.descriptor = out[0];
  err_.descriptor = err[0];
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, out[1], 1);
  posix_spawn_file_actions_adddup2(&actions, err[1], 2);
  const auto tidy = [&] {
    posix_spawn_file_actions_destroy(&actions);
    close(out[1]);
    close(err[1]);
  };
  try {
    child_ = Spawn(words, actions);
  } catch (...) {
    tidy();
    out_.Close();
    err_.Close();
    throw;
  }
  tidy();
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
  kill(child_, SIGKILL);
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
    const std::size_t space = kMostOutput - text.size();
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
