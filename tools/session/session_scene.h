#pragma once

#include <filesystem>

#include "lcmtypes/analysis/session_invariants.h"
#include "scenes/loader/scene.h"

namespace hpdm {

/// Where a log's own scene is: beside it.
std::filesystem::path SceneBeside(const std::filesystem::path& log);

/// Reads a recorded scene. Throws InputError, as LoadScene does and where the scene is, or names, a
/// file outside of its folder: what others recorded names no files of this machine, nor leads to
/// them by a link.
Scene LoadRecordedScene(const std::filesystem::path& path);

/// What a scene says that its sessions keep to.
SessionLimits LimitsOf(const Scene& scene);

}  // namespace hpdm
