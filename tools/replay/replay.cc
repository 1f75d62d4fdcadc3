#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/error.h"
#include "tools/command_line.h"
#include "tools/commands.h"
#include "tools/replay/log_replay.h"
#include "tools/replay/realtime_replay.h"
#include "tools/session/device_choice.h"
#include "tools/session/lockstep.h"
#include "tools/session/session_path.h"
#include "tools/session/session_scene.h"
#include "tools/shared/json_text.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

struct ReplayOptions {
  std::string log;
  std::string scene;  // empty: beside the log
  std::string clock = "logged";
  double tolerance = 1e-9;
  bool json = false;
};

Scene SceneOf(const ReplayOptions& options, const std::string& log) {
  if (!options.scene.empty()) return LoadScene(options.scene);
  const fs::path beside = SceneBeside(log);
  std::error_code ignored;
  if (!fs::exists(beside, ignored)) {
    throw InputError(log + ": no scene.toml beside it; give the log's scene with --scene SCENE");
  }
  try {
    return LoadRecordedScene(beside);
  } catch (const InputError& error) {
    throw InputError(std::string(error.what()) + "; or give the log's own scene with --scene");
  }
}

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

Json Report(const LoggedSession& log, const Session& session, const LogReplay& replay) {
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

std::string ForceLines(const Json& report) {
  std::string text;
  for (const Json& force : report["forces"]) {
    text += Format("%s: force difference %.3g N (RMS), at most %.3g N; logged peak %.3g N\n",
                   force["name"].get<std::string>().c_str(), force["rms_N"].get<double>(),
                   force["peak_N"].get<double>(), force["logged_peak_N"].get<double>());
  }
  return text;
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
    text += Format("%llu ticks were not compared: their output is missing in the log\n",
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

Json CountToJson(const TickCount& ticks) {
  return {{"run", ticks.ticks},
          {"skipped",
           {{"total", ticks.skipped.Total()},
            {"late_wake_up", ticks.skipped.late_wake_up},
            {"long_compute", ticks.skipped.long_compute},
            {"stalled", ticks.skipped.stalled}}}};
}

Json FeltToJson(const Session& session, const SessionSummary& summary) {
  Json tools = Json::array();
  for (int t = 0; t < summary.tool_count; ++t) {
    const ToolSummary& tool = summary.tools[t];
    tools.push_back({{"name", session.scene().instruments[t].name},
                     {"peak_force_N", tool.peak_force},
                     {"mean_force_N", tool.mean_force},
                     {"contact_time_s", tool.contact_time},
                     {"deepest_press_m", tool.deepest_press}});
  }
  return tools;
}

// Reports a recording that ran in real time. A log has forces to compare with; a trace has none.
Json Report(const std::string& recording, const Session& session, const RealtimeReplay& replay,
            bool of_log) {
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

void Print(const ReplayOptions& options, const Json& report, const std::string& text) {
  std::cout << (options.json ? JsonText(report) + "\n" : text);
}

// Plays a trace on the lockstep clock, without log and pictures.
Json PlayInLockstep(const std::string& trace, std::uint64_t ticks, Session* session) {
  HapticLoop haptics(session->HapticInstruments(), session->haptic_period_ns(),
                     {session->tool_states, session->patches, session->samples});
  DeformationLoop deformation(session->organs(), session->DeformationTools(),
                              {session->tool_states, session->patches, *session->render_scenes,
                               *session->telemetry_scenes});
  Lockstep clock(session->scene().timing, &haptics, &deformation);
  SessionStatistics statistics(session->haptic_period_ns());
  std::uint64_t steps = 0;
  session->EnableForces(true);
  while (clock.tick() < ticks) {
    steps += clock.StepIfDue();
    clock.Tick();
    HapticSample sample;
    session->samples.Pop(&sample);
    statistics.Add(sample);
  }
  return {{"trace", trace},      {"scene", session->scene().path.string()},
          {"clock", "lockstep"}, {"ticks", ticks},
          {"steps", steps},      {"tools", FeltToJson(*session, statistics.Summary())}};
}

// Plays a recorded motion (haptics/device/trace_file.h) on a scene.
void ReplayTrace(const ReplayOptions& options) {
  if (options.scene.empty()) {
    throw InputError(options.log + ": a motion needs a scene; add --scene SCENE");
  }
  const Scene scene = LoadScene(options.scene);
  Session session(scene, ChooseDevices({"trace:" + options.log}, scene.instruments));
  for (const std::string& remark : session.remarks())
    std::cerr << "hpdm: note: " << OneLine(remark) << "\n";
  const auto ticks =
      static_cast<std::uint64_t>(session.trace_length() / session.haptic_period_ns()) + 1;
  if (options.clock == "real") {
    const Json report = Report(options.log, session, PlayInRealTime(ticks, &session), false);
    return Print(options, report, RealtimeText(report));
  }
  const Json report = PlayInLockstep(options.log, ticks, &session);
  Print(options, report,
        Format("%ld ticks and %ld deformation steps in lockstep\n", report["ticks"].get<long>(),
               report["steps"].get<long>()) +
            ToolLines(report));
}

void ReplaySession(const ReplayOptions& options) {
  const LoggedSession log(LogPathOf(options.log));
  Scene scene = SceneOf(options, log.path());
  // The session's own devices are not used: the log has their samples.
  std::vector<DeviceChoice> devices(scene.instruments.size());
  Session session(std::move(scene), std::move(devices));
  if (options.clock == "real") {
    const Json report = Report(log.path(), session, ReplayInRealTime(log, &session), true);
    return Print(options, report, RealtimeText(report));
  }
  const LogReplay replay = ReplayLog(log, options.tolerance, &session);
  if (replay.ticks_compared == 0) {
    const std::string why =
        replay.ended_early.empty() ? "no tick has an output that can be read" : replay.ended_early;
    throw InputError(log.path() + ": nothing to compare (" + why +
                     "); give a log of this version that contains the session's beginning");
  }
  const Json report = Report(log, session, replay);
  Print(options, report, ReplayText(log, replay, report));
  if (replay.comparison.first_beyond()) throw CheckFailed();
}

void Replay(const ReplayOptions& options) {
  fs::path(options.log).extension() == ".csv" ? ReplayTrace(options) : ReplaySession(options);
}

}  // namespace

void AddReplayCommand(Command app) {
  auto options = std::make_shared<ReplayOptions>();
  Command replay =
      app.AddCommand("replay", "Recompute a session and compare, or play a recorded motion");
  replay
      .AddOption("log", options->log,
                 "Session folder, its session.lcmlog, or a recorded motion (CSV)")
      .Required();
  replay.AddOption("--scene", options->scene, "Scene file [for a log: scene.toml beside it]");
  replay
      .AddOption("--tolerance", options->tolerance,
                 "Largest difference allowed, relative to the field's largest value in the log; 0: "
                 "equal bit for bit")
      .From(0.0, 1.0)
      .ShowDefault();
  replay
      .AddOption("--clock", options->clock,
                 "logged: repeat every tick, step and patch of the log; real: run in real time and "
                 "report latencies")
      .OneOf({"logged", "real"})
      .ShowDefault();
  replay.AddFlag("--json", options->json, "Print the report as JSON");
  replay.OnRun([options] { Replay(*options); });
}

}  // namespace hpdm
