#pragma once

#include <string>
#include <vector>

#include "tools/report/metrics/session_metrics.h"

namespace hpdm {

/// One line at the head of a report.
struct Verdict {
  enum Kind { kGood, kBad, kOpen };  ///< Open: the log cannot tell.
  Kind kind;
  std::string text;  ///< Plain, not HTML.
};

/// Of each hand's forces, then of the log. A hand stayed below the limit only where all its forces
/// are known: where forces were off, beyond the device, or are missing in the log, it may not have.
std::vector<Verdict> Verdicts(const SessionReport& report);

/// A force limit for people: "3 N".
std::string LimitText(double limit);

}  // namespace hpdm
