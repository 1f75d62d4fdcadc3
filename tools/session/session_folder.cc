#include "tools/session/session_folder.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string_view>

#include "engine/base/error.h"
#include "engine/base/quoted_token.h"
#include "scenes/generator/meshing/obj_writer.h"
#include "scenes/loader/file_hash.h"
#include "tools/session/session_path.h"
#include "tools/shared/staged_file.h"

namespace hpdm {
namespace fs = std::filesystem;
namespace {

constexpr char kFilesFolder[] = "files";
// More than summary.json and latency.csv need.
constexpr off_t kReserveBytes = 256 * 1024;

// Names that a session, and the commands that read it, write in its folder. No copy of a scene's
// file may have such a name.
constexpr const char* kOwnNames[] = {kSessionLogName, "scene.toml",  "summary.json", "timeline.csv",
                                     "timeline.png",  "latency.csv", "latency.png",  "deepest.png",
                                     "last.png",      "film.mp4",    "frames",       "screenshots",
                                     "report.html",   kFilesFolder};

bool IsOwnName(const fs::path& name) {
  return std::find(std::begin(kOwnNames), std::end(kOwnNames), *name.lexically_normal().begin()) !=
         std::end(kOwnNames);
}

// Returns a TOML basic string. Names in a scene contain no control characters.
std::string TomlString(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + '"';
}

// Copies a file's bytes and permissions to a new file. Returns 0, or the errno of the failure, which
// std::filesystem reports as an I/O error even when the disk is full.
int CopyFile(const fs::path& from, const fs::path& to) {
  const int in = open(from.c_str(), O_RDONLY | O_CLOEXEC);
  if (in < 0) return errno;
  struct stat status {};
  fstat(in, &status);
  const int out = open(to.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  int error = out < 0 ? errno : 0;
  char block[1 << 16];
  for (ssize_t size = 1; error == 0 && size > 0;) {
    size = read(in, block, sizeof block);
    if (size < 0) error = errno;
    for (ssize_t done = 0, part = 0; error == 0 && done < size; done += part) {
      part = write(out, block + done, static_cast<std::size_t>(size - done));
      if (part < 0) error = errno;
    }
  }
  if (error == 0) fchmod(out, status.st_mode & 0777);
  close(in);
  if (out >= 0 && close(out) != 0 && error == 0) error = errno;  // some systems report it only now
  return error;
}

[[noreturn]] void FailToWrite(const fs::path& path, int error) {
  throw InputError(path.string() + WriteFault(error) + "choose another folder with --out");
}

[[noreturn]] void FailToCreate(const fs::path& path, const std::string& reason) {
  throw InputError(path.string() + ": cannot be created (" + reason +
                   "); choose another folder with --out");
}

}  // namespace

SessionFolder::SessionFolder(const fs::path& path) : path_(path) {
  std::error_code error;
  created_ = fs::create_directories(path_, error);
  if (error) FailToCreate(path_, error.message());
  RefuseExisting(path_);
  folder_descriptor_ = open(path_.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
}

// The destructor runs also if this body throws.
SessionFolder::SessionFolder(const fs::path& path, const Scene& scene,
                             const std::vector<std::string>& traces)
    : SessionFolder(path) {
  for (const SceneFile& file : scene.files) {
    std::string copy = file.copy;
    if (scene.recorded) {
      // SceneFiles has checked that the path stays inside the folder.
      if (copy.empty()) copy = file.name;
      if (IsOwnName(copy) && *fs::path(copy).lexically_normal().begin() != kFilesFolder) {
        throw InputError(scene.path.string() + ": [[file]] " + Quoted(copy) +
                         ": is a file that a session itself writes; give the file another copy");
      }
    } else if (copy.empty() && StaysInside(file.name) && !IsOwnName(file.name)) {
      copy = file.name;
    }
    Keep(file.name, file.path, copy);
  }
  WriteScene(scene);
  for (const std::string& trace : traces) {
    const auto of_scene = [&trace](const SceneFile& file) { return file.path == trace; };
    if (std::none_of(scene.files.begin(), scene.files.end(), of_scene)) Keep(trace, trace, "");
  }
  Reserve();
  complete_ = true;
}

SessionFolder::~SessionFolder() {
  if (!complete_) RemoveMade();
  for (const int descriptor : {folder_descriptor_, reserve_descriptor_}) {
    if (descriptor >= 0) close(descriptor);
  }
}

/// Reserves space in an open file without a name, which is freed however the program ends.
void SessionFolder::Reserve() {
  const fs::path path = File("reserve");
  reserve_descriptor_ = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (reserve_descriptor_ < 0) FailToWrite(path, errno);
  unlink(path.c_str());
  const int error = posix_fallocate(reserve_descriptor_, 0, kReserveBytes);
  if (error == ENOSPC || error == EDQUOT) FailToWrite(path_, error);
}

void SessionFolder::RefuseExisting(const fs::path& path) {
  std::error_code ignored;
  fs::path there = path;  // the part of the path that exists
  while (!there.empty() && !fs::exists(there, ignored)) there = there.parent_path();
  if (!there.empty() && !fs::is_directory(there, ignored))
    FailToCreate(path, std::strerror(ENOTDIR));
  if (access(there.empty() ? "." : there.c_str(), W_OK | X_OK) != 0) {
    FailToCreate(path, std::strerror(errno));
  }
  const std::string remedy = "; leave --out out to get a new folder, or name another";
  if (fs::exists(path / kSessionLogName, ignored)) {
    throw InputError(path.string() + ": already has a session" + remedy);
  }
  for (const std::string_view name : kOwnNames) {
    // Copies are compared with what is there already (Keep, WriteScene).
    if (name == kFilesFolder || name == "scene.toml") continue;
    if (!fs::exists(fs::symlink_status(path / name, ignored))) continue;
    throw InputError((path / name).string() + ": exists, and a session would replace it" + remedy);
  }
}

void SessionFolder::Discard() {
  if (!Finish()) return;
  RemoveMade();
  std::error_code ignored;
  for (const char* name : {kSessionLogName, "timeline.csv"}) fs::remove(File(name), ignored);
}

void SessionFolder::RemoveMade() {
  std::error_code ignored;
  if (created_) {
    fs::remove_all(path_, ignored);
    return;
  }
  // Others' files stay, and a folder that contains one.
  for (auto name = made_.rbegin(); name != made_.rend(); ++name) fs::remove(path_ / *name, ignored);
}

bool SessionFolder::Finish() {
  if (reserve_descriptor_ >= 0) close(reserve_descriptor_);
  reserve_descriptor_ = -1;
  std::error_code error;
  struct stat folder, named;
  if (fstat(folder_descriptor_, &folder) != 0) return fs::exists(path_, error);
  if (folder.st_nlink == 0) return false;
  if (stat(path_.c_str(), &named) == 0 && named.st_ino == folder.st_ino &&
      named.st_dev == folder.st_dev) {
    return true;
  }
  const fs::path now =
      fs::read_symlink("/proc/self/fd/" + std::to_string(folder_descriptor_), error);
  if (!error) path_ = now;
  return !error;
}

/// Copies a file to `copy`, or to a free name in files/ where that is empty.
void SessionFolder::Keep(const std::string& name, const fs::path& from, std::string copy) {
  if (copy.empty()) copy = FreeCopyName(from);
  const fs::path to = File(copy).lexically_normal();
  std::error_code error;
  if (fs::create_directories(to.parent_path(), error))
    made_.push_back(fs::path(copy).parent_path());
  if (error) FailToWrite(to, error.value());
  // The target may exist already: a file has two names, or --out is the scene's own folder.
  if (!fs::exists(to, error)) {
    made_.emplace_back(copy);
    if (const int fault = CopyFile(from, to); fault != 0) FailToWrite(to, fault);
  }
  KeptFile& kept = files_.emplace_back(KeptFile{name, copy, Sha256OfFile(to)});
  if (kept.sha256 != Sha256OfFile(from)) {
    throw InputError(to.string() + ": already exists and differs from " + from.string() +
                     "; choose another folder with --out");
  }
}

std::string SessionFolder::FreeCopyName(const fs::path& file) const {
  const auto taken = [this](const std::string& name) {
    return std::any_of(files_.begin(), files_.end(),
                       [&](const KeptFile& kept) { return fs::path(kept.copy) == name; });
  };
  for (int number = 1;; ++number) {
    std::string name = kFilesFolder;
    name.append("/").append(file.stem().string());
    if (number > 1) name.append("_").append(std::to_string(number));
    name.append(file.extension().string());
    if (!taken(name)) return name;
  }
}

void SessionFolder::WriteScene(const Scene& scene) {
  std::string text = scene.source_text;
  if (!scene.recorded && !files_.empty()) {
    if (!text.ends_with('\n')) text += '\n';
    text += "\n# The files that the session read.\n";
    for (const KeptFile& file : files_) {
      text += "[[file]]\nname = " + TomlString(file.name) + "\n";
      if (file.copy != file.name) text += "copy = " + TomlString(file.copy) + "\n";
      text += "sha256 = \"" + file.sha256 + "\"\n";
    }
  }
  const fs::path path = File("scene.toml");
  std::error_code ignored;
  if (fs::exists(path, ignored)) {
    std::ifstream file(path, std::ios::binary);
    if (std::string(std::istreambuf_iterator<char>(file), {}) == text) return;
    throw InputError(path.string() +
                     ": already exists and is another scene; choose another folder with --out");
  }
  made_.emplace_back("scene.toml");
  WriteTextFile(path, text);
}

fs::path SessionFolder::FreeName() {
  int number = 1;
  const auto name = [&] { return fs::path("out") / ("session_" + std::to_string(number)); };
  std::error_code ignored;
  while (fs::exists(name(), ignored)) ++number;
  return name();
}

}  // namespace hpdm
