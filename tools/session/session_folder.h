#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "scenes/loader/scene.h"

namespace hpdm {

/// A file that a session keeps a copy of.
struct KeptFile {
  std::string name;    ///< As the scene or the command line wrote it.
  std::string copy;    ///< Where it is in the session's folder.
  std::string sha256;  ///< Of the copy.
};

/// The folder that a session leaves behind: a record that is whole by itself, wherever it is moved.
///
///     session.lcmlog   every tick and step (lcmtypes/)
///     scene.toml       the scene as it was read, then a [[file]] table for each file that it names
///                      (scenes/README.md): loading it again proves that they are the same
///     meshes/...       those files at their names, where these lie below the scene's folder,
///     files/...        the others, and the traces of the command line
///     summary.json     the session in figures, and how it was called
///     timeline.csv     force and depth at 100 Hz, timeline.png its plot
///     latency.csv      distributions of the latencies, latency.png their plot (real clock)
///     deepest.png      the picture at the deepest contact, last.png the last one
///     frames/          pictures at --fps
///     screenshots/     pictures that a window's user took
///
/// Nothing is ever overwritten. While the session lasts some space is reserved, so that a disk
/// which fills up has room for the summary; and the folder may be renamed.
class SessionFolder {
 public:
  /// Makes the folder with the scene and copies of its files and of `traces`. Throws InputError
  /// when the folder cannot be written, already holds a session, or another file of such a name.
  SessionFolder(const std::filesystem::path& path, const Scene& scene,
                const std::vector<std::string>& traces = {});

  ~SessionFolder();
  SessionFolder(const SessionFolder&) = delete;
  SessionFolder& operator=(const SessionFolder&) = delete;

  /// The session is over: gives the reserved space back, and path() is where the folder is by now.
  /// False where it was deleted.
  bool Finish();

  /// out/session_1, or the first number after it that is free.
  static std::filesystem::path FreeName();

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path File(const std::string& name) const { return path_ / name; }
  const std::vector<KeptFile>& files() const { return files_; }

 private:
  void Keep(const std::string& name, const std::filesystem::path& from, std::string copy);
  std::string FreeCopyName(const std::filesystem::path& file) const;
  void WriteScene(const Scene& scene) const;
  void Reserve();

  std::filesystem::path path_;
  std::vector<KeptFile> files_;
  int folder_descriptor_ = -1;
  int reserve_descriptor_ = -1;
};

}  // namespace hpdm
