#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace hpdm {

/// How `hpdm` is started on a bad input, and what it may use.
struct BoundedRun {
  std::vector<std::string> words;  ///< After the program's name.
  std::filesystem::path folder;    ///< To run in.
  /// Variables beside the test's own; without a value one is unset.
  std::vector<std::pair<std::string, std::optional<std::string>>> environment = {};
  std::string out = {};          ///< Where standard output goes; empty: it is collected.
  bool as_nobody_else = false;   ///< Without root's right to write what is read-only.
  std::size_t memory = 1 << 30;  ///< Bytes of address space.
  int cpu_seconds = 10;
};

struct BoundedOutcome {
  int exit_code = -1;  ///< Or -1.
  int signal = 0;      ///< That ended it: 9 is also what the end of its time gives.
  std::string out, err;
  double cpu_s = 0;
};

/// Runs the program to its end, or to the end of what it may use: its address space and processor
/// time by setrlimit, and six times the latter on the clock (a program that waits uses none). Under
/// sanitizers, which reserve terabytes, the address space is not limited.
BoundedOutcome RunBounded(const BoundedRun& run);

}  // namespace hpdm
