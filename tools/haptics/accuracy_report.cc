#include "tools/haptics/accuracy_report.h"

#include <cmath>

#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

// Formats a share in percent; "-" for NaN.
std::string Percent(double share) {
  return std::isnan(share) ? "-" : Format(share < 0.0995 ? "%.2f" : "%.1f", 100 * share);
}

Json ToJson(const HandAccuracy& hand) {
  const ForceResults& f = hand.results;
  return {{"case", hand.case_name},
          {"instrument", f.instrument},
          {"peak_N", f.peak},
          {"independent_error", f.independent_error},
          {"independent_target", hand.Target()},
          {"independent_ticks", f.independent_ticks},
          {"independent_missed_ticks", f.independent_missed},
          {"independent_false_ticks", f.independent_false},
          {"error", f.error},
          {"magnitude_error", f.magnitude_error},
          {"comb", std::isnan(f.comb) ? Json(nullptr) : Json(f.comb)},
          {"largest_step_N", f.largest_step},
          {"reference_largest_step_N", f.reference_largest_step},
          {"contact_ticks", f.contact_ticks},
          {"missed_ticks", f.missed_ticks},
          {"false_ticks", f.false_ticks},
          {"shaft_ticks", f.shaft_ticks},
          {"reference_tick_error", f.tick_error},
          {"reference_largest_tick_error", f.largest_tick_error},
          {"paper_error", f.paper_error},
          {"paper_fitted_error", f.paper_fitted_error},
          {"paper_fitted_k1_N_per_m", f.paper_fitted_k1},
          {"paper_fitted_k2_N_per_m", f.paper_fitted_k2},
          {"time_series", hand.series},
          {"course", hand.series}};  // deprecated: time_series
}

Json ToJson(const TipAccuracy& tip) {
  return {{"case", tip.case_name},
          {"local_functions", tip.local_functions},
          {"reference_force_N", tip.reference_force},
          {"yardstick_force_N", tip.reference_force},  // deprecated: reference_force_N
          {"force_N", tip.force},
          {"force_ratio", tip.force / tip.reference_force}};
}

}  // namespace

double HandAccuracy::Target() const {
  const bool grasps =
      results.script == HandScript::kGraspPull || results.script == HandScript::kGraspLift;
  return grasps ? kGraspTarget : kPressTarget;
}

std::string TimeSeriesTable(const ForceTimeSeries& series, double rate_hz) {
  std::string table =
      "t,production_N,reference_N,reference_tick_N,paper_N,paper_fitted_N,independent_N,"
      "production_x,"
      "production_y,production_z,reference_x,reference_y,reference_z,depth\n";
  for (std::size_t t = 0; t < series.production.size(); ++t) {
    const Vector3d& p = series.production[t];
    const Vector3d& r = series.reference[t];
    const std::size_t judged = t / series.judged_every;
    const bool is_judged = t % series.judged_every == 0 && judged < series.independent.size();
    table += Format("%.4f,%.6g,%.6g,%.6g,%.6g,%.6g,%s,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g\n",
                    static_cast<double>(t) / rate_hz, p.norm(), r.norm(),
                    series.reference_tick[t].norm(), series.paper[t].norm(),
                    series.paper_fitted[t].norm(),
                    is_judged ? Format("%.6g", series.independent[judged].norm()).c_str() : "",
                    p.x(), p.y(), p.z(), r.x(), r.y(), r.z(), series.depth[t]);
  }
  return table;
}

Json AccuracyJson(const std::vector<HandAccuracy>& hands, const std::vector<TipAccuracy>& tips) {
  Json report = {
      {"targets",
       {{"press_error", kPressTarget}, {"grasp_error", kGraspTarget}, {"comb", kCombTarget}}},
      {"hands", Json::array()},
      {"tips", Json::array()}};
  for (const HandAccuracy& hand : hands) report["hands"].push_back(ToJson(hand));
  for (const TipAccuracy& tip : tips) report["tips"].push_back(ToJson(tip));
  return report;
}

std::string AccuracyHead() {
  return Format(
             "Force on the hand against the contact found on the solved organs; loops: against the "
             "loops with a step at every tick. Errors: %% of the reference's peak, target %.0f, of "
             "a grasp %.0f. Comb: %% of the force, target %.0f.\n",
             100 * kPressTarget, 100 * kGraspTarget, 100 * kCombTarget) +
         Format("%-24s %-8s %7s %6s %6s %6s %6s %8s %8s %7s %6s %6s %6s %8s %6s %6s %5s %5s\n",
                "case", "tool", "peak N", "error", "loops", "of |F|", "comb", "step N", "(ref.)",
                "contact", "missed", "false", "shaft", "ref.tick", "paper", "fitted", "k1", "k2");
}

std::string AccuracyRow(const HandAccuracy& hand) {
  const ForceResults& f = hand.results;
  return Format(
      "%-24s %-8s %7.3f %6s %6s %6s %6s %8.4f %8.4f %7d %6d %6d %6d %8.1e %6s %6s %5.1f %5.1f\n",
      hand.case_name.c_str(), f.instrument.c_str(), f.peak, Percent(f.independent_error).c_str(),
      Percent(f.error).c_str(), Percent(f.magnitude_error).c_str(), Percent(f.comb).c_str(),
      f.largest_step, f.reference_largest_step, f.contact_ticks, f.missed_ticks, f.false_ticks,
      f.shaft_ticks, f.largest_tick_error, Percent(f.paper_error).c_str(),
      Percent(f.paper_fitted_error).c_str(), f.paper_fitted_k1, f.paper_fitted_k2);
}

std::string AccuracyTips(const std::vector<TipAccuracy>& tips) {
  std::string text;
  for (const TipAccuracy& tip : tips) {
    text += Format(
        "%s, %d local functions: the force for the reference solution's displacement is %.3f of "
        "its %.3g N\n",
        tip.case_name.c_str(), tip.local_functions, tip.force / tip.reference_force,
        tip.reference_force);
  }
  return text;
}

std::string AccuracyMarkdown(const std::vector<HandAccuracy>& hands,
                             const std::vector<TipAccuracy>& tips) {
  std::string text =
      "| hand | peak | error against the contact found on the solved organ (target) | error "
      "against "
      "the loops with a step at every tick | comb, at most 1 % | largest step in a tick (the whole "
      "model's) | the paper's Eq. 29, k1 and k2 fitted (default) "
      "|\n|---|---|---|---|---|---|---|\n";
  for (const HandAccuracy& hand : hands) {
    const ForceResults& f = hand.results;
    const bool fails = f.independent_error > hand.Target();
    text += Format(
        "| `%s`, %s | %.2f N | %s%s %%%s (%.0f) | %s %% | %s | %.3f N (%.3f) | %s %% (%s "
        "%%) |\n",
        hand.case_name.c_str(), f.instrument.c_str(), f.peak, fails ? "**" : "",
        Percent(f.independent_error).c_str(), fails ? "**" : "", 100 * hand.Target(),
        Percent(f.error).c_str(), std::isnan(f.comb) ? "-" : (Percent(f.comb) + " %").c_str(),
        f.largest_step, f.reference_largest_step, Percent(f.paper_fitted_error).c_str(),
        Percent(f.paper_error).c_str());
  }
  if (tips.empty()) return text;
  text +=
      "\n| tip case | local functions | force for the reference solution's displacement over its "
      "force |\n|---|---|---|\n";
  for (const TipAccuracy& tip : tips) {
    text += Format("| `%s` | %d | %.3f |\n", tip.case_name.c_str(), tip.local_functions,
                   tip.force / tip.reference_force);
  }
  return text;
}

}  // namespace hpdm
