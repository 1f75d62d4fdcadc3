#pragma once

#include <filesystem>
#include <string>

namespace hpdm {

/// Makes an MP4 film (H.264) from a folder's frame_000000.png, frame_000001.png, ... at `fps`
/// frames per second with the system's ffmpeg. Returns an empty string, or one line that says why
/// there is no film and what to do. Main thread, loops ended.
std::string MakeFilm(const std::filesystem::path& frames, double fps,
                     const std::filesystem::path& film);

}  // namespace hpdm
