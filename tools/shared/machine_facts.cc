#include "tools/shared/machine_facts.h"

#include <fstream>

namespace hpdm {

MachineFacts ThisMachine() {
  MachineFacts facts{"an unnamed processor", HPDM_COMPILER, HPDM_FLAGS, 0};
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(": ");
    if (!line.starts_with("model name") || colon == std::string::npos) continue;
    facts.processor = line.substr(colon + 2);
    break;
  }
  std::ifstream("/proc/loadavg") >> facts.load;
  return facts;
}

}  // namespace hpdm
