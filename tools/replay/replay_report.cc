#include "tools/replay/replay_report.h"

#include <array>
#include <optional>

#include "tools/shared/json_text.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

Json ForcesToJson(const Session& session, const std::array<ForceDifference, kMaxInstruments>& all) {
  Json forces = Json::array();
  for (std::size_t t = 0; t < session.scene().instruments.size(); ++t) {
    forces.push_back({{"name", session.scene().instruments[t].name},
                      {"rms_N", all[t].rms},
                      {"peak_N", all[t].peak},
                      {"logged_peak_N", all[t].logged_peak}});
  }
  return forces;
}

Json ToJson(const std::optional<FieldDifference>& difference) {
  if (!difference) return nullptr;
  Json json = {{difference->in_step ? "step" : "tick", difference->number}};
  if (difference->tool >= 0) json["tool"] = difference->tool;
  json["field"] = difference->field;
  json["logged"] = difference->logged;
  json["replayed"] = difference->replayed;
  json["relative"] = difference->relative;  // null where infinite
  return json;
}

std::string Line(const FieldDifference& difference) {
  std::string where = (difference.in_step ? "step " : "tick ") + std::to_string(difference.number);
  if (difference.tool >= 0) where += ", tool " + std::to_string(difference.tool);
  return where + ", " + difference.field + ": logged " + difference.logged + ", replayed " +
         difference.replayed;
}

const char* Verdict(const FieldComparison& comparison) {
  if (comparison.first_beyond()) return "differs";
  return comparison.first() ? "within_tolerance" : "identical";
}

std::string ForceLines(const Json& report) {
  std::string text;
  for (const Json& force : report["forces"]) {
    text += Format("%s: force difference %.3g N (RMS), at most %.3g N; logged peak %.3g N\n",
                   force["name"].get<std::string>().c_str(), force["rms_N"].get<double>(),
                   force["peak_N"].get<double>(), force["logged_peak_N"].get<double>());
  }
  return text;
}

Json CountToJson(const TickCount& ticks) {
  return {{"run", ticks.ticks},
          {"skipped",
           {{"total", ticks.skipped.Total()},
            {"late_wake_up", ticks.skipped.late_wake_up},
            {"long_compute", ticks.skipped.long_compute},
            {"stalled", ticks.skipped.stalled}}}};
}

}  // namespace

Json LogReplayReport(const LoggedSession& log, const Session& session, const LogReplay& replay) {
  const FieldComparison& comparison = replay.comparison;
  return {{"log", log.path()},
          {"scene", session.scene().path.string()},
          {"clock", "logged"},
          {"result", Verdict(comparison)},
          {"tolerance", comparison.tolerance()},
          {"ticks",
           {{"logged", replay.ticks_logged},
            {"compared", replay.ticks_compared},
            {"without_output", replay.ticks_without_output},
            {"lost", replay.ticks_lost}}},
          {"steps",
           {{"logged", replay.steps_logged},
            {"compared", replay.steps_compared},
            {"behind_a_missing_one", log.steps_unusable()}}},
          {"first_difference", ToJson(comparison.first())},
          {"first_beyond_tolerance", ToJson(comparison.first_beyond())},
          {"largest_difference", ToJson(comparison.largest())},
          {"ended_early", replay.ended_early},
          {"log_closed", log.closed()},
          {"damage",
           {{"segments", log.damaged_stretches()},
            {"stretches", log.damaged_stretches()},  // deprecated: segments
            {"bytes", log.damaged_bytes()}}},
          {"forces", ForcesToJson(session, replay.forces)},
          {"compute", ToJson(replay.tick_compute)}};
}

std::string ReplayText(const LoggedSession& log, const LogReplay& replay, const Json& report) {
  std::string text =
      Format("replayed %s of %s ticks and %s of %s steps",
             WithCommas(static_cast<long long>(replay.ticks_compared + replay.ticks_without_output))
                 .c_str(),
             WithCommas(static_cast<long long>(replay.ticks_logged)).c_str(),
             WithCommas(static_cast<long long>(replay.steps_compared)).c_str(),
             WithCommas(static_cast<long long>(replay.steps_logged)).c_str());
  const FieldComparison& comparison = replay.comparison;
  if (comparison.first_beyond()) {
    text += Format(": beyond %g of the log's largest values\n", comparison.tolerance()) +
            "first difference beyond it: " + Line(*comparison.first_beyond()) + "\n";
  } else if (comparison.first()) {
    text += Format(": within %g of the log's largest values, at most %.2g\n",
                   comparison.tolerance(), comparison.largest()->relative) +
            "first difference: " + Line(*comparison.first()) + "\n";
  } else {
    text += ": the same bit for bit\n";
  }
  if (!replay.ended_early.empty()) text += "ended early: " + replay.ended_early + "\n";
  if (replay.ticks_lost > 0) {
    text += Format("%llu ticks of the session are not in the log\n",
                   static_cast<unsigned long long>(replay.ticks_lost));
  }
  if (replay.ticks_without_output > 0) {
    text += Format("%llu ticks were not compared: their output is not in the log\n",
                   static_cast<unsigned long long>(replay.ticks_without_output));
  }
  if (log.damaged_stretches() > 0) {
    text += Format("damaged log: skipped %llu bytes in %llu places\n",
                   static_cast<unsigned long long>(log.damaged_bytes()),
                   static_cast<unsigned long long>(log.damaged_stretches()));
  }
  if (!log.closed()) text += "the log's end is missing: the session was cut off\n";
  text += ForceLines(report);
  text += Format("tick: p50 %.1f us, p99 %.1f us\n", report["compute"]["p50_us"].get<double>(),
                 report["compute"]["p99_us"].get<double>());
  return text;
}

Json FeltToJson(const Session& session, const SessionSummary& summary) {
  Json tools = Json::array();
  for (int t = 0; t < summary.tool_count; ++t) {
    const ToolSummary& tool = summary.tools[t];
    tools.push_back({{"name", session.scene().instruments[t].name},
                     {"peak_force_N", tool.peak_force},
                     {"mean_force_N", tool.mean_force},
                     {"contact_time_s", tool.contact_time},
                     {"deepest_press_m", tool.deepest_press},
                     {"slips", tool.slips}});
  }
  return tools;
}

Json RealtimeReplayReport(const std::string& recording, const Session& session,
                          const RealtimeReplay& replay, bool of_log) {
  Json realtime = Json::object();
  for (const auto& [thread, report] : replay.realtime) realtime[thread] = report.Lines();
  Json report = {{of_log ? "log" : "trace", recording},
                 {"scene", session.scene().path.string()},
                 {"clock", "real"},
                 {"ticks", CountToJson(replay.haptic)},
                 {"steps", CountToJson(replay.deformation)},
                 {"latency",
                  {{"wake_up", ToJson(replay.session.latencies[Latency::kHapticWakeUp])},
                   {"compute", ToJson(replay.session.latencies[Latency::kHapticCompute])},
                   {"period", ToJson(replay.session.latencies[Latency::kHapticPeriod])},
                   {"patch_age", ToJson(replay.session.latencies[Latency::kPatchAge])}}},
                 {"not_measured", replay.overflows},
                 {"tools", FeltToJson(session, replay.session)}};
  if (of_log) {
    report["compared"] = replay.compared;
    report["forces"] = ForcesToJson(session, replay.forces);
  }
  report["realtime"] = realtime;
  return report;
}

std::string ToolLines(const Json& report) {
  std::string text;
  for (const Json& tool : report["tools"]) {
    text += Format("%s: peak force %.3g N, mean %.3g N over %.1f s of contact\n",
                   tool["name"].get<std::string>().c_str(), tool["peak_force_N"].get<double>(),
                   tool["mean_force_N"].get<double>(), tool["contact_time_s"].get<double>());
  }
  return text;
}

std::string RealtimeText(const Json& report) {
  const Json& ticks = report["ticks"];
  std::string text = Format("%ld ticks in real time, %ld skipped; %ld deformation steps\n",
                            ticks["run"].get<long>(), ticks["skipped"]["total"].get<long>(),
                            report["steps"]["run"].get<long>());
  for (const auto& [name, latency] : report["latency"].items()) {
    text += Format("%-10s p50 %10.1f   p99 %10.1f   p99.9 %10.1f   max %10.1f us\n", name.c_str(),
                   latency["p50_us"].get<double>(), latency["p99_us"].get<double>(),
                   latency["p99_9_us"].get<double>(), latency["max_us"].get<double>());
  }
  text += ToolLines(report);
  if (report.contains("forces")) text += ForceLines(report);
  for (const auto& [thread, lines] : report["realtime"].items()) {
    for (const Json& line : lines) text += thread + ": " + line.get<std::string>() + "\n";
  }
  return text;
}

}  // namespace hpdm
