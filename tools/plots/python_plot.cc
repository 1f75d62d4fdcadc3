#include "tools/plots/python_plot.h"

#include "engine/base/error.h"
#include "tools/shared/child_process.h"

namespace hpdm {
namespace {

// Debian's own interpreter: another one on the path would lack Debian's matplotlib.
constexpr char kPython[] = "/usr/bin/python3";

// True if matplotlib is installed. It is not imported: that needs space for its cache.
bool HasMatplotlib() {
  return RunChild({kPython, "-c",
                   "import importlib.util, sys\n"
                   "sys.exit(importlib.util.find_spec('matplotlib') is None)"}) == 0;
}

}  // namespace

std::string RunPlotScript(const std::string& script, const std::vector<std::string>& arguments) {
  std::vector<std::string> words = {kPython, "-c", script};
  words.insert(words.end(), arguments.begin(), arguments.end());
  try {
    if (RunChild(words) == 0) return "";
    if (HasMatplotlib()) return "no plot: the plot script failed; free space";
    return "no plot: matplotlib is missing; install python3-matplotlib";
  } catch (const MachineError& error) {
    return std::string("no plot: ") + error.what() + "; install python3-matplotlib";
  }
}

}  // namespace hpdm
