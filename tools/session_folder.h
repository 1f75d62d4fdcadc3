#pragma once

#include <filesystem>
#include <string>

#include "scenes/scene.h"

namespace hpdm {

/// The folder that a session leaves behind.
///
///     session.lcmlog   every tick and step (lcmtypes/)
///     scene.toml       the scene as it was read, and at their names in it those of its files that
///                      lie below its own folder (meshes/...), so that the session can be replayed
///     summary.json     the session in figures
///     timeline.csv     force and depth at 100 Hz, timeline.png its plot
///     latency.csv      distributions of the latencies, latency.png their plot (real clock)
///     deepest.png      the picture at the deepest contact, last.png the last one
///     frames/          pictures at --fps
class SessionFolder {
 public:
  /// Makes the folder and copies the scene's text and files. Throws InputError when the folder
  /// cannot be written, or already holds a session, which is never overwritten.
  SessionFolder(const std::filesystem::path& path, const Scene& scene);

  /// out/session_1, or the first number after it that is free.
  static std::filesystem::path FreeName();

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path File(const std::string& name) const { return path_ / name; }

 private:
  void CopyFile(const std::filesystem::path& file, const std::filesystem::path& scene_folder) const;

  std::filesystem::path path_;
};

}  // namespace hpdm
