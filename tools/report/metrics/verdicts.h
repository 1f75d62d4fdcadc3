#pragma once

#include <string>
#include <vector>

#include "tools/report/metrics/session_metrics.h"

namespace hpdm {

/// A line at the head of a report.
struct Verdict {
  enum Kind { kGood, kBad, kOpen };  ///< Open: the log does not decide it.
  Kind kind;
  std::string text;  ///< Plain, not HTML.
};

/// Judges each hand's forces and depth, then the log. A hand counts as below the force limit only
/// if all its forces are known: none were switched off, exceeded the device's limit, or are missing
/// in the log. It counts as within the depth limit only if no tick is missing.
std::vector<Verdict> Verdicts(const SessionReport& report);

/// Formats a force limit for people: "3 N".
std::string LimitText(double limit);
/// Formats a depth limit (m) for people: "20 mm".
std::string DepthLimitText(double limit);

}  // namespace hpdm
