#include "scenes/loader/scene_names.h"

#include <utility>

#include "engine/base/error.h"
#include "scenes/loader/scene_parts.h"
#include "scenes/loader/toml_document.h"

namespace hpdm {
namespace {

using NodeView = toml::node_view<const toml::node>;

std::string NameOf(const toml::node& instrument) {
  return NodeView(instrument)["name"].value_or(std::string());
}

// Returns read(table) of each table of the scene file's array `key`; none if the file cannot be read.
template <typename Read>
auto ReadAll(const std::filesystem::path& scene, const char* key, Read&& read) {
  std::vector<decltype(read(std::declval<const toml::node&>()))> names;
  if (scene.empty()) return names;
  try {
    const TomlDocument document = ReadToml(scene);
    const toml::array* tables = document.root[key].as_array();
    if (tables == nullptr) return names;
    for (const toml::node& table : *tables) names.push_back(read(table));
  } catch (const InputError&) {
    names.clear();
  }
  return names;
}

// With an observer a reader looks for no files.
class NoObserver : public KeyObserver {
 public:
  void OnTable(std::string_view) override {}
  void OnKey(std::string_view, std::string_view, const KeyForm&) override {}
  void OnValues(std::string_view, std::string_view, const std::vector<double>&) override {}
  void OnRequired(std::string_view, std::string_view) override {}
  void OnExclusive(std::string_view, std::string_view, std::string_view) override {}
};

}  // namespace

std::vector<std::vector<std::string>> SceneInstruments(const std::filesystem::path& scene) {
  return ReadAll(scene, "instrument", [](const toml::node& instrument) {
    std::vector<std::string> names = {NameOf(instrument)};
    const toml::array* exchanges = NodeView(instrument)["exchange"].as_array();
    if (exchanges == nullptr) return names;
    for (const toml::node& exchange : *exchanges) names.push_back(NameOf(exchange));
    return names;
  });
}

std::vector<std::string> SceneAttachments(const std::filesystem::path& scene) {
  return ReadAll(scene, "attachment", [](const toml::node& attachment) {
    const NodeView table(attachment);
    if (const auto name = table["name"].value<std::string>()) return *name;
    return table["a"].value_or<std::string>("?") + " and " + table["b"].value_or<std::string>("?");
  });
}

std::optional<ExerciseOptions> SceneExercise(const std::filesystem::path& scene) {
  if (scene.empty()) return {};
  try {
    NoObserver observer;
    return ReadScene(ReadToml(scene), &observer).exercise;
  } catch (const InputError&) {
    return {};
  }
}

}  // namespace hpdm
