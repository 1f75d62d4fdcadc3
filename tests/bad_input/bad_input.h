#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/bad_input/bounded_program.h"
#include "tests/support/scratch_folder.h"

/// Tables of bad inputs (tests/bad_input/*.csv, README.md there) and what compares the program with
/// them.
namespace hpdm {

/// A row: the input's name, what becomes of it and with which words.
struct ExpectedOutcome {
  std::string input, outcome, what;
  int line = 0;
};

/// The rows of tests/bad_input/NAME.csv. Throws std::runtime_error where it is no such table.
std::vector<ExpectedOutcome> ReadOutcomes(const std::string& name);

/// Whether the parts of `what`, which " ... " separates, stand in the text in this order.
bool Says(const std::string& text, const std::string& what);

/// The inputs of one table.
class BadInputs {
 public:
  using Make = std::function<void(const std::filesystem::path& folder)>;

  /// `table`: name of the .csv file; `prepare` puts what all inputs need into a folder, once.
  explicit BadInputs(std::string table, const Make& prepare = {});

  /// What all inputs need: ../common/ for those that run in a folder of their own.
  std::filesystem::path common() const { return scratch_.path() / "common"; }

  /// An input with the program's run on it, in an empty folder that `make` fills first.
  void Add(const std::string& name, BoundedRun run, const Make& make = {});
  void Add(const std::string& name, std::vector<std::string> words, const Make& make = {}) {
    Add(name, BoundedRun{.words = std::move(words), .folder = {}}, make);
  }

  /// Runs all inputs; a failure for each that differs from its row, for a row without an input and
  /// for an input without a row.
  void Compare();

 private:
  struct Input {
    BoundedRun run;
    Make make;
  };
  void CompareOne(const ExpectedOutcome& row, const Input& input);

  std::string table_;
  ScratchFolder scratch_;
  std::map<std::string, Input> inputs_;
  double cpu_s_ = 0;
};

/// Writes a file of the folder.
BadInputs::Make WithFile(std::string name, std::string bytes);
/// What both do.
BadInputs::Make Both(BadInputs::Make a, BadInputs::Make b);

}  // namespace hpdm
