#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <set>
#include <system_error>

#include "engine/base/error.h"
#include "scenes/generator/meshing/obj_writer.h"
#include "tools/chart/chart_report.h"
#include "tools/chart/chart_sweep.h"
#include "tools/chart/crack_table.h"
#include "tools/command_line.h"
#include "tools/commands.h"
#include "tools/plots/plot_chart.h"
#include "tools/plots/python_plot.h"
#include "tools/shared/json_text.h"
#include "tools/shared/machine_facts.h"
#include "tools/shared/staged_file.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct ChartOptions {
  std::vector<std::string> cases;
  std::string references;
  std::string out;
  std::set<std::string> only;
  bool json = false;
  bool quick = false;
  bool cracks = false;
};

// Returns the scene files of a folder, sorted: charts of different machines then have one order.
std::vector<std::string> ScenesIn(const fs::path& folder) {
  std::vector<std::string> scenes;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".toml") scenes.push_back(entry.path().string());
  }
  if (scenes.empty()) {
    throw InputError(folder.string() +
                     ": has no load cases; go to the folder that holds scenes/cases, or name the "
                     "scene files");
  }
  std::sort(scenes.begin(), scenes.end());
  return scenes;
}

// Returns the folder of a case's references: tests/reference for scenes/cases.
fs::path ReferenceFolder(const ChartOptions& options, const std::string& scene) {
  if (!options.references.empty()) return options.references;
  return fs::path(scene).parent_path() / "../../tests/reference";
}

struct ChartCase {
  StaticCase load_case;
  CaseReference reference;
};

ChartCase LoadChartCase(const ChartOptions& options, const std::string& scene) {
  ChartCase loaded;
  loaded.load_case = LoadStaticCase(scene);
  for (const LoadOptions& load : loaded.load_case.scene.loads) {
    if (!load.pressure.has_value()) continue;
    throw InputError(scene +
                     ": has a pressure load, which no instrument can exert; chart cases of "
                     "forces and displacements");
  }
  loaded.reference = LoadCaseReference(loaded.load_case, ReferenceFolder(options, scene));
  return loaded;
}

// Loads all input before any measurement, so that a missing file costs no minutes. Named cases must
// exist; of scenes/cases the ones that load are taken.
std::vector<ChartCase> LoadChartCases(const ChartOptions& options,
                                      std::vector<std::string>* remarks) {
  std::vector<ChartCase> cases;
  if (!options.cases.empty()) {
    for (const std::string& scene : options.cases) cases.push_back(LoadChartCase(options, scene));
    return cases;
  }
  for (const std::string& scene : ScenesIn("scenes/cases")) {
    try {
      cases.push_back(LoadChartCase(options, scene));
    } catch (const InputError& error) {
      remarks->push_back(std::string("left out: ") + error.what());
    }
  }
  if (cases.empty()) throw InputError("scenes/cases: " + remarks->front());
  return cases;
}

void ChartCracks(const ChartOptions& options) {
  MakeOutFolder(options.out);
  MeasureCracks(options.out, options.quick,
                [](const std::string& row) { std::cout << row << std::endl; });
  std::cout << options.out << ": cracks.md\n";
}

void Chart(const ChartOptions& options) {
  const std::vector<ChartFamily> families = ChartFamilies(options.quick, options.only);
  if (families.empty()) {
    throw InputError("--only: --quick leaves out all of these groups; remove --quick");
  }
  std::vector<std::string> remarks;
  const std::vector<ChartCase> cases = LoadChartCases(options, &remarks);
  const fs::path out(options.out);
  MakeOutFolder(options.out);

  const MachineFacts machine = ThisMachine();
  std::vector<ChartPoint> points;
  for (const ChartCase& each : cases) {
    const ChartSweep sweep =
        SweepCase(each.load_case, each.reference, families, [](const ChartPoint& point) {
          std::fprintf(stderr, "%s: %s: %.1f %%, %.0f us\n", point.load_case.c_str(),
                       Describe(point).c_str(), 100 * point.error, point.StepMicroseconds());
        });
    points.insert(points.end(), sweep.points.begin(), sweep.points.end());
    remarks.insert(remarks.end(), sweep.remarks.begin(), sweep.remarks.end());
  }

  WriteTextFile(out / "chart.csv",
                ChartCsv(points, {"processor: " + machine.processor,
                                  "compiler: " + machine.compiler, "flags: " + machine.flags,
                                  "threads: 1, load before: " + Format("%.2g", machine.load)}));
  WriteTextFile(out / "chart.md", ChartMarkdown(points, ToText(machine)));
  Json report = {{"machine", ToJson(machine)}, {"points", Json::array()}, {"remarks", remarks}};
  for (const ChartPoint& point : points) report["points"].push_back(ToJson(point));
  WriteTextFile(out / "chart.json", JsonText(report) + "\n");
  const std::string no_plot = RunPlotScript(
      kPlotChartScript,
      {(out / "chart.csv").string(), (out / "chart.png").string(), (out / "chart.svg").string()});
  if (!no_plot.empty()) remarks.push_back(no_plot);
  if (options.json) {
    std::cout << JsonText(report) << "\n";
  } else {
    std::cout << ChartText(points) << ToText(machine) << "\n"
              << out.string() << ": chart.csv, chart.json, chart.md"
              << (no_plot.empty() ? ", chart.png, chart.svg\n" : "\n");
  }
  for (const std::string& remark : remarks) std::fprintf(stderr, "hpdm: %s\n", remark.c_str());
}

}  // namespace

void AddChartCommand(Command app) {
  const auto options = std::make_shared<ChartOptions>();
  Command chart = app.AddCommand("chart", "Chart the error and step time of every model");
  chart.AddOption("cases", options->cases,
                  "Scene files with [[load]] tables; default: all of scenes/cases");
  chart.AddOption(
      "--references", options->references,
      "Folder of NAME.csv and NAME.json; default: ../../tests/reference from each case");
  chart.AddOption("--out", options->out, "Folder to write to; created if missing").Required();
  chart.AddOption("--only", options->only, "Measure only models of these groups")
      .SplitAt(',')
      .OneOf(ChartGroups());
  chart.AddFlag("--json", options->json, "Print JSON");
  chart.AddFlag("--quick", options->quick, "Measure a few models only");
  chart.AddFlag("--cracks", options->cracks,
                "Measure bodies with a crack against closed forms instead, into cracks.md");
  chart.OnRun([options] { options->cracks ? ChartCracks(*options) : Chart(*options); });
}

}  // namespace hpdm
