#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace hpdm {

class TableReader;

/// A file that a scene names.
struct SceneFile {
  std::string name;    ///< As written in the scene.
  std::string path;    ///< Absolute, or relative to the working folder.
  std::string copy;    ///< From its [[file]] table, or empty.
  std::string sha256;  ///< From its [[file]] table and verified, or empty.
};

/// True if a name, resolved from a folder, stays inside it: relative, without leaving by "..".
bool StaysInside(const std::filesystem::path& name);

/// True if a file exists and lies inside a folder after following links. An empty folder means the
/// working folder.
bool LiesInside(const std::filesystem::path& folder, const std::filesystem::path& file);

/// Finds the files that a scene names. Without [[file]] tables a name is a path relative to the
/// scene's folder and may lead anywhere. With them the scene is a record, and each file must:
///
///   1. have a [[file]] table,
///   2. lie inside the scene's folder, by name and after following links,
///   3. be unchanged, by its SHA-256.
///
/// One thread.
class SceneFiles {
 public:
  /// The reason why a file is not usable, and the remedy.
  struct Fault {
    std::string what, remedy;
  };

  explicit SceneFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// Reads the scene's [[file]] tables. Throws InputError if one is invalid.
  void ReadEntries(const TableReader& root);

  /// Sets `path` to the existing file that the scene calls `name`, or returns a fault.
  std::optional<Fault> Find(const std::string& name, std::string* path);

  /// The files found so far, each once, in the order of their first search.
  const std::vector<SceneFile>& found() const { return found_; }
  /// True if the scene has [[file]] tables.
  bool recorded() const { return !entries_.empty(); }

 private:
  std::optional<Fault> Verify(const SceneFile& file) const;

  std::filesystem::path folder_;
  std::vector<SceneFile> entries_;  // without their paths
  std::vector<SceneFile> found_;
};

}  // namespace hpdm
