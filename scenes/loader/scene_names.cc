#include "scenes/loader/scene_names.h"

#include "engine/base/error.h"
#include "scenes/loader/toml_document.h"

namespace hpdm {
namespace {

using NodeView = toml::node_view<const toml::node>;

std::string NameOf(const toml::node& instrument) {
  return NodeView(instrument)["name"].value_or(std::string());
}

}  // namespace

std::vector<std::vector<std::string>> SceneInstruments(const std::filesystem::path& scene) {
  std::vector<std::vector<std::string>> hands;
  if (scene.empty()) return hands;
  try {
    const TomlDocument document = ReadToml(scene);
    const toml::array* instruments = document.root["instrument"].as_array();
    if (instruments == nullptr) return hands;
    for (const toml::node& instrument : *instruments) {
      std::vector<std::string>& names = hands.emplace_back();
      names.push_back(NameOf(instrument));
      const toml::array* exchanges = NodeView(instrument)["exchange"].as_array();
      if (exchanges == nullptr) continue;
      for (const toml::node& exchange : *exchanges) names.push_back(NameOf(exchange));
    }
    return hands;
  } catch (const InputError&) {
    return {};
  }
}

std::vector<std::string> SceneAttachments(const std::filesystem::path& scene) {
  std::vector<std::string> names;
  if (scene.empty()) return names;
  try {
    const TomlDocument document = ReadToml(scene);
    const toml::array* attachments = document.root["attachment"].as_array();
    if (attachments == nullptr) return names;
    for (const toml::node& attachment : *attachments) {
      names.push_back(NodeView(attachment)["a"].value_or<std::string>("?") + " and " +
                      NodeView(attachment)["b"].value_or<std::string>("?"));
    }
    return names;
  } catch (const InputError&) {
    return {};
  }
}

}  // namespace hpdm
