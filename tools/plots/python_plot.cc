#include "tools/plots/python_plot.h"

#include "engine/base/error.h"
#include "tools/shared/child_process.h"

namespace hpdm {

std::string RunPlotScript(const std::string& script, const std::vector<std::string>& arguments) {
  // Debian's own interpreter: another one on the path would lack Debian's matplotlib.
  std::vector<std::string> words = {"/usr/bin/python3", "-c", script};
  words.insert(words.end(), arguments.begin(), arguments.end());
  try {
    if (RunChild(words) == 0) return "";
  } catch (const MachineError& error) {
    return std::string("no plot: ") + error.what() + "; install python3-matplotlib";
  }
  return "no plot: the plot script failed; install python3-matplotlib, or free space";
}

}  // namespace hpdm
