#include "tools/report/fleet_command.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <thread>

#include "engine/error.h"
#include "tools/number_option.h"
#include "tools/report/fleet.h"
#include "tools/report/session_line.h"
#include "tools/report_text.h"

namespace hpdm {
namespace {

std::string Count(std::size_t number) { return WithCommas(static_cast<long long>(number)); }

void PrintLine(const std::string& session, double force_limit) {
  const nlohmann::ordered_json line = SessionLine(session, force_limit);
  std::printf("%s\n", LineText(line).c_str());
  if (std::fflush(stdout) != 0) throw InputError("stdout: cannot be written; make space");
  if (line.at("exit_code") == 0) return;
  std::fprintf(stderr, "hpdm: %s\n", line.at("error").get<std::string>().c_str());
  throw CLI::RuntimeError(line.at("exit_code").get<int>());
}

}  // namespace

void AddFleetOptions(CLI::App* report, const std::vector<CLI::Option*>& single,
                     FleetArguments* arguments) {
  constexpr int kMostJobs = 256;
  CLI::Option* line = report->add_flag(
      "--json-line", arguments->json_line,
      "Print the figures as one line of JSON, whatever becomes of it: the unit for "
      "clusters (tools/report/fleet.md)");
  CLI::Option* all =
      report->add_flag("--all", arguments->all,
                       "SESSION is a folder of session folders, at any depth: a process and a line "
                       "of JSON each; --out: a table of all, SQLite or .jsonl");
  CLI::Option* collect =
      report->add_option("--collect", arguments->collect,
                         "Put the lines that --json-line printed, from these files (-: standard "
                         "input), into the table --out");
  collect->excludes(all)->excludes(line);
  line->excludes(all);
  for (CLI::Option* option : single) {
    for (CLI::Option* many : {all, line, collect}) many->excludes(option);
  }
  report->add_option("--jobs", arguments->jobs, "Processes at once; default: one a processor")
      ->check(CLI::Range(1, kMostJobs))
      ->needs(all);
  report->add_option("--timeout", arguments->patience, "s for one session")
      ->check(NumberFrom(0.001, 1e6))
      ->capture_default_str()
      ->needs(all);
  report
      ->add_flag("--again", arguments->again,
                 "Read those too that the table has and whose logs are unchanged")
      ->needs(all);
}

bool RunFleetCommand(const FleetArguments& arguments, const std::string& session,
                     const std::string& out, double force_limit) {
  if (arguments.collect.empty() && session.empty()) {
    throw InputError("report: no session; give its folder, or a folder of sessions with --all");
  }
  if (arguments.json_line) {
    if (!out.empty()) throw InputError("--out " + out + ": --json-line prints on stdout alone");
    PrintLine(session, force_limit);
    return true;
  }
  if (!arguments.all && arguments.collect.empty()) return false;
  FleetSummary summary;
  if (arguments.all) {
    FleetOptions options{.folder = session,
                         .table = out,
                         .patience = arguments.patience,
                         .force_limit = force_limit,
                         .again = arguments.again};
    options.jobs = arguments.jobs > 0
                       ? arguments.jobs
                       : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    summary = ReportAll(options);
    std::fprintf(stderr, "%s sessions: %s reported, %s unchanged, %s failed\n",
                 Count(summary.sessions).c_str(), Count(summary.reported).c_str(),
                 Count(summary.unchanged).c_str(), Count(summary.failed).c_str());
  } else {
    if (!session.empty()) throw InputError(session + ": --collect takes lines alone, no session");
    if (out.empty()) throw InputError("--collect: no table; give --out TABLE.sqlite");
    summary = CollectLines(arguments.collect, out);
    std::fprintf(stderr, "%s lines: %s of reported sessions, %s refused\n",
                 Count(summary.sessions).c_str(), Count(summary.reported).c_str(),
                 Count(summary.failed).c_str());
  }
  if (summary.failed > 0) throw CLI::RuntimeError(1);
  return true;
}

}  // namespace hpdm
