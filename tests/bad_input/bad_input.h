#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/bad_input/bounded_program.h"
#include "tests/support/scratch_folder.h"

/// Compares the program with the tables of bad inputs (tests/bad_input/*.csv, described in the
/// README.md there).
namespace hpdm {

/// A row: the input's name, its outcome and parts of the message.
struct ExpectedOutcome {
  std::string input, outcome, what;
  int line = 0;
};

/// Reads the rows of tests/bad_input/NAME.csv. Throws std::runtime_error if it is not such a table.
std::vector<ExpectedOutcome> ReadOutcomes(const std::string& name);

/// True if the text contains the parts of `what`, which " ... " separates, in this order.
bool Says(const std::string& text, const std::string& what);

/// The inputs of one table.
class BadInputs {
 public:
  using Make = std::function<void(const std::filesystem::path& folder)>;

  /// `table`: name of the .csv file. `prepare` fills the folder `common` once.
  explicit BadInputs(std::string table, const Make& prepare = {});

  /// A folder with files for all inputs, ../common/ from the folder of an input.
  std::filesystem::path common() const { return scratch_.path() / "common"; }

  /// Adds an input: a run of the program in an empty folder that `make` fills first.
  void Add(const std::string& name, BoundedRun run, const Make& make = {});
  void Add(const std::string& name, std::vector<std::string> words, const Make& make = {}) {
    Add(name, BoundedRun{.words = std::move(words), .folder = {}}, make);
  }

  /// Runs all inputs. Fails for each that differs from its row, for a row without an input and
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

/// Random bytes, the same at every call.
std::string Garbage(std::size_t bytes);
/// Returns a function that writes a file into the folder.
BadInputs::Make WithFile(std::string name, std::string bytes);
/// Returns a function that does both.
BadInputs::Make Both(BadInputs::Make a, BadInputs::Make b);

}  // namespace hpdm
