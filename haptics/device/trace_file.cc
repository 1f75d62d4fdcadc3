#include "haptics/device/trace_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <optional>
#include <string_view>

#include "engine/base/error.h"
#include "engine/base/quoted_token.h"

namespace hpdm {
namespace {

constexpr double kMaxTraceSeconds = 86400;  // a day; more is a time in ms or a wrong column
constexpr double kMaxTraceValue = 1e4;      // far beyond any pose, in m, mm or rad

// A column and its index among a row's values, or kTime.
constexpr int kTime = -1;
struct Column {
  std::string_view name;
  int value;
};
constexpr Column kColumns[] = {{"t", kTime},
                               {"px", 0},
                               {"py", 1},
                               {"pz", 2},
                               {"pitch", kPitch},
                               {"yaw", kYaw},
                               {"insertion", kInsertion},
                               {"roll", kRoll},
                               {"jaw", kJaw}};

std::string Shown(std::string_view text) { return QuotedToken(text, '"'); }

std::string_view Trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::vector<std::string_view> Cells(std::string_view line) {
  std::vector<std::string_view> cells;
  for (;;) {
    const std::size_t comma = line.find(',');
    cells.push_back(Trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

std::optional<double> Number(std::string_view cell) {
  if (cell.starts_with('+')) cell.remove_prefix(1);
  double number = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), number);
  if (error != std::errc() || end != cell.data() + cell.size()) return std::nullopt;
  return number;
}

class Reader {
 public:
  explicit Reader(const std::string& path) : buffer_(kMaxTraceLine + 2) {
    trace_.path = path;
    std::error_code ignored;
    if (!std::filesystem::exists(path, ignored)) {
      throw InputError(path + ": no such file; check the path");
    }
    if (!std::filesystem::is_regular_file(path, ignored)) {
      throw InputError(path + ": not a file; give a CSV trace that starts with t,px,py,pz,jaw");
    }
    file_.open(path, std::ios::binary);
    if (!file_) throw InputError(path + ": cannot be read; check its permissions");
  }

  TraceFile Read() {
    std::string_view line;
    if (!NextLine(&line))
      Fail("the file is empty", "give a header such as t,px,py,pz,jaw and rows");
    ReadHeader(line);
    while (NextLine(&line)) ReadRow(line);
    if (trace_.rows.empty()) Fail("has no rows", "give at least one row below the header");
    return std::move(trace_);
  }

 private:
  [[noreturn]] void Fail(const std::string& what, const std::string& remedy) const {
    const std::string line = line_number_ > 0 ? ":" + std::to_string(line_number_) : "";
    throw InputError(trace_.path + line + ": " + what + "; " + remedy);
  }

  // Reads the next line that is neither blank nor a comment. False at the end of the file.
  bool NextLine(std::string_view* line) {
    for (;;) {
      file_.getline(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
      auto length = static_cast<std::size_t>(file_.gcount());
      if (file_.fail() && length == 0) {
        if (file_.bad()) Fail("cannot be read to its end", "copy the file again");
        return false;
      }
      ++line_number_;
      if (file_.fail()) {
        Fail("is longer than " + std::to_string(kMaxTraceLine) + " bytes",
             "give a text file with one row per line");
      }
      if (!file_.eof()) --length;  // the line's end is counted too
      *line = {buffer_.data(), length};
      if (line_number_ == 1) {
        if (line->starts_with("\xFF\xFE") || line->starts_with("\xFE\xFF")) {
          Fail("is UTF-16", "save it as UTF-8 or ASCII");
        }
        if (line->starts_with("\xEF\xBB\xBF")) line->remove_prefix(3);
      }
      *line = Trimmed(*line);
      if (!line->empty() && line->front() != '#' && line->front() != '%') return true;
    }
  }

  void ReadHeader(std::string_view line) {
    if (line.find(';') != std::string_view::npos) {
      Fail("is separated by semicolons",
           "separate cells by commas and write numbers with a decimal point");
    }
    bool has_time = false;
    std::array<bool, std::size(kColumns)> has{};
    for (const std::string_view cell : Cells(line)) {
      if (Number(cell)) {
        Fail("the columns are not named (" + Shown(cell) + ")",
             "begin with a line such as t,px,py,pz,jaw");
      }
      const Column* column = std::find_if(std::begin(kColumns), std::end(kColumns),
                                          [&](const Column& c) { return c.name == cell; });
      columns_.push_back(column);
      if (column == std::end(kColumns)) {
        trace_.unread_columns.push_back(Shown(cell));
        continue;
      }
      bool& named = has[static_cast<std::size_t>(column - kColumns)];
      if (named) Fail("names " + std::string(cell) + " twice", "leave one of the columns out");
      named = true;
      has_time |= column->value == kTime;
    }
    if (!has_time) Fail("has no column t", "name the columns in this line, as t,px,py,pz,jaw");
    const int tip = has[1] + has[2] + has[3], joints = has[4] + has[5] + has[6];
    if (tip % 3 != 0 || joints % 3 != 0 || (tip > 0 && joints > 0)) {
      Fail("has incomplete or mixed position columns",
           "give px, py and pz, or pitch, yaw and insertion");
    }
    if (tip + joints == 0 && !has[7] && !has[8]) {
      Fail("has no column that moves", "name the columns in this line, as t,px,py,pz,jaw");
    }
    trace_.place = tip > 0      ? TracePlace::kTip
                   : joints > 0 ? TracePlace::kJoints
                                : TracePlace::kNone;
  }

  void ReadRow(std::string_view line) {
    const std::vector<std::string_view> cells = Cells(line);
    if (cells.size() != columns_.size()) {
      Fail("has " + std::to_string(cells.size()) + " cells where the header names " +
               std::to_string(columns_.size()),
           "separate cells by single commas and write numbers with a decimal point");
    }
    double time = 0;
    TraceRow row;
    row.values[kJaw] = 1;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (columns_[i] == std::end(kColumns)) continue;
      const std::string name(columns_[i]->name);
      const std::optional<double> number = Number(cells[i]);
      if (!number || !std::isfinite(*number)) {
        Fail(name + " is not a finite number (" + Shown(cells[i]) + ")",
             "write it as 0.123, or leave the row out");
      }
      if (columns_[i]->value == kTime) {
        time = *number;
      } else if (std::abs(*number) > kMaxTraceValue) {
        Fail(name + " is beyond any pose (" + Shown(cells[i]) + ")", "give metres and radians");
      } else {
        row.values[columns_[i]->value] = *number;
      }
    }
    AddRow(time, row);
  }

  void AddRow(double time, TraceRow row) {
    std::vector<TraceRow>& rows = trace_.rows;
    if (rows.empty()) first_time_ = time;
    const double since_start = time - first_time_;
    if (!(std::abs(since_start) <= kMaxTraceSeconds)) {
      Fail("t is more than a day after the first row", "give seconds, or cut the trace here");
    }
    row.time_ns = std::llround(since_start * 1e9);
    if (rows.empty()) {
      rows.push_back(row);
      return;
    }
    const TraceRow& last = rows.back();
    if (row.time_ns < last.time_ns) {
      Fail("time goes backwards", "sort the rows by time, or cut the trace here");
    }
    const double turn = 2 * std::numbers::pi;
    row.values[kRoll] -= turn * std::round((row.values[kRoll] - last.values[kRoll]) / turn);
    if (row.time_ns == last.time_ns) {
      rows.back() = row;
      return;
    }
    if (rows.size() == kMaxTraceRows) {
      Fail("too many rows", "cut the trace to " + std::to_string(kMaxTraceRows) + " rows");
    }
    rows.push_back(row);
  }

  std::ifstream file_;
  std::vector<char> buffer_;
  std::size_t line_number_ = 0;
  std::vector<const Column*> columns_;  // by cell; the end of kColumns if unknown
  double first_time_ = 0;
  TraceFile trace_;
};

}  // namespace

TraceFile ReadTraceFile(const std::string& path) { return Reader(path).Read(); }

}  // namespace hpdm
