#pragma once

#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace hpdm {

/// Makes a command's --out folder, unless it is there. Throws InputError where that cannot be.
void MakeOutFolder(const std::filesystem::path& out);

/// Throws InputError where `out`, to be written, is one of the files that the command reads.
void RefuseOwnInput(const std::filesystem::path& out, const std::vector<std::string>& inputs);

/// A file that gets its name only when it is whole: it is written beside its place as
/// NAME.part-..., and Commit gives it the name, replacing what had it. Without Commit nothing
/// remains. One thread.
class StagedFile {
 public:
  /// Who chose the name. Of the user's, a link is followed, and a pipe, a device and what is open
  /// already (/dev/stdout) are written as they are, at their end. Of a name that comes from a log,
  /// or that stands in a folder which may be a stranger's, a link is replaced, never followed, and
  /// what is neither a file nor a link is refused.
  enum class Name { kOfUser, kOfOthers };

  /// Throws InputError where it cannot be made.
  explicit StagedFile(std::filesystem::path path, Name name = Name::kOfUser);
  StagedFile(StagedFile&& other) noexcept;
  ~StagedFile();
  StagedFile& operator=(StagedFile&&) = delete;

  /// Throws InputError at the first failure that is noticed.
  void Write(std::string_view bytes);
  /// Closes the file until the next Write, of many that would not all be open. Throws InputError.
  void Rest();
  /// What remains of the writing, without giving the name yet: of several files each is whole
  /// before the first appears. Throws InputError.
  void Close();
  /// Close, if need be, then the name. Throws InputError.
  void Commit();

 private:
  [[noreturn]] void Refuse(const char* what, int error) const;

  std::filesystem::path path_;
  std::filesystem::path written_;  // empty: path_ itself
  std::FILE* file_ = nullptr;      // null: at rest, or closed
};

}  // namespace hpdm
