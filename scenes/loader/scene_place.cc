#include "scenes/loader/scene_place.h"

#include "scenes/loader/toml_document.h"

namespace hpdm {

std::string PlaceInScene(const Scene& scene, const OptionKey& key) {
  std::string place = scene.path.string();
  if (key.table.empty()) return place;
  const TomlDocument document = ParseToml(scene.source_text, scene.path);
  const toml::array* tables = document.root[key.table].as_array();
  if (tables == nullptr) return place;
  for (const toml::node& table : *tables) {
    if (toml::node_view(table)["name"].value_or(std::string()) != key.name) continue;
    const toml::node* value = toml::at_path(table, key.key).node();
    const toml::source_position at = (value != nullptr ? *value : table).source().begin;
    place.append(":").append(std::to_string(at.line));
    place.append(":").append(std::to_string(at.column));
    break;
  }
  return place;
}

}  // namespace hpdm
