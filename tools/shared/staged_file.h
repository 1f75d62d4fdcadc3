#pragma once

#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace hpdm {

/// Returns ": cannot be written (REASON); " for an errno, to which the caller adds what to choose
/// instead. A full disk has the remedy "free space or " as well.
std::string WriteFault(int error);

/// Creates a command's --out folder if it does not exist. Throws InputError if it cannot.
void MakeOutFolder(const std::filesystem::path& out);

/// Throws InputError if `out`, which will be written, is one of the files that the command reads.
void RefuseOwnInput(const std::filesystem::path& out, const std::vector<std::string>& inputs);

/// A file that appears only when it is complete. It is written as NAME.part-... in the same folder.
/// Commit renames it to NAME and replaces a file of that name. Without Commit nothing remains. One
/// thread.
class StagedFile {
 public:
  /// Who chose the name.
  ///   kOfUser    Links are followed. Pipes, devices and open files (/dev/stdout) are appended to.
  ///   kOfOthers  The name comes from a log, or the folder may be a stranger's. A link is replaced
  ///              and never followed; anything else that is not a file is refused.
  enum class Name { kOfUser, kOfOthers };
  /// Throws InputError if the file cannot be created.
  explicit StagedFile(std::filesystem::path path, Name name = Name::kOfUser);
  StagedFile(StagedFile&& other) noexcept;
  ~StagedFile();
  StagedFile& operator=(StagedFile&&) = delete;

  /// Appends the bytes. Throws InputError at the first failure.
  void Write(std::string_view bytes);
  /// Closes the file until the next Write, so that many staged files need few open descriptors.
  /// Throws InputError.
  void Rest();
  /// Completes the file without renaming it: all of several files can be complete before the first
  /// appears. Throws InputError.
  void Close();
  /// Closes the file if it is open and renames it. Throws InputError.
  void Commit();

 private:
  [[noreturn]] void Refuse(int error) const;

  std::filesystem::path path_;
  std::filesystem::path written_;  // the temporary file; empty: path_ itself
  std::FILE* file_ = nullptr;      // null: closed
};

}  // namespace hpdm
