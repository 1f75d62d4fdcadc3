#include "tests/bad_input/bad_input.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <random>
#include <sstream>
#include <stdexcept>

#include "tests/support/read_file.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

// The exit code of each outcome.
const std::map<std::string, int> kExitCodes = {
    {"accepted", 0}, {"repaired", 0}, {"faulty", 1}, {"refused", 2}, {"lacking", 3}};

// Returns the cells of a line of comma-separated values: RFC 4180, without line ends in cells.
std::vector<std::string> Cells(const std::string& line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') {
      const bool twice = quoted && i + 1 < line.size() && line[i + 1] == '"';
      if (twice) cells.back() += line[i++];
      quoted ^= !twice;
    } else if (line[i] == ',' && !quoted) {
      cells.emplace_back();
    } else {
      cells.back() += line[i];
    }
  }
  return cells;
}

// Adds everything in a folder: names, kinds and contents. (The standard's recursion fails at a link
// to itself.)
void AddEverything(const fs::path& folder, std::map<std::string, std::string>* all) {
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const fs::file_type type = fs::symlink_status(entry.path()).type();
    const bool file = type == fs::file_type::regular;
    (*all)[entry.path().string()] =
        file ? "file " + ReadFile(entry.path()) : "type " + std::to_string(static_cast<int>(type));
    if (type == fs::file_type::directory) AddEverything(entry.path(), all);
  }
}

std::map<std::string, std::string> Everything(const fs::path& folder) {
  std::map<std::string, std::string> all;
  AddEverything(folder, &all);
  return all;
}

// Returns the text without the lines in which hpdm run says what it prepares.
std::string WithoutProgress(const std::string& text) {
  std::istringstream lines(text);
  std::string rest;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("hpdm: preparing ")) rest += line + "\n";
  }
  return rest;
}

// True for a message to a person: whole lines without control characters.
bool IsText(const std::string& text) {
  return std::none_of(text.begin(), text.end(),
                      [](char c) {
                        const auto byte = static_cast<unsigned char>(c);
                        return (byte < 0x20 && c != '\n') || byte == 0x7f;
                      }) &&
         (text.empty() || text.back() == '\n');
}

}  // namespace

std::vector<ExpectedOutcome> ReadOutcomes(const std::string& name) {
  const std::string path = std::string(HPDM_SOURCE_DIR) + "/tests/bad_input/" + name + ".csv";
  std::ifstream file(path);
  std::vector<ExpectedOutcome> rows;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    const std::vector<std::string> cells = Cells(line);
    const bool header = number == 1;
    if (cells.size() != 3 || (header && line != "input,outcome,what") ||
        (!header && !kExitCodes.contains(cells[1]))) {
      throw std::runtime_error(path + ":" + std::to_string(number) +
                               ": is not a row of such a table");
    }
    if (!header) rows.push_back({cells[0], cells[1], cells[2], number});
  }
  if (rows.empty()) throw std::runtime_error(path + ": has no row");
  return rows;
}

bool Says(const std::string& text, const std::string& what) {
  static const std::string kGap = " ... ";
  std::size_t at = 0;
  for (std::size_t from = 0;;) {
    const std::size_t gap = what.find(kGap, from);
    const std::string part = what.substr(from, gap == std::string::npos ? gap : gap - from);
    at = text.find(part, at);
    if (at == std::string::npos) return false;
    if (gap == std::string::npos) return true;
    at += part.size();
    from = gap + kGap.size();
  }
}

BadInputs::BadInputs(std::string table, const Make& prepare) : table_(std::move(table)) {
  fs::create_directory(common());
  if (prepare) prepare(common());
}

void BadInputs::Add(const std::string& name, BoundedRun run, const Make& make) {
  if (!inputs_.emplace(name, Input{std::move(run), make}).second) {
    throw std::runtime_error("two inputs of the name " + name);
  }
}

void BadInputs::CompareOne(const ExpectedOutcome& row, const Input& input) {
  BoundedRun run = input.run;
  run.folder = scratch_ / "here";
  fs::create_directory(run.folder);
  if (input.make) input.make(run.folder);
  const auto before = Everything(scratch_.path());
  const BoundedOutcome outcome = RunBounded(run);
  const auto after = Everything(scratch_.path());
  fs::remove_all(run.folder);
  cpu_s_ += outcome.cpu_s;

  std::string words;
  for (const std::string& word : run.words) words += " " + word;
  SCOPED_TRACE(table_ + ".csv:" + std::to_string(row.line) + ": " + row.input + "\nhpdm" +
               words.substr(0, 300) + "\n" + outcome.out.substr(0, 1000) +
               outcome.err.substr(0, 1000));
  EXPECT_EQ(outcome.signal, 0);
  EXPECT_EQ(outcome.exit_code, kExitCodes.at(row.outcome));
  EXPECT_TRUE(IsText(outcome.err) && IsText(outcome.out));
  if (row.outcome == "refused" || row.outcome == "lacking") {
    const std::string err = WithoutProgress(outcome.err);
    EXPECT_EQ(std::count(err.begin(), err.end(), '\n'), 1);
    EXPECT_TRUE(err.starts_with("hpdm: "));
    EXPECT_TRUE(Says(outcome.err, row.what)) << "no " << row.what;
    EXPECT_EQ(outcome.out, "");
    EXPECT_TRUE(before == after) << "something was written or lost";
  } else {
    EXPECT_TRUE(Says(outcome.out + outcome.err, row.what)) << "no " << row.what;
    for (const auto& [path, content] : before) {
      const auto now = after.find(path);
      EXPECT_TRUE(now != after.end() && now->second == content) << path << " was changed";
    }
  }
}

void BadInputs::Compare() {
  std::map<std::string, Input> left = inputs_;
  for (const ExpectedOutcome& row : ReadOutcomes(table_)) {
    const auto input = left.find(row.input);
    if (input == left.end()) {
      ADD_FAILURE() << table_ << ".csv:" << row.line << ": no such input: " << row.input;
      continue;
    }
    CompareOne(row, input->second);
    left.erase(input);
  }
  for (const auto& [name, input] : left) {
    ADD_FAILURE() << table_ << ".csv has no row for the input " << name;
  }
  std::printf("%s: %zu inputs, %.1f s of processor time\n", table_.c_str(), inputs_.size(), cpu_s_);
}

std::string Garbage(std::size_t bytes) {
  std::mt19937 random(7);
  std::string text(bytes, '\0');
  for (char& c : text) c = static_cast<char>(random());
  return text;
}

BadInputs::Make WithFile(std::string name, std::string bytes) {
  return [name = std::move(name), bytes = std::move(bytes)](const fs::path& folder) {
    std::ofstream(folder / name, std::ios::binary) << bytes;
  };
}

BadInputs::Make Both(BadInputs::Make a, BadInputs::Make b) {
  return [a = std::move(a), b = std::move(b)](const fs::path& folder) {
    a(folder);
    b(folder);
  };
}

}  // namespace hpdm
