#include "lcmtypes/log/log.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "lcmtypes/analysis/log_health.h"
#include "tools/command_line.h"
#include "tools/commands.h"
#include "tools/log/log_export.h"
#include "tools/log/mcap_export.h"
#include "tools/log/vtk_export.h"
#include "tools/session/session_path.h"
#include "tools/session/session_scene.h"
#include "tools/shared/interrupt.h"
#include "tools/shared/json_text.h"
#include "tools/shared/report_text.h"
#include "tools/shared/schema_files.h"
#include "tools/shared/staged_file.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

struct LogOptions {
  std::string log;
  std::string repaired;
  std::string out;
  std::string format = "csv";
  std::vector<std::string> channels;
  std::vector<std::string> types;
  double period = 0;  // s; 0: the hands do not repeat their motion
  bool json = false;
};

using Invariants = std::optional<std::vector<Invariant>>;  // empty: without a scene

bool AllHold(const Invariants& invariants) {
  return !invariants || std::all_of(invariants->begin(), invariants->end(),
                                    [](const Invariant& i) { return i.Holds(); });
}

Json ToJson(const Invariants& invariants) {
  if (!invariants) return nullptr;
  Json json = Json::array();
  for (const Invariant& invariant : *invariants) {
    json.push_back({{"name", invariant.name},
                    {"what", invariant.what},
                    {"unit", invariant.unit},
                    {"holds", invariant.Holds()},
                    {"worst", invariant.worst},  // null if not finite
                    {"bound", invariant.bound},
                    {"checked", invariant.checked},
                    {"broken", invariant.broken},
                    {"first_s", invariant.first ? Json(*invariant.first) : Json()}});
  }
  return json;
}

Json ToJson(const LogHealth& health) {
  Json json = {{"sound", health.Sound()},
               {"bytes", health.bytes},
               {"events", health.events},
               {"damaged_segments", health.damaged_stretches},
               {"damaged_stretches", health.damaged_stretches},  // deprecated: damaged_segments
               {"damaged_bytes", health.damaged_bytes},
               {"torn_bytes", health.torn_bytes},
               {"time_back", health.time_back},
               {"session", health.session},
               {"closed", health.closed},
               {"channels", Json::array()}};
  for (const ChannelFacts& channel : health.channels) {
    json["channels"].push_back({{"channel", channel.channel},
                                {"type", channel.type},
                                {"known", channel.known},
                                {"messages", channel.messages},
                                {"bytes", channel.bytes},
                                {"first_us", channel.first_us},
                                {"last_us", channel.last_us},
                                {"rate_hz", channel.Rate()},
                                {"unreadable", channel.unreadable},
                                {"gaps", channel.gaps},
                                {"lost", channel.lost},
                                {"not_rising", channel.not_rising}});
  }
  return json;
}

void Print(const LogHealth& health) {
  std::printf("%-14s %-18s %10s %10s %12s %8s %8s %10s %10s\n", "channel", "type", "messages",
              "per s", "bytes", "gaps", "lost", "not rising", "unreadable");
  for (const ChannelFacts& c : health.channels) {
    std::printf("%-14s %-18s %10s %10.4g %12s %8s %8s %10s %10s\n", Printable(c.channel).c_str(),
                Printable(c.type).c_str(), WithCommas(static_cast<long long>(c.messages)).c_str(),
                c.Rate(), WithCommas(static_cast<long long>(c.bytes)).c_str(),
                WithCommas(static_cast<long long>(c.gaps)).c_str(),
                WithCommas(static_cast<long long>(c.lost)).c_str(),
                WithCommas(static_cast<long long>(c.not_rising)).c_str(),
                WithCommas(static_cast<long long>(c.unreadable)).c_str());
  }
  std::printf("%s events, %s bytes; damaged: %s bytes in %s places; torn tail: %s bytes\n",
              WithCommas(static_cast<long long>(health.events)).c_str(),
              WithCommas(static_cast<long long>(health.bytes)).c_str(),
              WithCommas(static_cast<long long>(health.damaged_bytes)).c_str(),
              WithCommas(static_cast<long long>(health.damaged_stretches)).c_str(),
              WithCommas(static_cast<long long>(health.torn_bytes)).c_str());
  if (health.time_back > 0) {
    std::printf("time goes backwards %s times\n",
                WithCommas(static_cast<long long>(health.time_back)).c_str());
  }
  if (health.session && !health.closed) std::printf("the session was not closed\n");
}

void Print(const Invariants& invariants) {
  if (!invariants) {
    std::printf("no scene.toml beside the log: the session's limits are unknown\n");
    return;
  }
  for (const Invariant& i : *invariants) {
    std::string line =
        Format("%-9s %-6s (%s bad of %s", i.name.c_str(), i.Holds() ? "ok" : "BROKEN",
               WithCommas(static_cast<long long>(i.broken)).c_str(),
               WithCommas(static_cast<long long>(i.checked)).c_str());
    if (!i.unit.empty()) {
      line += Format("; largest %.4g %s, limit %.4g %s", i.worst, i.unit.c_str(), i.bound,
                     i.unit.c_str());
    }
    line += ")";
    if (!i.Holds()) line += Format("; first at %.3f s: ", i.first.value_or(0)) + i.what;
    std::printf("%s\n", line.c_str());
  }
}

// Checks the invariants of a session. Returns nothing if its scene is not beside the log or cannot
// be read.
Invariants InvariantsOf(const std::string& log, const LogHealth& health, double period) {
  std::error_code ignored;
  const std::filesystem::path scene = SceneBeside(log);
  if (!health.session || !std::filesystem::exists(scene, ignored)) return std::nullopt;
  SessionLimits limits;
  try {
    limits = LimitsOf(LoadRecordedScene(scene));
  } catch (const InputError& error) {
    std::fprintf(stderr, "hpdm: note: %s: the session's invariants are not checked\n",
                 error.what());
    return std::nullopt;
  }
  return CheckInvariants(log, limits, static_cast<Nanoseconds>(std::llround(1e9 * period)));
}

void Check(const LogOptions& options) {
  const std::string log = LogPathOf(options.log);
  const LogHealth health = CheckLog(log, SchemasWith(options.types));
  const Invariants invariants = InvariantsOf(log, health, options.period);
  if (options.period > 0 && !invariants) {
    throw InputError(log + ": --period needs a session's log with its scene.toml beside it");
  }
  Json json = ToJson(health);
  json["invariants"] = ToJson(invariants);
  if (!options.repaired.empty()) {
    json["repaired"] = options.repaired;
    json["repaired_events"] = RepairLog(log, options.repaired);
  }
  if (options.json) {
    std::printf("%s\n", JsonText(json).c_str());
  } else {
    Print(health);
    if (health.session) Print(invariants);
    std::printf("%s\n", health.Sound() && AllHold(invariants) ? "sound" : "not sound");
    if (!options.repaired.empty()) {
      std::printf("%s: the intact events\n", options.repaired.c_str());
    }
  }
  if (!health.Sound() || !AllHold(invariants)) throw CheckFailed();
}

/// Refuses options that do not match --format.
void CheckFormat(const LogOptions& options) {
  if (options.format == "vtk" && !options.channels.empty()) {
    throw InputError("--channels cannot be combined with --format vtk; leave it out");
  }
  const bool is_mcap_name = options.out.ends_with(".mcap");
  std::error_code ignored;
  const bool is_folder =
      options.out.ends_with('/') || std::filesystem::is_directory(options.out, ignored);
  if (options.format != "mcap" && is_mcap_name && !is_folder) {
    throw InputError("--out " + options.out + ": --format " + options.format +
                     " writes a folder of " + (options.format == "csv" ? "tables" : "surfaces") +
                     "; add --format mcap for one file");
  }
  if (options.format == "mcap" && is_folder) {
    throw InputError("--out " + options.out +
                     ": --format mcap writes one file; give --out FILE.mcap");
  }
}

void RefuseWithoutEvents(const std::string& log) {
  LogReader reader(log);
  LogEvent event;
  if (reader.Next(&event)) return;
  throw InputError(log + ": contains no log events; give the path of a session.lcmlog");
}

// Ends an export that the user interrupted. The exporter then removes its unfinished files.
void EndIfInterrupted(const Interrupt& interrupt) {
  if (!interrupt.Requested()) return;
  std::fprintf(stderr, "hpdm: interrupted: nothing was exported\n");
  throw CheckFailed{kInterruptedExitCode};
}

void ExportSurfaces(const LogOptions& options) {
  const Interrupt interrupt;
  const ExportedSurfaces exported =
      ExportVtk(LogPathOf(options.log), options.out, [&] { EndIfInterrupted(interrupt); });
  Json json = {
      {"file", exported.index.string()}, {"steps", exported.steps}, {"organs", Json::array()}};
  for (const ExportedOrgan& organ : exported.organs) {
    json["organs"].push_back(
        {{"name", organ.name}, {"surfaces", organ.surfaces}, {"skipped", organ.skipped}});
  }
  if (options.json) {
    std::printf("%s\n", JsonText(json).c_str());
    return;
  }
  const auto number = [](std::uint64_t n) { return WithCommas(static_cast<long long>(n)); };
  std::printf("%s: the surfaces after %s deformation steps; open it in ParaView\n",
              OneLine(exported.index.string()).c_str(), number(exported.steps).c_str());
  for (const ExportedOrgan& organ : exported.organs) {
    std::printf("%s: %s files, for its rest and for each step that changed it",
                Printable(organ.name).c_str(), number(organ.surfaces).c_str());
    if (organ.skipped > 0) std::printf(", %s unusable messages", number(organ.skipped).c_str());
    std::printf("\n");
  }
}

void Export(const LogOptions& options) {
  CheckFormat(options);
  RefuseOwnInput(options.out, {LogPathOf(options.log)});
  RefuseWithoutEvents(LogPathOf(options.log));
  if (options.format == "vtk") return ExportSurfaces(options);
  const bool mcap = options.format == "mcap";
  const Interrupt interrupt;
  const std::vector<ExportedChannel> exported = (mcap ? ExportMcap : ExportCsv)(
      LogPathOf(options.log), options.out, options.channels, SchemasWith(options.types),
      [&] { EndIfInterrupted(interrupt); });
  Json json = Json::array();
  for (const ExportedChannel& channel : exported) {
    const bool left_out = channel.file.empty();
    json.push_back({{"channel", channel.channel},
                    {"type", channel.type},
                    {"file", left_out ? Json() : Json(channel.file.string())},
                    {"messages", channel.messages},
                    {"skipped", channel.skipped}});
    if (options.json) continue;
    const std::string name = Printable(channel.channel), type = Printable(channel.type);
    const std::string place =
        mcap ? OneLine(options.out) + ": " + name : OneLine(channel.file.string());
    if (left_out) {
      std::printf("%s: left out, %s messages of unknown type %s (give --types)\n", name.c_str(),
                  WithCommas(static_cast<long long>(channel.skipped)).c_str(), type.c_str());
    } else {
      std::printf("%s: %s %s%s\n", place.c_str(),
                  WithCommas(static_cast<long long>(channel.messages)).c_str(),
                  mcap ? "messages" : "rows",
                  channel.skipped == 0 ? ""
                                       : Format(", %llu unreadable messages",
                                                static_cast<unsigned long long>(channel.skipped))
                                             .c_str());
    }
  }
  if (options.json) std::printf("%s\n", JsonText(json).c_str());
}

}  // namespace

void AddLogCommand(Command app) {
  Command log = app.AddCommand("log", "Check and export session logs and other LCM logs");
  log.RequireCommand();
  const auto add = [log](const char* name, const char* what, LogOptions* options) {
    Command command = log.AddCommand(name, what);
    command.AddOption("log", options->log, "LCM log file, or a session's folder").Required();
    command.AddOption("--types", options->types, "Further LCM types: a .lcm file; repeatable")
        .OneValueEach();
    command.AddFlag("--json", options->json, "Print the result as JSON");
    return command;
  };
  const auto to_check = std::make_shared<LogOptions>();
  Command check =
      add("check",
          "Check gaps, order and damage, and the invariants of a session: finite numbers, forces "
          "within limits, no generated energy, organs at rest when nothing touches them; exit 1 "
          "if something is wrong",
          to_check.get());
  check.AddOption("--repair", to_check->repaired,
                  "Write the intact events to a new log of this name");
  check
      .AddOption("--period", to_check->period,
                 "Period in s of hands that repeat their motion: from the third period on the "
                 "forces must equal those of the second bit for bit")
      .From(0.001, 1e6);
  check.OnRun([to_check] { Check(*to_check); });

  const auto to_export = std::make_shared<LogOptions>();
  Command exporting =
      add("export", "Write a CSV table per channel, one MCAP file, or the deformed surfaces",
          to_export.get());
  exporting
      .AddOption("--out", to_export->out,
                 "csv, vtk: folder for the files, created if missing; mcap: the file")
      .Required();
  exporting
      .AddOption("--format", to_export->format,
                 "csv; mcap: one file of JSON messages for Foxglove and PlotJuggler; vtk: each "
                 "organ's surface by deformation step for ParaView")
      .OneOf({"csv", "mcap", "vtk"})
      .ShowDefault();
  exporting.AddOption("--channels", to_export->channels, "Channels to export [all]");
  exporting.OnRun([to_export] { Export(*to_export); });
}

}  // namespace hpdm
