#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace hpdm {

/// Returns the names of a recorded scene's files whose contents are not those of the record: by
/// their SHA-256 in the [[file]] tables. Nothing if the scene is missing or not a scene. Files that
/// are missing, that cannot be read, or that lie outside the scene's folder are left out.
std::vector<std::string> ChangedFiles(const std::filesystem::path& scene);

}  // namespace hpdm
