#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "engine/base/error.h"
#include "scenes/loader/changed_files.h"
#include "tools/command_line.h"
#include "tools/commands.h"
#include "tools/report/fleet/fleet_command.h"
#include "tools/report/metrics/report_json.h"
#include "tools/report/metrics/session_comparison.h"
#include "tools/report/metrics/session_files.h"
#include "tools/report/metrics/session_metrics.h"
#include "tools/report/page/report_page.h"
#include "tools/session/session_path.h"
#include "tools/shared/json_text.h"
#include "tools/shared/staged_file.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

struct ReportOptions {
  std::string session;
  std::string out;
  std::string against;
  HandlingLimits limits;
  bool json = false;
  FleetArguments fleet;
};

void WritePage(const ReportOptions& options, SessionFiles* files, const SessionReading& reading,
               const SessionReport* against) {
  LoadPictures(files);
  const std::string text = ReportPageText(reading, *files, against);
  // Without --out the page is written beside the log, whose folder may be untrusted.
  const bool beside = options.out.empty();
  const fs::path folder = files->folder.empty() ? files->log.parent_path() : files->folder;
  const fs::path out = beside ? folder / "report.html" : fs::path(options.out);
  std::error_code error;
  if (fs::equivalent(out, files->log, error) && !(beside && fs::is_symlink(out, error))) {
    throw InputError(out.string() + ": is the session's log; choose another file with --out");
  }
  if (!files->folder.empty()) {
    RefuseOwnInput(out, {files->folder / "scene.toml", files->folder / "summary.json"});
  }
  StagedFile page(out, beside ? StagedFile::Name::kOfOthers : StagedFile::Name::kOfUser);
  page.Write(text);
  page.Commit();
  if (!options.json) std::printf("%s\n", out.c_str());
}

void Report(const ReportOptions& options) {
  if (RunFleetCommand(options.fleet, options.session, options.out, options.limits)) return;
  SessionFiles files = FindSessionFiles(options.session);
  const SessionReading reading = ReadSession(files, options.limits.force, options.limits.depth);
  std::optional<SessionReport> against;
  if (!options.against.empty()) {
    against =
        ReadSession(FindSessionFiles(options.against), options.limits.force, options.limits.depth)
            .report;
  }
  // --json without --out writes no page.
  if (!options.json || !options.out.empty()) {
    WritePage(options, &files, reading, against ? &*against : nullptr);
  }
  if (options.json) {
    nlohmann::ordered_json json = ToJson(reading.report);
    if (against) {
      json["against"] = ToJson(*against);
      json["comparison"] = ComparisonToJson(reading.report, *against);
    }
    std::printf("%s\n", JsonText(json).c_str());
    return;
  }
  if (against) {
    for (const std::string& warning : CompareTasks(reading.report, *against).warnings) {
      std::fprintf(stderr, "hpdm: note: --against: %s\n", OneLine(warning).c_str());
    }
  }
  const fs::path scene = FileInside(files.log.parent_path(), "scene.toml");
  for (const std::string& name : ChangedFiles(scene)) {
    std::fprintf(stderr,
                 "hpdm: note: %s: %s differs from the file that the session read; a replay needs "
                 "that one, the report does not\n",
                 OneLine(scene.string()).c_str(), OneLine(name).c_str());
  }
  for (const std::string& fault : reading.report.health.Faults()) {
    std::fprintf(stderr, "hpdm: %s: %s\n", OneLine(files.log.string()).c_str(), fault.c_str());
  }
}

}  // namespace

void AddReportCommand(Command app) {
  const auto options = std::make_shared<ReportOptions>();
  Command report = app.AddCommand(
      "report",
      "Write an HTML report of a session for trainer and trainee, or its figures as JSON");
  report.AddOption("session", options->session, "A session's folder, or its log");
  report.AddOption("--out", options->out, "HTML file [report.html beside the log]");
  report
      .AddOption("--force-limit", options->limits.force,
                 "Force limit, N; reports time above it (tools/report/README.md)")
      .From(1e-6, 1e6)
      .ShowDefault();
  report
      .AddOption("--depth-limit", options->limits.depth,
                 "Depth limit of a press, m; reports time deeper than it")
      .From(1e-6, 10)
      .ShowDefault();
  Option against = report.AddOption("--against", options->against,
                                    "Another session's folder or log to compare with");
  Option json = report.AddFlag("--json", options->json,
                               "Print the figures as JSON; write a page only with "
                               "--out");
  AddFleetOptions(report, {against, json}, &options->fleet);
  report.OnRun([options] { Report(*options); });
}

}  // namespace hpdm
