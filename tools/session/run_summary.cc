#include "tools/session/run_summary.h"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <thread>

#include "engine/base/text_list.h"
#include "tools/shared/json_text.h"
#include "tools/shared/machine_facts.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

Json SkippedToJson(const SkippedTicks& skipped) {
  return {{"total", skipped.Total()},
          {"late_wake_up", skipped.late_wake_up},
          {"long_compute", skipped.long_compute},
          {"stalled", skipped.stalled}};
}

// Adds the latencies of one loop, under their names without the loop's name.
void AddLatencies(std::string_view loop, const Latencies& latencies, Json* json) {
  latencies.ForEach([&](std::size_t index, const Histogram& histogram) {
    const std::string_view name = kLatencyNames[index];
    if (!name.starts_with(loop) || name[loop.size()] != '.') return;
    (*json)[std::string(name.substr(loop.size() + 1))] = ToJson(histogram);
  });
}

Json HapticToJson(const RunRecord& record, const SessionSummary& session) {
  Json haptic = {{"rate_hz", session.haptic_hz},
                 {"ticks", record.haptic.ticks},
                 {"skipped", SkippedToJson(record.haptic.skipped)}};
  AddLatencies("haptic", session.latencies, &haptic);
  return haptic;
}

Json DeformationToJson(const RunRecord& record, const SessionSummary& session) {
  Json deformation = {{"rate_hz", session.deformation_hz},
                      {"steps", record.deformation.ticks},
                      {"steps_shed", session.steps_shed},
                      {"skipped", SkippedToJson(record.deformation.skipped)}};
  AddLatencies("deformation", session.latencies, &deformation);
  return deformation;
}

Json RenderToJson(const RenderLoop& render, const SessionSummary& session, double seconds) {
  const RenderStatistics& statistics = render.statistics();
  Json json = {{"rate_hz", seconds > 0 ? static_cast<double>(statistics.drawn) / seconds : 0},
               {"frames", statistics.drawn},
               {"dropped", statistics.dropped},
               {"frames_written", render.frames_written()}};
  AddLatencies("render", session.latencies, &json);
  json["renderer"] = statistics.renderer;
  json["failure"] = render.failure();
  return json;
}

// The machine's own lateness, to compare the session's lateness with.
Json MachineToJson(const RunRecord& record, const SessionSummary& session) {
  Json machine = {{"skipped", SkippedToJson(record.baseline.count.skipped)}};
  AddLatencies("baseline", session.latencies, &machine);
  machine["stolen_s"] = ToSeconds(session.stolen_ns);
  machine["processors"] = std::thread::hardware_concurrency();
  return machine;
}

Json ToolsToJson(const Session& session, const SessionSummary& summary) {
  Json tools = Json::array();
  for (int t = 0; t < summary.tool_count; ++t) {
    const ToolSummary& tool = summary.tools[t];
    tools.push_back({{"name", session.scene().instruments[t].name},
                     {"device", session.device_choices()[t].Text()},
                     {"peak_force_N", tool.peak_force},
                     {"mean_force_N", tool.mean_force},
                     {"contact_time_s", tool.contact_time},
                     {"deepest_press_m", tool.deepest_press},
                     {"slips", tool.slips}});
  }
  return tools;
}

const char* EndedBy(const RunRecord& record) {
  if (record.ended_by_user) return "user";
  return record.ended_by_exercise ? "exercise" : "length";
}

Json LinkToJson(const DeviceLinkSummary& link) {
  return {{"received", link.received},
          {"refused", link.refused},
          {"sent", link.sent},
          {"send_errors", link.send_errors},
          {"overflows", link.overflows}};
}

Json CommandToJson(const std::vector<std::string>& command_line) {
  const MachineFacts facts = ThisMachine();
  return {{"arguments", command_line},
          {"version", HPDM_VERSION},
          {"processor", facts.processor},
          {"compiler", facts.compiler},
          {"flags", facts.flags}};
}

Json FilesToJson(const std::vector<KeptFile>& files) {
  Json json = Json::array();
  for (const KeptFile& file : files) {
    json.push_back({{"name", file.name}, {"copy", file.copy}, {"sha256", file.sha256}});
  }
  return json;
}

Json RealtimeToJson(const RunRecord& record) {
  Json threads = Json::object();
  for (const auto& [thread, report] : record.realtime) threads[thread] = report.Lines();
  return threads;
}

// A lockstep run measures no time: `timed` is false.
std::string LoopLine(const char* name, const Json& loop, const char* unit_count, bool timed) {
  std::string line =
      Format("%-12s %8.2f Hz  %8ld %-7s %4ld skipped", name, loop["rate_hz"].get<double>(),
             loop[unit_count].get<long>(), unit_count, loop["skipped"]["total"].get<long>());
  if (timed) {
    line += Format("   wake-up p99 %8.1f us   compute p50 %8.1f p99 %8.1f us",
                   loop["wake_up"]["p99_us"].get<double>(), loop["compute"]["p50_us"].get<double>(),
                   loop["compute"]["p99_us"].get<double>());
  }
  return line + "\n";
}

std::string AgeLine(const char* name, const Json& age) {
  return Format("%-16s p50 %9.3f ms, p99 %9.3f ms, p99.9 %9.3f ms, max %9.3f ms\n", name,
                age["p50_us"].get<double>() / 1000, age["p99_us"].get<double>() / 1000,
                age["p99_9_us"].get<double>() / 1000, age["max_us"].get<double>() / 1000);
}

std::string CausesOf(const Json& skipped) {
  return Format(": late wake-up %ld, long computing %ld, CPU steal %ld",
                skipped["late_wake_up"].get<long>(), skipped["long_compute"].get<long>(),
                skipped["stalled"].get<long>());
}

// Returns the word as a shell takes it.
std::string ShellWord(const std::string& word) {
  const auto plain = [](unsigned char c) {
    return std::isalnum(c) != 0 || std::string_view("/._-+=:@,").find(c) != std::string_view::npos;
  };
  if (!word.empty() && std::all_of(word.begin(), word.end(), plain)) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? "'\\''" : std::string(1, c);
  return quoted + "'";
}

// The session's wake-ups beside those of an empty loop, to separate a bad machine from a bad
// program.
std::string MachineLines(const Json& summary) {
  const Json& machine = summary["machine"];
  std::string text;
  for (const auto& [name, wake_up] : {std::pair{"session", summary["haptic"]["wake_up"]},
                                      std::pair{"empty loop", machine["wake_up"]}}) {
    text +=
        Format("wake-up late by  p50 %9.1f us, p99 %9.1f us, p99.9 %9.1f us, max %9.1f us (%s)\n",
               wake_up["p50_us"].get<double>(), wake_up["p99_us"].get<double>(),
               wake_up["p99_9_us"].get<double>(), wake_up["max_us"].get<double>(), name);
  }
  const double stolen = machine["stolen_s"].get<double>();
  if (stolen > 0) {
    text +=
        Format("CPU steal: %.2f s over %d processors\n", stolen, machine["processors"].get<int>());
  }
  return text;
}

// Peak force and depth of one instrument, and which of them is above its limit.
std::string PeakOf(const Json& tool, const HandlingLimits& limits) {
  const std::string name = tool["name"];
  if (tool["contact_time_s"].get<double>() <= 0) return name + " touched nothing";
  const double force = tool["peak_force_N"].get<double>();
  const double depth = tool["deepest_press_m"].get<double>();
  std::string text = name + Format(" %.2f N", force);
  if (force > limits.force) text += Format(" (above the limit of %.3g N)", limits.force);
  text += Format(", %.1f mm deep", 1000 * depth);
  if (depth > limits.depth) text += Format(" (above the limit of %.3g mm)", 1000 * limits.depth);
  return text;
}

}  // namespace

Json RunSummary(const Session& session, const RunRecord& record, const TelemetrySummary& telemetry,
                const RenderLoop* render, const std::vector<std::string>& command_line,
                const SessionFolder& folder) {
  const SessionSummary& results = telemetry.session;
  const double seconds =
      static_cast<double>(record.haptic.Periods()) * ToSeconds(session.haptic_period_ns());
  Json summary = {{"scene", session.scene().name},
                  {"clock", record.lockstep ? "lockstep" : "real"},
                  {"seconds", seconds},
                  {"ended_by", EndedBy(record)},
                  {"interrupted", record.ended_by_user},  // deprecated
                  {"haptic", HapticToJson(record, results)},
                  {"deformation", DeformationToJson(record, results)}};
  if (render != nullptr) summary["render"] = RenderToJson(*render, results, seconds);
  summary["tools"] = ToolsToJson(session, results);
  summary["log"] = {{"events", telemetry.log.events},
                    {"dropped", telemetry.log.dropped},
                    {"bytes", telemetry.log.bytes},
                    {"ticks", results.ticks},
                    {"ticks_lost", telemetry.queue_overflows},
                    {"steps_lost", telemetry.step_overflows},
                    {"failure", telemetry.log.Explain()},
                    {"timeline_failure", telemetry.timeline_failure}};
  if (telemetry.exercise) {
    const ExerciseResult& exercise = *telemetry.exercise;
    summary["exercise"] = {{"score", exercise.score},
                           {"passed", exercise.passed},
                           {"ended", exercise.ended},
                           {"time_s", exercise.time},
                           {"steps_done", exercise.step_times.size()},
                           {"steps", session.scene().exercise->steps.size()},
                           {"errors", exercise.errors.size()},
                           {"bleedings", exercise.bleedings.size()},
                           {"restarts", exercise.restarts.size()}};
  }
  if (telemetry.live) {
    summary["live"] = {{"messages", telemetry.live_messages}, {"errors", telemetry.live_errors}};
  }
  if (record.link) summary["device_link"] = LinkToJson(*record.link);
  if (!record.lockstep) summary["machine"] = MachineToJson(record, results);
  summary["realtime"] = RealtimeToJson(record);
  summary["command"] = CommandToJson(command_line);
  summary["files"] = FilesToJson(folder.files());
  summary["remarks"] = session.remarks();
  return summary;
}

std::string BriefSummary(const Json& summary, const std::string& folder, const std::string& program,
                         const HandlingLimits& limits) {
  std::string text = Format("%s: %.1f s%s\n", summary["scene"].get<std::string>().c_str(),
                            summary["seconds"].get<double>(),
                            summary["ended_by"] == "user" ? ", ended by you" : "");
  if (summary.contains("exercise")) {
    const Json& exercise = summary["exercise"];
    text += Format("exercise: score %.1f, %d of %d steps, %d errors, %.1f s\n",
                   exercise["score"].get<double>(), exercise["steps_done"].get<int>(),
                   exercise["steps"].get<int>(), exercise["errors"].get<int>(),
                   exercise["time_s"].get<double>());
  }
  std::string peaks;
  for (const Json& tool : summary["tools"]) AppendToList(PeakOf(tool, limits), &peaks, "; ");
  if (!peaks.empty()) text += "peak: " + peaks + "\n";
  const Json& skipped = summary["haptic"]["skipped"];
  if (const long missed = skipped["total"].get<long>(); missed > 0) {
    const long all = missed + summary["haptic"]["ticks"].get<long>();
    text +=
        "ticks missed: " + WithCommas(missed) + " of " + WithCommas(all) + CausesOf(skipped) + "\n";
  }
  if (const long lost = summary["log"]["ticks_lost"].get<long>(); lost > 0) {
    text += "log: " + WithCommas(lost) + " ticks lost\n";
  }
  if (const std::string failure = summary.value("/render/failure"_json_pointer, std::string());
      !failure.empty()) {
    text += "picture: " + failure + "\n";
  }
  return text + "session folder: " + folder + "\nnext: " + ShellWord(program) + " report " +
         ShellWord(folder) + "\n";
}

std::string VerboseSummary(const Json& summary) {
  std::string text =
      Format("%s: %.1f s on the %s clock\n", summary["scene"].get<std::string>().c_str(),
             summary["seconds"].get<double>(), summary["clock"].get<std::string>().c_str());
  const bool timed = summary["clock"] != "lockstep";
  text += LoopLine("haptic", summary["haptic"], "ticks", timed);
  const Json& skipped = summary["haptic"]["skipped"];
  if (skipped["total"].get<long>() > 0) {
    text += "             skipped because of" + CausesOf(skipped) + "\n";
  }
  text += LoopLine("deformation", summary["deformation"], "steps", timed);
  if (summary.contains("render")) {
    const Json& render = summary["render"];
    text += Format("%-12s %8.2f Hz  %8ld frames  %4ld dropped   compute p50 %8.1f p99 %8.1f us\n",
                   "render", render["rate_hz"].get<double>(), render["frames"].get<long>(),
                   render["dropped"].get<long>(), render["compute"]["p50_us"].get<double>(),
                   render["compute"]["p99_us"].get<double>());
    const std::string failure = render["failure"];
    if (!failure.empty()) text += "             " + failure + "\n";
  }
  text += AgeLine("patch age", summary["haptic"]["patch_age"]);
  if (timed) {
    text += AgeLine("device to force", summary["haptic"]["device_to_force"]);
    if (summary.contains("render")) {
      text += AgeLine("device to photon", summary["render"]["device_to_photon"]);
    }
    text += MachineLines(summary);
  }
  for (const Json& tool : summary["tools"]) {
    text +=
        Format("%s: peak force %.2f N, mean %.2f N over %.1f s of contact, deepest press %.1f mm\n",
               tool["name"].get<std::string>().c_str(), tool["peak_force_N"].get<double>(),
               tool["mean_force_N"].get<double>(), tool["contact_time_s"].get<double>(),
               1000 * tool["deepest_press_m"].get<double>());
    if (const int slips = tool["slips"].get<int>(); slips > 0) {
      text += Format("%s: tissue slipped in the jaws %d times\n",
                     tool["name"].get<std::string>().c_str(), slips);
    }
  }
  const Json& log = summary["log"];
  text +=
      Format("log: %ld events, %.1f MB, %ld ticks lost\n", log["events"].get<long>(),
             static_cast<double>(log["bytes"].get<long>()) / 1e6, log["ticks_lost"].get<long>());
  const std::string failure = log["failure"];
  if (!failure.empty()) text += "log: " + failure + "\n";
  if (summary.contains("device_link")) {
    const Json& link = summary["device_link"];
    text +=
        Format("device link: %ld readings received, %ld refused, %ld forces sent\n",
               link["received"].get<long>(), link["refused"].get<long>(), link["sent"].get<long>());
  }
  for (const auto& [thread, lines] : summary["realtime"].items()) {
    for (const Json& line : lines) text += thread + ": " + line.get<std::string>() + "\n";
  }
  return text;
}

}  // namespace hpdm
