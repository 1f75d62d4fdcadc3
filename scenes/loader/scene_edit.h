#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "scenes/loader/scene.h"

namespace hpdm {

/// A value to write into a scene file; std::monostate removes the key.
using SceneValue = std::variant<std::monostate, bool, int, double, std::string, std::array<int, 3>>;

/// The new value of one key, in the organ itself (`table` empty) or in its [organ.TABLE].
struct SceneKeyEdit {
  std::string table;
  std::string key;
  SceneValue value;
};

struct OrganEdit {
  std::size_t organ = 0;  ///< Index in the order of the file.
  std::vector<SceneKeyEdit> keys;
  std::vector<std::string> removed_tables;  ///< Names of the organ's tables to remove.
};

/// Returns the scene's text with some keys changed. The author's comments, order and spacing stay:
///
///   1. A new value replaces the old one in place.
///   2. A missing key is inserted after the last key of its table.
///   3. A removed key or table becomes a comment.
///   4. An edited inline table ({...}) is rewritten.
///
/// Throws InputError (file, place, remedy) if an edited organ is itself an inline table.
std::string EditedScene(const Scene& scene, const std::vector<OrganEdit>& edits);

/// Returns the scene's text with `scene.left_handed = true`; the rest stays.
std::string LeftHandedScene(const Scene& scene);

/// Returns a scene's text for use in another folder: relative file names are rewritten to name the
/// same files from there. The same folder gives the same text. Throws InputError for a recorded
/// scene, because its files must stay in its own folder.
std::string MovedScene(const Scene& scene, std::string text,
                       const std::filesystem::path& to_folder);

/// Reads a scene from a text as LoadScene does from the file `path`; messages name `path`.
Scene ParseScene(std::string text, const std::filesystem::path& path);

}  // namespace hpdm
