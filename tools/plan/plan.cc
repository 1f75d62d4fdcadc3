#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>

#include "engine/base/error.h"
#include "tools/command_line.h"
#include "tools/commands.h"
#include "tools/plan/plan_report.h"
#include "tools/plan/scene_plan.h"
#include "tools/plots/plot_plan.h"
#include "tools/plots/python_plot.h"
#include "tools/shared/interrupt.h"
#include "tools/shared/json_text.h"
#include "tools/shared/machine_facts.h"
#include "tools/shared/report_text.h"
#include "tools/shared/staged_file.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct PlanOptions {
  std::string scene;
  std::string out;
  std::string chart;
  double error = 0;
  double budget_ms = 0;
  double seconds = 0;
  bool json = false;
};

/// Writes a file that appears only when it is complete.
void WriteWhole(const fs::path& path, const std::string& text) {
  StagedFile file(path);
  file.Write(text);
  file.Commit();
}

/// Throws InputError, before the long search, if a result cannot be written.
void CheckOutputs(const PlanOptions& options) {
  if (!options.chart.empty()) {
    MakeOutFolder(options.chart);
    const StagedFile chart(fs::path(options.chart) / "plan.csv");
  }
  if (!options.out.empty()) const StagedFile out(options.out);
}

void WriteChart(const fs::path& folder, const ScenePlan& plan, const Json& report,
                const MachineFacts& machine, std::string* remark) {
  WriteWhole(folder / "plan.csv",
             PlanCsv(plan, {"processor: " + machine.processor, "compiler: " + machine.compiler,
                            "flags: " + machine.flags,
                            "threads: 1, load before: " + Format("%.2g", machine.load)}));
  WriteWhole(folder / "plan.md",
             PlanMarkdown(plan, report["scene"].get<std::string>(), ToText(machine)));
  WriteWhole(folder / "plan.json", JsonText(report) + "\n");
  *remark = RunPlotScript(kPlotPlanScript,
                          {(folder / "plan.csv").string(), (folder / "plan.png").string()});
}

void Plan(const PlanOptions& options) {
  const Scene scene = LoadScene(options.scene);
  if (!options.out.empty()) {
    std::vector<std::string> inputs = {scene.path.string()};
    for (const SceneFile& file : scene.files) inputs.push_back(file.path);
    RefuseOwnInput(options.out, inputs);
  }
  CheckOutputs(options);
  const Interrupt interrupt;
  const MachineFacts machine = ThisMachine();
  const TimingClock::time_point start = TimingClock::now();
  ScenePlan plan = MakePlan(
      scene, {options.error, 1e3 * options.budget_ms}, options.seconds,
      [](const std::string& organ, const PlanPoint& point) {
        std::fprintf(stderr, "%s: %s: %.1f %%, %s\n", organ.c_str(),
                     DescribeModel(point.model).c_str(), 100 * point.error,
                     Duration(point.MostMicroseconds()).c_str());
      },
      [&] { return interrupt.Requested(); });
  if (interrupt.Requested() && !plan.MeetsBoth()) {
    std::fputs("hpdm: interrupted before a model met both; nothing was written\n", stderr);
    throw CheckFailed{kInterruptedExitCode};
  }
  const double searched_s = MillisecondsSince(start) / 1e3;
  if (plan.MeetsBoth() && !options.out.empty()) {
    const fs::path out(options.out);
    const std::string text = PlannedScene(scene, plan, out.parent_path());
    CheckPlannedScene(text, out, plan);
    WriteWhole(out, text);
  }
  Json report = {{"scene", scene.path.string()}, {"machine", ToJson(machine)}};
  report.update(ToJson(plan));
  report["seconds"] = searched_s;
  report["remarks"] = plan.remarks;
  if (!options.chart.empty()) {
    std::string remark;
    WriteChart(options.chart, plan, report, machine, &remark);
    if (!remark.empty()) plan.remarks.push_back(remark);
  }
  if (options.json) {
    std::cout << JsonText(report) << "\n";
  } else {
    std::cout << PlanText(plan) << VerdictText(plan) << Format("searched in %.1f s; ", searched_s)
              << ToText(machine) << "\n";
    if (plan.MeetsBoth() && !options.out.empty()) std::cout << options.out << ": written\n";
    if (!options.chart.empty()) {
      std::cout << options.chart << ": plan.csv, plan.json, plan.md, plan.png\n";
    }
  }
  for (const std::string& remark : plan.remarks) std::fprintf(stderr, "hpdm: %s\n", remark.c_str());
  if (plan.MeetsBoth()) return;
  if (options.json) std::fputs(VerdictText(plan).c_str(), stderr);
  throw CheckFailed();
}

}  // namespace

void AddPlanCommand(Command app) {
  const auto options = std::make_shared<PlanOptions>();
  Command plan = app.AddCommand("plan", "Find the cheapest models within an error and a step time");
  plan.AddOption("scene", options->scene, "Scene file (TOML; see scenes/README.md)").Required();
  plan.AddOption("--error", options->error,
                 "Largest relative error of an organ's motion: 0.05 is 5 %")
      .Required()
      .From(0.001, 1);
  plan.AddOption("--budget-ms", options->budget_ms,
                 "Longest deformation step of all organs touched at once, ms")
      .Required()
      .From(0.001, 1000);
  plan.AddOption("--out", options->out,
                 "Scene to write: this one with the chosen models; keeps comments");
  plan.AddOption("--chart", options->chart,
                 "Folder for the chart: plan.csv, .json, .md, .png; created if missing");
  plan.AddOption("--seconds", options->seconds, "Time limit of the search").From(1, 86400);
  plan.AddFlag("--json", options->json, "Print JSON");
  plan.OnRun([options] { Plan(*options); });
}

}  // namespace hpdm
