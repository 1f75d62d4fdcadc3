#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/exercise/exercise_options.h"

namespace hpdm {

/// Returns the names of a scene's instruments, by hand and ToolPose::instrument_index; nothing if
/// the file is missing or not a scene. Reads only the names, so it also serves for a scene whose
/// meshes are missing or that this version refuses.
std::vector<std::vector<std::string>> SceneInstruments(const std::filesystem::path& scene);

/// Returns the names of a scene file's attachments, "a and b", in order. None if the file cannot be
/// read.
std::vector<std::string> SceneAttachments(const std::filesystem::path& scene);

/// Returns a scene file's exercise; none if it has none, or if the file is missing or refused. Its
/// meshes need not exist.
std::optional<ExerciseOptions> SceneExercise(const std::filesystem::path& scene);

}  // namespace hpdm
