#pragma once

#include <string>
#include <vector>

namespace hpdm {

/// Runs a plot script (Python source, with Debian's matplotlib) with the given arguments and waits
/// for it. Returns an empty string, or why there is no plot: one line. Main thread, loops ended.
std::string RunPlotScript(const std::string& script, const std::vector<std::string>& arguments);

}  // namespace hpdm
