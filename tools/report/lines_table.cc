#include "tools/report/lines_table.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>

#include "engine/error.h"

namespace hpdm {

using Json = nlohmann::ordered_json;

LinesTable::LinesTable(std::filesystem::path path) : path_(std::move(path)) {
  descriptor_ = open(path_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (descriptor_ < 0) {
    throw InputError(path_.string() + ": cannot be written (" + std::strerror(errno) +
                     "); choose another --out");
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

void LinesTable::Append(const std::string& text) {
  // In one piece, so that lines of two programs do not mix.
  const ssize_t written = write(descriptor_, text.data(), text.size());
  if (written != static_cast<ssize_t>(text.size())) {
    throw InputError(path_.string() + ": cannot be written (" +
                     std::strerror(written < 0 ? errno : ENOSPC) +
                     "); make space and run again, which goes on from here");
  }
}

}  // namespace hpdm
