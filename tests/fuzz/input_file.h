#pragma once

#include <fstream>
#include <string>
#include <string_view>

#include "engine/base/error.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/support/scratch_folder.h"

namespace hpdm::fuzz {

/// One file in a folder of its own, for readers that take a path.
class InputFile {
 public:
  explicit InputFile(const std::string& name) : path_(folder_ / name) {}

  /// Replaces the file's contents. Returns its path.
  const std::string& Write(Bytes bytes) const {
    std::ofstream file(path_, std::ios::binary | std::ios::trunc);
    file.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    if (!file.flush()) throw std::runtime_error(path_ + ": cannot be written; free space");
    return path_;
  }
  const std::string& path() const { return path_; }
  /// Another file in the same folder.
  std::string operator/(const std::string& name) const { return folder_ / name; }

 private:
  ScratchFolder folder_;
  std::string path_;
};

inline std::string_view Text(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Checks that a refusal is one line of moderate length that begins with `subject` and ends with a
/// remedy.
inline void EnsureOneLine(const InputError& error, std::string_view subject) {
  const std::string_view line = error.what();
  HPDM_ENSURE(line.starts_with(subject));
  HPDM_ENSURE(line.size() <= subject.size() + 1000);
  HPDM_ENSURE(line.find("; ", subject.size()) != std::string_view::npos ||
              line.find(": ", subject.size() + 2) != std::string_view::npos);
  for (const char c : line) HPDM_ENSURE(static_cast<unsigned char>(c) >= ' ' && c != '\x7f');
}

}  // namespace hpdm::fuzz
