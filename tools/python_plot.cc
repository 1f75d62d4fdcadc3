#include "tools/python_plot.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>

#include <cstring>

extern char** environ;

namespace hpdm {

std::string RunPlotScript(const std::string& script, const std::vector<std::string>& arguments) {
  // Debian's own interpreter: another one on the path would lack Debian's matplotlib.
  std::vector<std::string> words = {"/usr/bin/python3", "-c", script};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  posix_spawn_file_actions_t quiet;
  posix_spawn_file_actions_init(&quiet);
  posix_spawn_file_actions_addopen(&quiet, 1, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&quiet, 2, "/dev/null", O_WRONLY, 0);
  pid_t child = 0;
  const int error = posix_spawn(&child, argv[0], &quiet, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&quiet);
  if (error != 0) {
    return std::string("no plot: /usr/bin/python3: ") + std::strerror(error) +
           "; install python3-matplotlib";
  }
  int status = 0;
  waitpid(child, &status, 0);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return "";
  return "no plot: the plot script failed; install python3-matplotlib, or free space";
}

}  // namespace hpdm
