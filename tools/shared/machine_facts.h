#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tools/shared/report_text.h"

namespace hpdm {

/// The properties of the machine that times depend on. All measurements are single-threaded.
struct MachineFacts {
  std::string processor;
  std::string compiler;
  std::string flags;
  double load = 0;  ///< Mean number of running threads in the minute before.
};

/// Returns the facts of this machine. Call before measuring, because measurements add to the load.
MachineFacts ThisMachine();

inline nlohmann::ordered_json ToJson(const MachineFacts& facts) {
  return {{"processor", facts.processor},
          {"compiler", facts.compiler},
          {"flags", facts.flags},
          {"load_before", facts.load},
          {"threads", 1}};
}

/// Returns one line for the foot of a table.
inline std::string ToText(const MachineFacts& facts) {
  return "one core of " + facts.processor + ", " + facts.compiler + " " + facts.flags +
         Format(", load %.2g before", facts.load);
}

}  // namespace hpdm
