#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <iterator>
#include <memory>
#include <system_error>

#include "engine/base/error.h"
#include "engine/base/text_list.h"
#include "scenes/generator/meshing/obj_writer.h"
#include "tools/command_line.h"
#include "tools/commands.h"
#include "tools/haptics/accuracy_cases.h"
#include "tools/haptics/accuracy_report.h"
#include "tools/haptics/contact_tables.h"
#include "tools/haptics/force_accuracy.h"
#include "tools/haptics/organ_tables.h"
#include "tools/haptics/shipped_contacts.h"
#include "tools/haptics/stability_map.h"
#include "tools/haptics/tip_accuracy.h"
#include "tools/haptics/tissue_tables.h"
#include "tools/haptics/transparency.h"
#include "tools/haptics/z_width.h"
#include "tools/plots/plot_force_accuracy.h"
#include "tools/plots/plot_transparency.h"
#include "tools/plots/plot_z_width.h"
#include "tools/plots/python_plot.h"
#include "tools/shared/child_process.h"
#include "tools/shared/json_text.h"
#include "tools/shared/staged_file.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// Parts of --only besides the cases of the accuracy.
constexpr const char* kContacts = "contacts";
constexpr const char* kOrgans = "organs";
constexpr const char* kShaft = "shaft";
constexpr const char* kTissue = "tissue";
constexpr const char* kZWidth = "z-width";
constexpr const char* kTransparency = "transparency";
constexpr const char* kParts[] = {kContacts, kOrgans, kShaft, kTissue, kZWidth, kTransparency};

struct HapticsOptions {
  std::string scene = "scenes/two_hands.toml";
  std::string out = "out/haptics";
  std::vector<std::string> only;
  int haptic_hz = 0;     // 0: the scenes'
  double delay_ms = -1;  // below 0: the scenes'
  bool quick = false;
  bool json = false;

  // Named parts are for tuning: only they are measured.
  bool Whole() const { return only.empty(); }
  bool Measures(const char* part) const {
    return Whole() || std::find(only.begin(), only.end(), part) != only.end();
  }
};

constexpr const char* kTipCases[] = {"liver_press_tip_5mm", "liver_press_tip_2_5mm"};

// Returns the cases to measure. Refuses unknown names, so that a typing error does not measure
// nothing.
std::vector<AccuracyCase> ChosenCases(const HapticsOptions& options) {
  std::vector<AccuracyCase> cases = AccuracyCases(LoadScene(options.scene), options.quick);
  if (options.Whole()) return cases;
  std::vector<AccuracyCase> chosen;
  for (const std::string& name : options.only) {
    if (std::find(std::begin(kParts), std::end(kParts), name) != std::end(kParts)) continue;
    const auto at = std::find_if(cases.begin(), cases.end(),
                                 [&](const AccuracyCase& each) { return each.name == name; });
    if (at == cases.end()) {
      std::string names;
      for (const AccuracyCase& each : cases) AppendToList(each.name, &names);
      for (const char* part : kParts) AppendToList(part, &names);
      throw InputError("--only: unknown case \"" + name + "\"; choose from " + names);
    }
    chosen.push_back(*at);
  }
  return chosen;
}

// Measures the load cases beside the scene that have reference solutions. Missing ones are left
// out. Each costs about a second.
std::vector<TipAccuracy> MeasureTips(const fs::path& scenes) {
  std::vector<TipAccuracy> tips;
  for (const char* name : kTipCases) {
    try {
      const StaticCase load_case = LoadStaticCase((scenes / "cases" / name).string() + ".toml");
      const CaseReference reference = LoadCaseReference(load_case, scenes / "../tests/reference");
      for (const int local_functions : {0, 27}) {
        tips.push_back(MeasureTipAccuracy(load_case, reference, local_functions));
      }
    } catch (const InputError& error) {
      std::fprintf(stderr, "hpdm: note: left out: %s\n", error.what());
    }
  }
  return tips;
}

std::vector<HandAccuracy> MeasureHands(const std::vector<AccuracyCase>& cases, const fs::path& out,
                                       bool quiet) {
  std::vector<HandAccuracy> hands;
  if (!quiet) std::cout << AccuracyHead() << std::flush;
  for (const AccuracyCase& each : cases) {
    const ForceAccuracy accuracy = MeasureForceAccuracy(each.scene, each.seconds);
    if (accuracy.unfinished_steps > 0) {
      std::fprintf(stderr,
                   "hpdm: note: %s: %d steps of the reference spent their iterations; largest "
                   "residual %.1e\n",
                   each.name.c_str(), accuracy.unfinished_steps, accuracy.residual);
    }
    if (accuracy.unsolved > 0) {
      std::fprintf(stderr, "hpdm: note: %s: %d searches of the reference found no sound place\n",
                   each.name.c_str(), accuracy.unsolved);
    }
    for (std::size_t i = 0; i < accuracy.results.size(); ++i) {
      const ForceResults& results = accuracy.results[i];
      hands.push_back(
          {each.name, results, "force_" + each.name + "_" + results.instrument + ".csv"});
      WriteTextFile(out / hands.back().series,
                    TimeSeriesTable(accuracy.time_series[i], accuracy.rate_hz));
      if (!quiet) std::cout << AccuracyRow(hands.back()) << std::flush;
    }
  }
  return hands;
}

// Measures the accuracy of the force. Writes force_accuracy.json and .md, force_*.csv and two
// pictures.
Json MeasureForces(const HapticsOptions& options, const std::vector<AccuracyCase>& cases) {
  const fs::path out(options.out);
  std::vector<TipAccuracy> tips;
  if (options.Whole()) tips = MeasureTips(fs::path(options.scene).parent_path());
  const std::vector<HandAccuracy> hands = MeasureHands(cases, out, options.json);
  const Json report = AccuracyJson(hands, tips);
  WriteTextFile(out / "force_accuracy.json", JsonText(report) + "\n");
  WriteTextFile(out / "force_accuracy.md", AccuracyMarkdown(hands, tips));
  if (!options.json) std::cout << AccuracyTips(tips) << std::flush;
  const std::string no_plot =
      RunPlotScript(kPlotForceAccuracyScript,
                    {(out / "force_accuracy.json").string(), (out / "force_courses.png").string(),
                     (out / "force_errors.png").string()});
  if (!no_plot.empty()) std::fprintf(stderr, "hpdm: note: %s\n", no_plot.c_str());
  return report;
}

// Measures the tables of a part of contacts. Writes PART.md.
template <class Measure>
Json MeasureTables(const HapticsOptions& options, const std::string& part, const Measure& measure) {
  std::string markdown;
  const auto done = [&](const ContactTable& table) {
    markdown += (markdown.empty() ? "" : "\n") + TableMarkdown(table);
    if (!options.json) std::cout << TableText(table) << "\n" << std::flush;
  };
  const std::vector<ContactTable> tables = measure(done);
  WriteTextFile(fs::path(options.out) / (part + ".md"), markdown);
  return TablesJson(tables);
}

// Prints tables and returns them as Markdown.
std::string ShowTables(const std::vector<ContactTable>& tables, bool quiet) {
  std::string markdown;
  for (const ContactTable& table : tables) {
    markdown += (markdown.empty() ? "" : "\n") + TableMarkdown(table);
    if (!quiet) std::cout << TableText(table) << "\n" << std::flush;
  }
  return markdown;
}

void DrawDisplay(const char* script, const fs::path& table) {
  fs::path picture = table;
  const std::string no_plot =
      RunPlotScript(script, {table.string(), picture.replace_extension(".png").string()});
  if (!no_plot.empty()) std::fprintf(stderr, "hpdm: note: %s\n", no_plot.c_str());
}

// Measures how the device displays the contacts of the shipped scenes beside the scene: the largest
// stable stiffness (z_width.csv, .md, .png) and the transparency (transparency.csv, .md, .png).
void MeasureDisplay(const HapticsOptions& options, Json* report) {
  const fs::path out(options.out), scenes = fs::path(options.scene).parent_path();
  std::vector<ZWidthPoint> widths;
  std::vector<Transparency> transparencies;
  for (const char* name : {"liver_palpation.toml", "two_hands.toml", "abdomen_on_springs.toml"}) {
    if (options.quick && name != std::string("liver_palpation.toml")) break;
    std::shared_ptr<const Session> session;
    try {
      session = ContactSession(scenes / name, options.haptic_hz, 1e-3 * options.delay_ms);
    } catch (const InputError& error) {
      std::fprintf(stderr, "hpdm: note: left out: %s\n", error.what());
      continue;
    }
    for (const ShippedContact& contact : FindContacts(session)) {
      if (options.Measures(kZWidth)) {
        const std::vector<ZWidthPoint> points = MeasureZWidth(contact, options.quick);
        widths.insert(widths.end(), points.begin(), points.end());
      }
      if (!options.Measures(kTransparency)) continue;
      const std::vector<Transparency> measured = MeasureTransparency(
          contact, TransparencyConditions(contact), TransparencyFrequencies(options.quick));
      transparencies.insert(transparencies.end(), measured.begin(), measured.end());
    }
  }
  if (options.Measures(kZWidth)) {
    const std::vector<ContactTable> tables = ZWidthTables(widths);
    WriteTextFile(out / "z_width.md", ShowTables(tables, options.json));
    WriteZWidthCsv(widths, out / "z_width.csv");
    DrawDisplay(kPlotZWidthScript, out / "z_width.csv");
    (*report)["z_width"] = TablesJson(tables);
  }
  if (options.Measures(kTransparency)) {
    const std::vector<ContactTable> tables = TransparencyTables(transparencies);
    WriteTextFile(out / "transparency.md", ShowTables(tables, options.json));
    WriteTransparencyCsv(transparencies, out / "transparency.csv");
    DrawDisplay(kPlotTransparencyScript, out / "transparency.csv");
    (*report)["transparency"] = TablesJson(tables);
  }
}

// Measures the latency in a session on the real clock. It runs in a process of its own, as a user
// runs it, unaffected by this process's memory. Its folder holds latency.png.
Json MeasureLatency(const HapticsOptions& options, const fs::path& folder) {
  const std::string seconds = options.quick ? "2" : "10";
  const fs::path scene = fs::path(options.scene).parent_path() / "liver_palpation.toml";
  const int code = RunChild({"/proc/self/exe", "run", scene.string(), "--headless", "--verbose",
                             "--seconds", seconds, "--fps", "0", "--out", folder.string()},
                            options.json);
  if (code != 0) {
    std::fprintf(stderr,
                 "hpdm: note: no latency: the session ended with exit code %d; try hpdm run %s\n",
                 code, scene.c_str());
    return nullptr;
  }
  std::ifstream file(folder / "summary.json");
  const Json summary = Json::parse(file);
  if (!options.json) {
    std::printf("Tick compute p99 %.1f us (at most 20, aim 7).\n",
                summary["haptic"]["compute"]["p99_us"].get<double>());
  }
  return summary;
}

// Measures the largest stable stiffness. Writes stability.csv and .png.
Json MeasureBoundary(const HapticsOptions& options) {
  const StabilityMap map = MeasureStability({.quick = options.quick});
  const std::string no_plot = WriteStability(map, options.out);
  if (!no_plot.empty()) std::fprintf(stderr, "hpdm: note: %s\n", no_plot.c_str());
  const double deviation = LargestDeviation(map);
  if (!options.json) {
    std::printf("Stability boundary without friction within %.2f %% of the exact roots.\n",
                100 * deviation);
  }
  return {{"table", "stability.csv"}, {"deviation_from_roots", deviation}};
}

void Haptics(const HapticsOptions& options) {
  const std::vector<AccuracyCase> cases = ChosenCases(options);
  const fs::path out(options.out), session = out / "latency";
  std::error_code error;
  if (options.Whole() && fs::exists(session, error)) {
    throw InputError(session.string() + ": already holds a session; choose another --out");
  }
  MakeOutFolder(options.out);
  Json report = Json::object();
  if (!cases.empty()) report["force_accuracy"] = MeasureForces(options, cases);
  if (options.Measures(kContacts)) {
    report["contacts"] = MeasureTables(
        options, kContacts, [&](const auto& done) { return MeasureContacts(options.quick, done); });
  }
  if (options.Measures(kOrgans)) {
    report["organs"] = MeasureTables(options, kOrgans, [&](const auto& done) {
      return MeasureOrganContacts(fs::path(options.scene).parent_path(), options.quick, done);
    });
  }
  if (options.Measures(kShaft)) {
    report["shaft"] = MeasureTables(
        options, kShaft, [&](const auto& done) { return MeasureShaft(options.quick, done); });
  }
  if (options.Measures(kTissue)) {
    report["tissue"] = MeasureTables(
        options, kTissue, [&](const auto& done) { return MeasureTissue(options.quick, done); });
  }
  if (options.Measures(kZWidth) || options.Measures(kTransparency)) {
    MeasureDisplay(options, &report);
  }
  if (options.Whole()) report["stability"] = MeasureBoundary(options);
  if (options.Whole()) report["latency"] = MeasureLatency(options, session);
  WriteTextFile(out / "haptics.json", JsonText(report) + "\n");
  if (options.json) {
    std::cout << JsonText(report) << "\n";
  } else {
    std::cout << out.string() << ": haptics.json"
              << (cases.empty() ? "" : ", force_accuracy.md, force_courses.png, force_errors.png")
              << (options.Measures(kContacts) ? ", contacts.md" : "")
              << (options.Measures(kOrgans) ? ", organs.md" : "")
              << (options.Measures(kShaft) ? ", shaft.md" : "")
              << (options.Measures(kTissue) ? ", tissue.md" : "")
              << (options.Measures(kZWidth) ? ", z_width.png" : "")
              << (options.Measures(kTransparency) ? ", transparency.png" : "")
              << (options.Whole() ? ", stability.png, latency/\n" : "\n");
  }
}

}  // namespace

void AddHapticsCommand(Command app) {
  const auto options = std::make_shared<HapticsOptions>();
  Command haptics = app.AddCommand(
      "haptics", "Measure and plot the force on the hand: accuracy, contacts, stability, latency");
  haptics
      .AddOption("scene", options->scene,
                 "Scene with two instruments; uses the load cases beside it")
      .ShowDefault();
  haptics.AddOption("--out", options->out, "Folder to write to; created if missing").ShowDefault();
  haptics.AddOption(
      "--only", options->only,
      "Measure only the accuracy of these cases, such as press, or contacts, organs, shaft, "
      "tissue, z-width, transparency");
  haptics
      .AddOption("--haptic-hz", options->haptic_hz,
                 "Ticks a second for z-width and transparency (default: the scenes')")
      .From(100, 10000);
  haptics
      .AddOption("--delay-ms", options->delay_ms,
                 "Delay of their devices beyond the hold (default: the scenes')")
      .From(0, 10);
  haptics.AddFlag("--quick", options->quick,
                  "Small strain only, fewer contacts, shorter motions and session");
  haptics.AddFlag("--json", options->json, "Print JSON");
  haptics.OnRun([options] { Haptics(*options); });
}

}  // namespace hpdm
