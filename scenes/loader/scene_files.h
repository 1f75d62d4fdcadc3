#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace hpdm {

class TableReader;

/// A file that a scene names.
struct SceneFile {
  std::string name;    ///< As the scene writes it.
  std::string path;    ///< Where it is: absolute, or relative to the working folder.
  std::string copy;    ///< As its [[file]] says, or empty.
  std::string sha256;  ///< As its [[file]] says, or empty; verified.
};

/// Whether a name, read from a folder, stays inside of it: relative, and not out by "..".
bool StaysInside(const std::filesystem::path& name);

/// Whether a file exists and lies inside a folder, links followed; an empty folder is the working
/// folder.
bool LiesInside(const std::filesystem::path& folder, const std::filesystem::path& file);

/// Finds the files that a scene names. Without [[file]] tables a name is a path that starts at the
/// scene's folder and may lead anywhere. With them the scene is a record: each name must have its
/// table, its file must lie inside the scene's folder (by name, and with links followed) and be the
/// same to the bit.
/// One thread.
class SceneFiles {
 public:
  /// Why a file is not usable, and what to do.
  struct Fault {
    std::string what, remedy;
  };

  explicit SceneFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// Takes the scene's [[file]] tables. Throws InputError.
  void ReadEntries(const TableReader& root);

  /// Sets the path of the file that the scene calls `name`, which exists; or returns a fault.
  std::optional<Fault> Find(const std::string& name, std::string* path);

  /// Those found so far, each once, in that order.
  const std::vector<SceneFile>& found() const { return found_; }
  /// The scene has [[file]] tables.
  bool recorded() const { return !entries_.empty(); }

 private:
  std::optional<Fault> Verify(const SceneFile& file) const;

  std::filesystem::path folder_;
  std::vector<SceneFile> entries_;  // without their paths
  std::vector<SceneFile> found_;
};

}  // namespace hpdm
