#include "tools/report/fleet/fleet_command.h"

#include <cstdio>
#include <thread>

#include "engine/base/error.h"
#include "tools/report/fleet/fleet.h"
#include "tools/report/fleet/learning_curve.h"
#include "tools/report/fleet/learning_curve_page.h"
#include "tools/report/fleet/session_line.h"
#include "tools/shared/report_text.h"
#include "tools/shared/staged_file.h"

namespace hpdm {
namespace {

std::string Count(std::size_t number) { return WithCommas(static_cast<long long>(number)); }

void PrintLine(const std::string& session, const HandlingLimits& limits) {
  const nlohmann::ordered_json line = SessionLine(session, limits);
  std::printf("%s\n", LineText(line).c_str());
  if (std::fflush(stdout) != 0) throw InputError("stdout: cannot be written; free space");
  if (line.at("exit_code") == 0) return;
  std::fprintf(stderr, "hpdm: %s\n", line.at("error").get<std::string>().c_str());
  throw CheckFailed{line.at("exit_code").get<int>()};
}

}  // namespace

void AddFleetOptions(Command report, const std::vector<Option>& single, FleetArguments* arguments) {
  constexpr int kMaxJobs = 256;
  Option line =
      report.AddFlag("--json-line", arguments->json_line,
                     "Print the figures, or the failure, as one line of JSON, for clusters "
                     "(tools/report/fleet.md)");
  Option all =
      report.AddFlag("--all", arguments->all,
                     "SESSION is a folder of session folders, at any depth. Each gets a process "
                     "and a line of JSON; --out: a table of all instead, SQLite or .jsonl");
  Option collect =
      report.AddOption("--collect", arguments->collect,
                       "Put lines of --json-line from these files (-: standard input) into the "
                       "table --out");
  collect.Excludes(all).Excludes(line);
  line.Excludes(all);
  for (Option option : single) {
    for (Option many : {all, line, collect}) many.Excludes(option);
  }
  report.AddOption("--jobs", arguments->jobs, "Processes at once [one per processor]")
      .From(1, kMaxJobs)
      .Needs(all);
  report.AddOption("--timeout", arguments->patience, "Longest time for one session, s")
      .From(0.001, 1e6)
      .ShowDefault()
      .Needs(all);
  report
      .AddFlag("--again", arguments->again,
               "Also read sessions that the table has and whose logs are unchanged")
      .Needs(all);
  report
      .AddOption("--curve", arguments->curve,
                 "Write a page with the learning curve of each task: its sessions in the order of "
                 "their starts")
      .Needs(all);
}

bool RunFleetCommand(const FleetArguments& arguments, const std::string& session,
                     const std::string& out, const HandlingLimits& limits) {
  if (arguments.collect.empty() && session.empty()) {
    throw InputError("report: no session; give its folder, or a folder of sessions with --all");
  }
  if (arguments.json_line) {
    if (!out.empty()) throw InputError("--out " + out + ": --json-line prints to stdout only");
    PrintLine(session, limits);
    return true;
  }
  if (!arguments.all && arguments.collect.empty()) return false;
  FleetSummary summary;
  if (!arguments.curve.empty() && !out.empty()) {
    throw InputError("--curve cannot be combined with --out: it reads all sessions; leave one out");
  }
  if (arguments.all) {
    std::vector<nlohmann::ordered_json> lines;
    FleetOptions options{.folder = session,
                         .table = out,
                         .patience = arguments.patience,
                         .limits = limits,
                         .again = arguments.again,
                         .print_lines = out.empty() && arguments.curve.empty()};
    if (!arguments.curve.empty()) options.lines = &lines;
    options.jobs = arguments.jobs > 0
                       ? arguments.jobs
                       : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    summary = ReportAll(options);
    std::fprintf(stderr, "%s sessions: %s reported, %s unchanged, %s failed\n",
                 Count(summary.sessions).c_str(), Count(summary.reported).c_str(),
                 Count(summary.unchanged).c_str(), Count(summary.failed).c_str());
    if (!arguments.curve.empty()) {
      StagedFile page(arguments.curve);
      page.Write(LearningCurvePage(LearningCurves(lines)));
      page.Commit();
      std::printf("%s\n", OneLine(arguments.curve).c_str());
    }
    if (!out.empty()) {
      std::printf("%s: added %s report%s\n", OneLine(out).c_str(), Count(summary.reported).c_str(),
                  summary.reported == 1 ? "" : "s");
    }
  } else {
    if (!session.empty()) throw InputError(session + ": --collect takes lines, not a session");
    if (out.empty()) throw InputError("--collect: no table; give --out TABLE.sqlite");
    summary = CollectLines(arguments.collect, out);
    std::fprintf(stderr, "%s lines: %s reported, %s refused\n", Count(summary.sessions).c_str(),
                 Count(summary.reported).c_str(), Count(summary.failed).c_str());
  }
  if (summary.failed > 0) throw CheckFailed();
  return true;
}

}  // namespace hpdm
