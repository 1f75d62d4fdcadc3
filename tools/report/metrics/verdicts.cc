#include "tools/report/metrics/verdicts.h"

#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

/// Returns why the log does not show whether a hand stayed below the limit; empty if it does.
std::string WhyOpen(const SessionReport& report, const ContactMetrics& contact) {
  if (report.health.ticks_lost + report.health.outputs_lost > 0) {
    return "forces are missing in the log";
  }
  if (contact.forces_off > 0) {
    return Format("forces were off for %.2f s of its contacts", contact.forces_off);
  }
  if (contact.clamped > 0) {
    return Format("the tissue's force exceeded the device's limit for %.2f s", contact.clamped);
  }
  return "";
}

Verdict OfForces(const SessionReport& report, const HandReport& hand) {
  const ContactMetrics& contact = hand.contact;
  const std::string who = hand.Label() + ": ", limit = LimitText(report.force_limit);
  if (contact.over_limit_count > 0) {
    return {Verdict::kBad,
            who + Format("above the force limit of %s %llu %s, %.2f s in all (peak %.2f N)",
                         limit.c_str(), static_cast<unsigned long long>(contact.over_limit_count),
                         contact.over_limit_count == 1 ? "time" : "times", contact.over_limit,
                         contact.peak_force)};
  }
  if (const std::string why = WhyOpen(report, contact); !why.empty()) {
    return {Verdict::kOpen,
            who + Format("cannot be compared with the force limit of %s: %s (displayed peak "
                         "%.2f N)",
                         limit.c_str(), why.c_str(), contact.peak_force)};
  }
  return {Verdict::kGood, who + Format("stayed below the force limit of %s (peak %.2f N)",
                                       limit.c_str(), contact.peak_force)};
}

Verdict OfDepth(const SessionReport& report, const HandReport& hand) {
  const ContactMetrics& contact = hand.contact;
  const std::string who = hand.Label() + ": ", limit = DepthLimitText(report.depth_limit);
  const double deepest = 1000 * contact.deepest_press;
  if (contact.over_depth_count > 0) {
    return {Verdict::kBad,
            who + Format("deeper than the depth limit of %s %llu %s, %.2f s in all (deepest "
                         "%.1f mm)",
                         limit.c_str(), static_cast<unsigned long long>(contact.over_depth_count),
                         contact.over_depth_count == 1 ? "time" : "times", contact.over_depth,
                         deepest)};
  }
  if (report.health.ticks_lost + report.health.outputs_lost > 0) {
    return {Verdict::kOpen, who + Format("cannot be compared with the depth limit of %s: depths "
                                         "are missing in the log (deepest known %.1f mm)",
                                         limit.c_str(), deepest)};
  }
  if (hand.depth_unknown > 0) {
    return {Verdict::kOpen,
            who + Format("cannot be compared with the depth limit of %s: its tissue jumped "
                         "for %.2f s of its contacts (deepest known %.1f mm)",
                         limit.c_str(), hand.depth_unknown, deepest)};
  }
  return {Verdict::kGood, who + Format("stayed within the depth limit of %s (deepest %.1f mm)",
                                       limit.c_str(), deepest)};
}

}  // namespace

std::string LimitText(double limit) { return Format("%.3g N", limit); }
std::string DepthLimitText(double limit) { return Format("%.3g mm", 1000 * limit); }

std::vector<Verdict> Verdicts(const SessionReport& report) {
  std::vector<Verdict> verdicts;
  for (const HandReport& hand : report.hands) {
    verdicts.push_back(OfForces(report, hand));
    verdicts.push_back(OfDepth(report, hand));
  }
  if (report.health.Sound()) {
    verdicts.push_back({Verdict::kGood, "the log is complete and sound"});
  } else {
    for (const std::string& fault : report.health.Faults()) {
      verdicts.push_back({Verdict::kBad, fault});
    }
  }
  return verdicts;
}

}  // namespace hpdm
