#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tools/shared/report_text.h"

namespace hpdm {

/// What times depend on besides the program. All measurements are single-threaded.
struct MachineFacts {
  std::string processor;
  std::string compiler;
  std::string flags;
  double load = 0;  ///< Mean number of running threads in the minute before.
};

/// To be asked before measuring: the measurement is a load itself.
MachineFacts ThisMachine();

inline nlohmann::ordered_json ToJson(const MachineFacts& facts) {
  return {{"processor", facts.processor},
          {"compiler", facts.compiler},
          {"flags", facts.flags},
          {"load_before", facts.load},
          {"threads", 1}};
}

/// One line for the foot of a table.
inline std::string ToText(const MachineFacts& facts) {
  return "one core of " + facts.processor + ", " + facts.compiler + " " + facts.flags +
         Format(", load %.2g before", facts.load);
}

}  // namespace hpdm
