#include "tools/report/metrics/goals.h"

#include <algorithm>
#include <cmath>
#include <string_view>

namespace hpdm {
namespace {

constexpr GoalsScale kScales[] = {
    {"overshoot_share", "Advances that overshot", "%", 100, 0.5, 0.05},
    {"together_share", "Two hands work, of the time in which one moves", "%", 100, 0.1, 0.6},
    {"economy_of_motion", "Economy of motion of all hands", "%", 100, 0.3, 0.8},
    {"still_share", "No hand moves, of the time", "%", 100, 0.7, 0.2},
    {"time_share", "Time used between target and limit", "%", 100, 1, 0},
    {"peak_share", "Peak force, of the limit", "%", 100, 2, 0.8},
    {"over_limit_share", "Above the force limit, of the contact time", "%", 100, 0.1, 0},
    {"slips_per_s", "Slips in the jaws, per minute of contact", "", 60, 4.0 / 60, 0},
    {"torn_area_m2", "Torn area", "mm\u00b2", 1e6, 1e-4, 0},
    {"harm_count", "Errors that harm tissue", "", 1, 4, 0},
};

void Add(std::string_view key, double value, GoalsDomain* domain) {
  const auto* scale = std::ranges::find(kScales, key, &GoalsScale::key);
  const double share = (value - scale->worst) / (scale->best - scale->worst);
  domain->parts.push_back({scale->key, scale, value, 1 + 4 * std::clamp(share, 0.0, 1.0)});
}

double InTenths(double rating) { return std::round(10 * rating) / 10; }

void RateMean(GoalsDomain* domain) {
  double sum = 0;
  for (const GoalsPart& part : domain->parts) sum += part.rating;
  domain->rating = InTenths(sum / static_cast<double>(domain->parts.size()));
}

GoalsDomain DepthPerception(const SessionReport& report) {
  GoalsDomain domain{"depth_perception", "Depth perception", "as its figure"};
  double advances = 0, overshoots = 0;
  for (const HandReport& hand : report.hands) {
    advances += static_cast<double>(hand.motion.advances);
    overshoots += static_cast<double>(hand.motion.overshoots);
  }
  if (advances < kFewestAdvances) {
    domain.why_not = "fewer than 5 advances along the shaft";
    return domain;
  }
  Add("overshoot_share", overshoots / advances, &domain);
  RateMean(&domain);
  return domain;
}

GoalsDomain BimanualDexterity(const SessionReport& report) {
  GoalsDomain domain{"bimanual_dexterity", "Bimanual dexterity", "as its figure"};
  if (!report.work) {
    domain.why_not = "the scene has one hand";
  } else if (report.work->any_moves <= 0) {
    domain.why_not = "no hand moved";
  } else {
    Add("together_share", report.work->together / report.work->any_moves, &domain);
    RateMean(&domain);
  }
  return domain;
}

GoalsDomain Efficiency(const SessionReport& report) {
  GoalsDomain domain{"efficiency", "Efficiency", "the mean of its figures"};
  double path = 0, economy = 0, moving = 0;
  for (const HandReport& hand : report.hands) {
    moving = std::max(moving, hand.motion.time - hand.motion.idle);
    if (!hand.motion.economy) continue;
    path += hand.motion.path_length;
    economy += *hand.motion.economy * hand.motion.path_length;
  }
  if (path <= 0 || report.active <= 0) {
    domain.why_not = "no hand moved";
    return domain;
  }
  if (report.work) moving = report.work->any_moves;
  Add("economy_of_motion", economy / path, &domain);
  Add("still_share", 1 - std::min(1.0, moving / report.active), &domain);
  if (report.exercise && report.exercise->result.ended) {
    const ExerciseOptions& options = report.exercise->options;
    const ExerciseResult& result = report.exercise->result;
    const double late = (result.time - options.target_time) /
                        std::max(1e-9, options.time_limit - options.target_time);
    Add("time_share", result.passed ? std::clamp(late, 0.0, 1.0) : 1, &domain);
  }
  RateMean(&domain);
  return domain;
}

bool Harms(ExerciseErrorKind kind) {
  return kind == ExerciseErrorKind::kForce || kind == ExerciseErrorKind::kTear ||
         kind == ExerciseErrorKind::kBurn || kind == ExerciseErrorKind::kDrop ||
         kind == ExerciseErrorKind::kInverted || kind == ExerciseErrorKind::kPerforation ||
         kind == ExerciseErrorKind::kStretch || kind == ExerciseErrorKind::kWrongCut;
}

GoalsDomain TissueHandling(const SessionReport& report) {
  GoalsDomain domain{"tissue_handling", "Tissue handling", "the lowest of its figures"};
  double contact = 0, off = 0, over = 0, peak = 0, slips = 0, torn = 0;
  for (const HandReport& hand : report.hands) {
    contact += hand.contact.time;
    off += hand.contact.forces_off;
    over += hand.contact.over_limit;
    peak = std::max(peak, hand.contact.peak_force);
    slips += static_cast<double>(hand.contact.slips);
  }
  for (const AttachmentReport& layer : report.attachments) {
    torn += std::max(0.0, layer.freed_area - layer.burnt_area - layer.cut_area);
  }
  if (contact < kLeastContact) {
    domain.why_not = "tissue was touched for less than a second";
  } else if (off > 0) {
    domain.why_not = "forces were off in some contacts";
  } else if (report.health.ticks_lost + report.health.outputs_lost > 0) {
    domain.why_not = "forces are missing in the log";
  }
  if (!domain.why_not.empty()) return domain;
  Add("peak_share", peak / report.force_limit, &domain);
  Add("over_limit_share", over / contact, &domain);
  Add("slips_per_s", slips / contact, &domain);
  if (!report.attachments.empty()) Add("torn_area_m2", torn, &domain);
  if (report.exercise) {
    const auto harms = std::ranges::count_if(
        report.exercise->result.errors, [&report](const ExerciseError& error) {
          return Harms(report.exercise->options.errors[static_cast<std::size_t>(error.rule)].kind);
        });
    Add("harm_count", static_cast<double>(harms), &domain);
  }
  domain.rating = InTenths(std::ranges::min(domain.parts, {}, &GoalsPart::rating).rating);
  return domain;
}

}  // namespace

std::span<const GoalsScale> GoalsScales() { return kScales; }

std::vector<GoalsDomain> RateGoals(const SessionReport& report) {
  GoalsDomain autonomy{"autonomy", "Autonomy", ""};
  autonomy.why_not =
      "it is about help: the screen names each step, and the log does not hold what was said";
  return {DepthPerception(report), BimanualDexterity(report), Efficiency(report),
          TissueHandling(report), autonomy};
}

}  // namespace hpdm
