// Tries the scripted errors of tests/support/removal_errors.h and further_removal_errors.h in anatomies and
// patients:
//
//   ninja -C build try_errors
//   build/tests/try_errors                            # three anatomies, five seeds each
//   build/tests/try_errors low_union 3                # one
//
// Prints a row for each error: in how many of them it was found, and how many near misses were flagged.
// Exit status 1 unless all are found and no near miss is flagged; 2 on wrong input.

#include <chrono>
#include <cstdio>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/anatomy_removal.h"
#include "tests/support/further_removal_errors.h"
#include "tests/support/removal_errors.h"
#include "tests/support/scratch_folder.h"

namespace {

using namespace hpdm;

std::vector<RemovalError> AllErrors() {
  std::vector<RemovalError> errors = RemovalErrors();
  for (const RemovalError& error : FurtherRemovalErrors()) errors.push_back(error);
  return errors;
}

struct Row {
  int tried = 0, found = 0, false_alarms = 0;
};

void TryIn(const std::string& variant, int seed, std::vector<Row>* rows, bool* clean) {
  const ScratchFolder folder;
  const auto started = std::chrono::steady_clock::now();
  const auto model = std::make_shared<const SessionModel>(
      RemovalOf(VariantNamed(variant), static_cast<std::uint64_t>(seed), folder.path().string()));
  RemovalErrorTrials trials(model);
  std::printf("%s %d: %zu steps done", variant.c_str(), seed, trials.done());
  for (const std::string& error : trials.Errors()) std::printf(", %s", error.c_str());
  *clean = *clean && trials.Errors().empty() && trials.done() == 5;
  std::printf("\n");
  const std::vector<RemovalError> errors = AllErrors();
  rows->resize(errors.size());
  for (std::size_t e = 0; e < errors.size(); ++e) {
    const ErrorTrial trial = trials.Try(errors[e]);
    ++(*rows)[e].tried;
    (*rows)[e].found += trial.done && trial.found;
    (*rows)[e].false_alarms += trial.false_alarm;
    if (trial.done && trial.found && !trial.false_alarm && trial.unexpected.empty()) continue;
    std::printf("  %s: %s%s%s", errors[e].name.c_str(), trial.done ? "" : "not done, ",
                trial.found ? "found" : "not found", trial.false_alarm ? ", false alarm" : "");
    if (!trial.faults.empty()) std::printf(" (%s)", trial.faults.c_str());
    for (const std::string& other : trial.unexpected) std::printf(", also %s", other.c_str());
    std::printf("\n");
    std::fflush(stdout);
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - started;
  std::printf("  %.0f s\n", took.count());
  std::fflush(stdout);
}

int TryAll(int argc, char** argv) {
  std::vector<Row> rows;
  bool all = true;
  if (argc == 3) {
    TryIn(argv[1], std::stoi(argv[2]), &rows, &all);
  } else {
    for (const char* variant : {"short_duct", "artery_in_front", "low_union"}) {
      for (int seed = 0; seed < 5; ++seed) TryIn(variant, seed, &rows, &all);
    }
  }
  std::printf("\n| error and near miss | found | near misses flagged |\n|---|---|---|\n");
  const std::vector<RemovalError> errors = AllErrors();
  for (std::size_t e = 0; e < errors.size(); ++e) {
    std::printf("| %s | %d of %d | %d |\n", errors[e].name.c_str(), rows[e].found, rows[e].tried,
                rows[e].false_alarms);
    all = all && rows[e].found == rows[e].tried && rows[e].false_alarms == 0;
  }
  return all ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 1 && argc != 3) {
    std::fprintf(stderr, "usage: try_errors [ANATOMY SEED]\n");
    return 2;
  }
  try {
    return TryAll(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "try_errors: %s\n", error.what());
    return 2;
  }
}
