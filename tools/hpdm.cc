#include <fcntl.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <iostream>
#include <new>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "tools/command_line.h"
#include "tools/commands.h"

namespace {

/// Opens /dev/null for each closed standard stream. Otherwise the first file that the program opens
/// would take the stream's number and receive the printed text.
void OpenStandardStreams() {
  for (int stream = 0; stream <= 2; ++stream) {
    if (fcntl(stream, F_GETFD) < 0 && open("/dev/null", O_RDWR) != stream) std::abort();
  }
}

/// Refuses empty arguments: an unset variable of a script must not select a default.
void RefuseEmptyArguments(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (!word.empty() && !(word.starts_with("--") && word.ends_with('='))) continue;
    const std::string before = i > 1 ? std::string(" (after ") + argv[i - 1] + ")" : "";
    throw hpdm::InputError("argument " + std::to_string(i) + before +
                           ": is empty; give a value or leave the option out");
  }
}

int Fail(const char* message, const char* remedy, int exit_code) {
  std::fprintf(stderr, "hpdm: %s\n", hpdm::OneLine(std::string(message) + remedy).c_str());
  return exit_code;
}

/// Flushes standard output and returns the exit code. A full disk may report its failure only now.
int AfterOutput(int exit_code) {
  if (exit_code >= 2) return exit_code;  // a failure has been reported
  errno = 0;
  std::cout.flush();
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && std::cout.good()) return exit_code;
  const std::string reason = errno != 0 ? std::strerror(errno) : "a write failed";
  Fail(("standard output cannot be written (" + reason + ")").c_str(),
       "; free space, or redirect it elsewhere", 2);
  return 2;
}

void AddCommands(hpdm::Command app, const std::vector<std::string>& command_line) {
  hpdm::AddRunCommand(app, command_line);
  hpdm::AddReplayCommand(app);
  hpdm::AddReportCommand(app);
  hpdm::AddSpyCommand(app);
  hpdm::AddTeachCommand(app);
  hpdm::AddLogCommand(app);
  hpdm::AddCheckCommand(app);
  hpdm::AddInspectCommand(app);
  hpdm::AddSolveCommand(app);
  hpdm::AddChartCommand(app);
  hpdm::AddPlanCommand(app);
  hpdm::AddBenchCommand(app);
  hpdm::AddHapticsCommand(app);
  hpdm::AddStressCommand(app);
  hpdm::AddGenerateCommand(app);
}

int Hpdm(int argc, char** argv) {
  try {
    RefuseEmptyArguments(argc, argv);
    const std::vector<std::string> command_line(argv, argv + argc);
    return hpdm::RunCommandLine("hpdm",
                                "HPDM: a real-time engine for laparoscopic-surgery training",
                                HPDM_VERSION, {command_line.begin() + 1, command_line.end()},
                                [&](hpdm::Command app) { AddCommands(app, command_line); });
  } catch (const hpdm::InputError& error) {
    return Fail(error.what(), "", 2);
  } catch (const hpdm::MachineError& error) {
    return Fail(error.what(), "", 3);
  } catch (const std::bad_alloc&) {
    return Fail("out of memory; use fewer lattice cells or a coarser mesh", "", 3);
  } catch (const std::exception& error) {  // caught so that destructors run: a terminal is restored
    return Fail(error.what(), "; see hpdm --help", 3);
  }
}

}  // namespace

// Exit codes: 0 done; 1 a check failed; 2 bad input or usage (one line on stderr); 3 the machine
// lacks something that the command needs.
int main(int argc, char** argv) {
  OpenStandardStreams();
  return AfterOutput(Hpdm(argc, argv));
}
