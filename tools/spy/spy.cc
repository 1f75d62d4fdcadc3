#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "engine/base/error.h"
#include "tools/command_line.h"
#include "tools/commands.h"
#include "tools/session/session_path.h"
#include "tools/session/stop_signals.h"
#include "tools/shared/json_text.h"
#include "tools/shared/report_text.h"
#include "tools/shared/schema_files.h"
#include "tools/spy/dashboard/dashboard.h"
#include "tools/spy/once_report.h"
#include "tools/spy/spy_source.h"
#include "tools/spy/terminal/terminal_view.h"

namespace hpdm {
namespace {

struct SpyOptions {
  std::string log;
  std::vector<std::string> types;
  bool once = false;
  bool json = false;
  bool web = false;
  std::string web_value;  // word after --web
  DashboardOptions dashboard;
  double seconds = 0;  // 0: not given
  double speed = 0;    // 0: not given
  double from = 0;
};

/// Opens the source, with a note on the terminal if that takes long.
SpySource Opened(const std::string& log) {
  constexpr std::uintmax_t kQuickBytes = 200'000'000;
  std::error_code error;
  const std::uintmax_t bytes = log.empty() ? 0 : std::filesystem::file_size(log, error);
  const bool tell = !error && bytes > kQuickBytes && isatty(STDERR_FILENO) != 0;
  if (tell) {
    std::fprintf(stderr, "reading %s MB, Ctrl-C ends it",
                 WithCommas(static_cast<long long>(bytes / 1'000'000)).c_str());
  }
  SpySource source(log);
  if (tell) std::fprintf(stderr, "\r\x1b[K");
  return source;
}

void ReportOnce(const SpyOptions& options, const MessageSchemas& schemas, const StopSignals& stop,
                SpySource* source) {
  constexpr double kDefaultSeconds = 2;
  const bool log = source->player() != nullptr;
  if (log && options.speed == 0) source->player()->SetSpeed(LogPlayer::kUnlimited);
  const double everything = std::numeric_limits<double>::infinity();
  const double seconds =
      options.seconds > 0 ? options.seconds : (log ? everything : kDefaultSeconds);
  SpyReport report(schemas);
  Watch(source, seconds, stop, &report);
  if (options.json) {
    std::printf("%s\n", JsonText(ToJson(report, schemas)).c_str());
  } else {
    Print(report);
  }
  if (report.table.messages() > 0) return;
  std::fprintf(stderr, "hpdm: spy: no messages from %s; %s\n", OneLine(source->name()).c_str(),
               log ? "give a log that contains events"
                   : "start a session with hpdm run SCENE --live and the same LCM_DEFAULT_URL");
  throw CheckFailed();
}

// Interprets the word after --web [PORT]: a number is the port, other text is the log.
void TakeWebValue(SpyOptions* options) {
  const std::string& value = options->web_value;
  if (value.empty()) return;
  const bool number = value.find_first_not_of("0123456789") == std::string::npos;
  if (number && (value.size() > 5 || std::stoi(value) > 65535)) {
    throw InputError("spy: --web " + value + ": not a port; give a number from 0 to 65535");
  }
  if (number) {
    options->dashboard.port = std::stoi(value);
  } else if (options->log.empty()) {
    options->log = value;
  } else {
    throw InputError("spy: --web " + value + ": not a port, and the log is " + options->log +
                     "; give a number from 0 to 65535");
  }
}

void Spy(const SpyOptions& options) {
  if (options.json && !options.once) {
    throw InputError("spy: --json needs --once");
  }
  if (options.once && options.web) {
    throw InputError("spy: --web cannot be combined with --once; leave one out");
  }
  std::error_code error;
  if (!options.log.empty() && !std::filesystem::exists(options.log, error)) {
    throw InputError(options.log + ": no such file; give the path of a session.lcmlog");
  }
  if (!options.once && !options.web && (isatty(STDOUT_FILENO) == 0 || isatty(STDIN_FILENO) == 0)) {
    throw InputError(
        "spy: standard output is not a terminal; give --once for a table, --once --json for a "
        "script");
  }
  if (options.log.empty() && (options.speed > 0 || options.from > 0)) {
    throw InputError("spy: --speed and --from need a log; give its path");
  }
  const MessageSchemas schemas = SchemasWith(options.types);
  // Blocks the signals before LCM starts its thread. While a log is indexed, a signal ends the
  // program immediately.
  std::optional<StopSignals> blocked;
  if (options.log.empty()) blocked.emplace();
  SpySource source = Opened(options.log.empty() ? options.log : LogPathOf(options.log));
  if (!blocked) blocked.emplace();
  const StopSignals& stop = *blocked;
  if (source.player() != nullptr) {
    if (options.speed > 0) source.player()->SetSpeed(options.speed);
    const auto from_us = static_cast<std::int64_t>(1e6 * options.from);
    // A report does not count earlier messages.
    if (from_us > 0) source.player()->Seek(from_us, options.once ? 0 : LogPlayer::kLeadInUs);
  }
  if (options.web) {
    ServeDashboard(options.dashboard, schemas, stop, &source);
  } else if (options.once) {
    ReportOnce(options, schemas, stop, &source);
  } else {
    RunTerminalView(&source, schemas, stop);
  }
}

}  // namespace

void AddSpyCommand(Command app) {
  const auto options = std::make_shared<SpyOptions>();
  Command spy = app.AddCommand(
      "spy", "Watch live LCM messages or play back a log: channels, rates, losses, values");
  spy.AddOption("log", options->log,
                "Log to play, or a session's folder [the network of LCM_DEFAULT_URL, or else this "
                "machine's]");
  spy.AddFlag("--once", options->once,
              "Watch for --seconds, print a table and exit; exit 1 if no message came");
  spy.AddOption("--seconds", options->seconds, "With --once: time to watch [2; a log: all of it]")
      .From(0.01, 1e9);
  spy.AddFlag("--json", options->json, "With --once: print JSON, with the last values");
  spy.AddOption("--types", options->types, "Further LCM types: a .lcm file; repeatable")
      .OneValueEach();
  spy.AddOption("--speed", options->speed,
                "Playback speed of a log, times real time: 0.1 to 100 [1; with --once as fast as "
                "possible]")
      .From(LogPlayer::kSlowest, LogPlayer::kFastest);
  spy.AddOption("--from", options->from,
                "Start of the playback, s from the log's start; --once does not count earlier "
                "messages")
      .From(0.0, 1e9);
  Option web = spy.AddOption("--web", options->web_value,
                             "Serve a dashboard for a browser on this port, for this machine only "
                             "[8090]; 0: any free port");
  web.OptionalValue("PORT");
  spy.AddOption("--host", options->dashboard.host,
                "With --web: address to listen on; other machines may then reach it")
      .Needs(web);
  spy.OnRun([options, web] {
    options->web = web.Given();
    TakeWebValue(options.get());
    Spy(*options);
  });
}

}  // namespace hpdm
