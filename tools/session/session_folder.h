#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "scenes/loader/scene.h"

namespace hpdm {

/// A file of which a session keeps a copy.
struct KeptFile {
  std::string name;    ///< As the scene or the command line wrote it.
  std::string copy;    ///< Path of the copy in the session's folder.
  std::string sha256;  ///< Hash of the copy.
};

/// A session's folder: a complete record, which can be moved anywhere.
///
///     session.lcmlog   every tick and step (lcmtypes/)
///     scene.toml       the scene as it was read, then a [[file]] table for each file that it names
///                      (scenes/README.md), with which loading checks that the files are the same
///     meshes/...       those files that lie below the scene's folder, under their names
///     files/...        the other files, and the traces of the command line
///     summary.json     results of the session, and its command line
///     timeline.csv     force and depth at 100 Hz, timeline.png its plot
///     latency.csv      distributions of the latencies, latency.png their plot (real clock)
///     deepest.png      the picture of the deepest press, if a tip pressed; last.png the last one
///     frames/          pictures at --fps
///     screenshots/     pictures that a window's user took
///
/// Nothing is ever overwritten. During the session some space is reserved, so that a disk that
/// fills up still has room for the summary. The folder may be renamed during the session.
class SessionFolder {
 public:
  /// Creates the folder with the scene and copies of its files and of `traces`. Throws InputError
  /// if the folder cannot be written, already has a session, or has another file of one of the
  /// names; what it had made until then is removed again.
  SessionFolder(const std::filesystem::path& path, const Scene& scene,
                const std::vector<std::string>& traces = {});

  ~SessionFolder();
  SessionFolder(const SessionFolder&) = delete;
  SessionFolder& operator=(const SessionFolder&) = delete;

  /// Ends the session: frees the reserved space and sets path() to the folder's present place.
  /// Returns false if the folder was deleted.
  bool Finish();

  /// Deletes the folder; if others made it, only the copies, the log and the timeline. For a session
  /// that ended before its first tick.
  void Discard();

  /// Throws InputError if the path leads through a file, or if the folder already has a session or a
  /// file that a session would replace.
  /// Reads only, so that it can be asked before a long set-up.
  static void RefuseExisting(const std::filesystem::path& path);

  /// Returns out/session_N with the first free number N from 1.
  static std::filesystem::path FreeName();

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path File(const std::string& name) const { return path_ / name; }
  const std::vector<KeptFile>& files() const { return files_; }

 private:
  explicit SessionFolder(const std::filesystem::path& path);
  void RemoveMade();
  void Keep(const std::string& name, const std::filesystem::path& from, std::string copy);
  std::string FreeCopyName(const std::filesystem::path& file) const;
  void WriteScene(const Scene& scene);
  void Reserve();

  std::filesystem::path path_;
  bool created_ = false;                     // the folder did not exist before
  bool complete_ = false;                    // it has its scene and all copies
  std::vector<std::filesystem::path> made_;  // files and folders in it, as they were made
  std::vector<KeptFile> files_;
  int folder_descriptor_ = -1;
  int reserve_descriptor_ = -1;
};

}  // namespace hpdm
