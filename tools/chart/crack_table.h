#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace hpdm {

/// Measures the bodies of crack_bench.h and writes cracks.md into `folder`. `quick`: those with few
/// functions only. Calls say(line) after each body.
void MeasureCracks(const std::filesystem::path& folder, bool quick,
                   const std::function<void(const std::string&)>& say);

}  // namespace hpdm
