#pragma once

#include <filesystem>

#include "lcmtypes/analysis/session_invariants.h"
#include "scenes/loader/scene.h"

namespace hpdm {

/// Returns the path of the scene beside a log.
std::filesystem::path SceneBeside(const std::filesystem::path& log);

/// Reads a recorded scene. Throws InputError as LoadScene does, and also if the scene is a link out
/// of its folder or names a file outside it: a recording of others must not read this machine's
/// files.
Scene LoadRecordedScene(const std::filesystem::path& path);

/// True if nothing drives organs: none breathes. All work then comes from the hands and from free organs.
bool OrgansAreStill(const Scene& scene);

/// Returns the limits that all sessions of a scene keep to.
SessionLimits LimitsOf(const Scene& scene);

}  // namespace hpdm
