#include "tools/shared/staged_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <random>
#include <string>
#include <utility>

#include "engine/base/error.h"

namespace hpdm {

namespace fs = std::filesystem;

namespace {

/// True if the path is an open file, such as /dev/stdout: a link into /proc that names the open
/// file instead of a path.
bool IsOpenFile(fs::path path) {
  constexpr int kMaxLinks = 40;  // the kernel's limit
  std::error_code error;
  for (int i = 0; i < kMaxLinks && fs::is_symlink(path, error); ++i) {
    const fs::path folder = path.parent_path();
    const fs::path whole = fs::canonical(folder.empty() ? "." : folder, error);
    if (error) return false;
    if (whole.native().starts_with("/proc/")) return true;
    path = whole / fs::read_symlink(path, error);
  }
  return false;
}

}  // namespace

std::string WriteFault(int error) {
  if (error == ENOSPC || error == EDQUOT)
    return ": cannot be written: no space left; free space or ";
  return std::string(": cannot be written (") + std::strerror(error) + "); ";
}

void MakeOutFolder(const fs::path& out) {
  std::error_code error;
  fs::create_directories(out, error);
  if (!error) return;
  throw InputError(out.string() + ": cannot be created (" + error.message() +
                   "); choose another folder with --out");
}

void RefuseOwnInput(const fs::path& out, const std::vector<std::string>& inputs) {
  for (const std::string& input : inputs) {
    std::error_code error;
    if (!fs::is_regular_file(input, error) || !fs::equivalent(out, input, error)) continue;
    throw InputError(out.string() + ": is an input of this command; choose another output file");
  }
}

StagedFile::StagedFile(fs::path path, Name name) : path_(std::move(path)) {
  std::error_code ignored;
  const bool follows = name == Name::kOfUser;
  const bool is_open = follows && IsOpenFile(path_);
  // A symbolic link is kept; the file that it points to is replaced.
  if (follows && !is_open && fs::is_symlink(path_, ignored) &&
      fs::is_regular_file(path_, ignored)) {
    if (fs::path file = fs::canonical(path_, ignored); !ignored) path_ = std::move(file);
  }
  fs::file_status status =
      follows ? fs::status(path_, ignored) : fs::symlink_status(path_, ignored);
  if (!follows && fs::is_symlink(status)) status = fs::file_status(fs::file_type::not_found);
  if (!follows && fs::is_other(status)) {
    throw InputError(path_.string() + ": not a file; remove it, or choose another path with --out");
  }
  int descriptor = -1;
  if (fs::is_directory(status) || path_.filename().empty()) Refuse(EISDIR);
  if (is_open || (fs::exists(status) && !fs::is_regular_file(status))) {
    // Appends: without O_APPEND an open file would be overwritten from its beginning.
    descriptor = open(path_.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  } else {
    std::random_device random;
    do {
      written_ = path_;
      written_ += ".part-" + std::to_string(random());
      descriptor = open(written_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    } while (descriptor < 0 && errno == EEXIST);
  }
  if (descriptor < 0) Refuse(errno);
  file_ = fdopen(descriptor, "wb");
  if (file_ == nullptr) {
    const int error = errno;
    close(descriptor);
    if (!written_.empty()) unlink(written_.c_str());
    Refuse(error);
  }
}

StagedFile::StagedFile(StagedFile&& other) noexcept
    : path_(std::move(other.path_)),
      written_(std::exchange(other.written_, {})),
      file_(std::exchange(other.file_, nullptr)) {}

StagedFile::~StagedFile() {
  if (file_ != nullptr) std::fclose(file_);
  if (!written_.empty()) unlink(written_.c_str());
}

void StagedFile::Write(std::string_view bytes) {
  if (file_ == nullptr) file_ = std::fopen(written_.c_str(), "abe");
  if (file_ == nullptr) Refuse(errno);
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) Refuse(errno);
}

void StagedFile::Rest() {
  if (!written_.empty()) Close();  // a pipe would end if it were closed
}

void StagedFile::Close() {
  if (file_ == nullptr) return;
  if (std::fclose(std::exchange(file_, nullptr)) != 0) Refuse(errno);
}

void StagedFile::Commit() {
  Close();
  if (written_.empty()) return;
  if (std::rename(written_.c_str(), path_.c_str()) != 0) Refuse(errno);
  written_.clear();
}

void StagedFile::Refuse(int error) const {
  throw InputError(path_.string() + WriteFault(error) + "choose another path");
}

}  // namespace hpdm
