#include "scenes/loader/changed_files.h"

#include "engine/base/error.h"
#include "scenes/loader/file_hash.h"
#include "scenes/loader/scene_files.h"
#include "scenes/loader/toml_document.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;
using NodeView = toml::node_view<const toml::node>;

/// True if the file can be read and its contents differ from the record.
bool Differs(const fs::path& folder, const std::string& name, const std::string& sha256) {
  std::error_code error;
  const fs::path file = folder / name;
  if (!StaysInside(name) || !LiesInside(folder, file) || !fs::is_regular_file(file, error)) {
    return false;
  }
  try {
    return Sha256OfFile(file) != sha256;
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

std::vector<std::string> ChangedFiles(const fs::path& scene) {
  std::vector<std::string> changed;
  if (scene.empty()) return changed;
  try {
    const TomlDocument document = ReadToml(scene);
    const toml::array* files = document.root["file"].as_array();
    if (files == nullptr) return changed;
    for (const toml::node& file : *files) {
      const NodeView table(file);
      const std::string name = table["name"].value_or(std::string());
      const std::string copy = table["copy"].value_or(name);
      const std::string sha256 = table["sha256"].value_or(std::string());
      if (IsSha256(sha256) && Differs(scene.parent_path(), copy, sha256)) changed.push_back(copy);
    }
    return changed;
  } catch (const InputError&) {
    return {};
  }
}

}  // namespace hpdm
