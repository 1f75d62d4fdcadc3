#include "tools/report/fleet/lines_table.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <string_view>
#include <utility>

#include "engine/base/error.h"
#include "tools/shared/staged_file.h"

namespace hpdm {

using Json = nlohmann::ordered_json;

LinesTable::LinesTable(std::filesystem::path path) : path_(std::move(path)) {
  descriptor_ = open(path_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (descriptor_ < 0) {
    throw InputError(path_.string() + WriteFault(errno) + "choose another file with --out");
  }
  if (!IsTable()) {
    close(descriptor_);
    throw InputError(path_.string() +
                     ": not a table of hpdm report: its first line is not a session's; choose "
                     "another file with --out");
  }
  char last = '\n';
  const off_t size = lseek(descriptor_, 0, SEEK_END);
  if (size > 0 && pread(descriptor_, &last, 1, size - 1) == 1 && last != '\n') Append("\n");
}

LinesTable::~LinesTable() { close(descriptor_); }

std::unordered_map<std::string, KnownSession> LinesTable::Known() {
  std::unordered_map<std::string, KnownSession> known;
  std::ifstream file(path_, std::ios::binary);
  for (std::string text; std::getline(file, text);) {
    const Json line = Json::parse(text, nullptr, false);
    if (const auto session = KnownFrom(line)) known[line["session"].get<std::string>()] = *session;
  }
  return known;
}

void LinesTable::Add(std::span<const Json> lines) {
  std::string text;
  for (const Json& line : lines) text += LineText(line) + "\n";
  Append(text);
}

bool LinesTable::IsTable() const {
  if (!std::filesystem::is_regular_file(path_)) return false;
  std::ifstream file(path_, std::ios::binary);
  // Every line of LineText begins with this text. Reads no more of any other file.
  constexpr std::string_view kBeginning = "{\"session\":";
  std::array<char, kBeginning.size()> beginning{};
  file.read(beginning.data(), beginning.size());
  const auto count = static_cast<std::size_t>(file.gcount());
  if (!kBeginning.starts_with({beginning.data(), count})) return false;
  file.clear();
  file.seekg(0);
  std::string first;
  std::getline(file, first);
  const bool torn = file.eof();  // or the file is empty
  return torn || KnownFrom(Json::parse(first, nullptr, false)).has_value();
}

void LinesTable::Append(const std::string& text) {
  // Writes in one piece while it holds the lock. A line cut by a full disk is then at the end of
  // the file and can be removed.
  flock(descriptor_, LOCK_EX);
  const off_t before = lseek(descriptor_, 0, SEEK_END);
  const ssize_t written = write(descriptor_, text.data(), text.size());
  const int error = written < 0 ? errno : ENOSPC;
  const bool whole = written == static_cast<ssize_t>(text.size());
  const bool taken_back = whole || written <= 0 || ftruncate(descriptor_, before) == 0;
  flock(descriptor_, LOCK_UN);
  if (whole) return;
  throw InputError(path_.string() + ": cannot be written (" + std::strerror(error) +
                   "); free space and run again to continue" +
                   (taken_back ? "" : " after a torn line"));
}

}  // namespace hpdm
