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

/// A value as it is to stand in a scene file; std::monostate: the key is not to be given.
using SceneValue = std::variant<std::monostate, bool, int, double, std::string, std::array<int, 3>>;

/// What is to become of one key: of the organ itself (`table` empty), or of its [organ.TABLE].
struct SceneKeyEdit {
  std::string table;
  std::string key;
  SceneValue value;
};

struct OrganEdit {
  std::size_t organ = 0;  ///< In the order of the file.
  std::vector<SceneKeyEdit> keys;
  std::vector<std::string> removed_tables;  ///< Of the organ.
};

/// A scene's text with some keys changed, and nothing else: values are replaced where they stand,
/// missing keys follow the last one of their table, and what is to go is made a comment, so that
/// the author's words, order and spacing remain. Inline tables ({...}) that lose a key are written
/// anew. Throws InputError (file, place, remedy) where an organ stands in an inline table itself.
std::string EditedScene(const Scene& scene, const std::vector<OrganEdit>& edits);

/// The text of a scene file of one folder for another: the names of files that are relative lead to
/// the same files from there. The same text for the same folder. Throws InputError for a recorded
/// scene, whose files lie in its own folder.
std::string MovedScene(const Scene& scene, std::string text,
                       const std::filesystem::path& to_folder);

}  // namespace hpdm
