#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace hpdm {

/// A run of `hpdm` on a bad input, with its limits.
struct BoundedRun {
  std::vector<std::string> words;  ///< After the program's name.
  std::filesystem::path folder;    ///< The working folder.
  /// Changes to the test's environment; a variable without a value is unset.
  std::vector<std::pair<std::string, std::optional<std::string>>> environment = {};
  std::string out = {};          ///< File for standard output; empty: collected.
  bool as_nobody_else = false;   ///< Drop root's right to write read-only files.
  std::size_t memory = 1 << 30;  ///< Bytes of address space.
  int cpu_seconds = 10;
};

struct BoundedOutcome {
  int exit_code = -1;  ///< -1 after a signal.
  int signal = 0;      ///< The signal that ended it; 9 also at its time limit.
  std::string out, err;
  double cpu_s = 0;
};

/// Runs the program to its end or to its limits. setrlimit bounds the address space and processor
/// time; six times the latter bounds the wall time, because waiting uses no processor time. Under
/// sanitizers, which reserve terabytes, the address space is not limited.
BoundedOutcome RunBounded(const BoundedRun& run);

}  // namespace hpdm
