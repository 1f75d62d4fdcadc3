#include "tools/shared/child_process.h"

#include <fcntl.h>
#include <glib.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "engine/base/error.h"

namespace hpdm {
namespace {

struct ChildSetUp {
  bool own_group;  ///< The program leads a process group of everything that it starts.
  pid_t parent = getpid();
};

/// Runs in the new process before the program; makes only async-signal-safe calls. The program ends
/// with its parent, however the parent ends. Signals blocked in the parent are unblocked.
void SetUpChild(gpointer data) {
  const auto& set_up = *static_cast<const ChildSetUp*>(data);
  if (set_up.own_group) setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != set_up.parent) _exit(127);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
}

constexpr auto kSpawnFlags =
    static_cast<GSpawnFlags>(G_SPAWN_SEARCH_PATH | G_SPAWN_LEAVE_DESCRIPTORS_OPEN);

/// Returns the words as GLib takes them; it does not change them.
std::vector<char*> Arguments(const std::vector<std::string>& words) {
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  return argv;
}

/// Throws MachineError if there is an error, and frees it.
void ThrowIf(GError* error) {
  if (error == nullptr) return;
  const std::string message = error->message;
  g_error_free(error);
  throw MachineError(message);
}

}  // namespace

int RunChild(const std::vector<std::string>& words, bool quiet) {
  ChildSetUp set_up{.own_group = false};
  int flags = kSpawnFlags | G_SPAWN_CHILD_INHERITS_STDIN;
  if (quiet) flags |= G_SPAWN_STDOUT_TO_DEV_NULL | G_SPAWN_STDERR_TO_DEV_NULL;
  int status = 0;
  GError* error = nullptr;
  g_spawn_sync(nullptr, Arguments(words).data(), nullptr, static_cast<GSpawnFlags>(flags),
               SetUpChild, &set_up, nullptr, nullptr, &status, &error);
  ThrowIf(error);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

ChildProcess::ChildProcess(const std::vector<std::string>& words) {
  ChildSetUp set_up{.own_group = true};
  constexpr auto kFlags =
      static_cast<GSpawnFlags>(kSpawnFlags | G_SPAWN_DO_NOT_REAP_CHILD | G_SPAWN_CLOEXEC_PIPES);
  GError* error = nullptr;
  g_spawn_async_with_pipes(nullptr, Arguments(words).data(), nullptr, kFlags, SetUpChild, &set_up,
                           &child_, nullptr, &out_.descriptor, &err_.descriptor, &error);
  ThrowIf(error);
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
  kill(-child_, SIGKILL);  // the whole group
  while (waitpid(child_, nullptr, 0) < 0 && errno == EINTR) {
  }
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
