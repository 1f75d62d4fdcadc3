#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <memory>
#include <system_error>

#include "engine/error.h"
#include "scenes/obj_writer.h"
#include "tools/commands.h"
#include "tools/json_figures.h"
#include "tools/machine_facts.h"
#include "tools/plot_stress.h"
#include "tools/python_plot.h"
#include "tools/stress/stress_cases.h"
#include "tools/stress/stress_report.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kRounds = 6;  // a boundary to 1/64 of its bracket
constexpr int kQuickRounds = 2;

struct StressOptions {
  std::vector<std::string> only;
  std::string out;
  bool json = false;
  bool quick = false;
  bool list = false;
};

std::vector<StressCase> AllCases(bool quick) {
  std::vector<StressCase> all;
  for (std::vector<StressCase> group :
       {MaterialStress(quick), ContactStress(quick), MotionStress(quick), HapticStress(quick)}) {
    std::move(group.begin(), group.end(), std::back_inserter(all));
  }
  return all;
}

std::vector<StressCase> Chosen(std::vector<StressCase> all, const std::vector<std::string>& only) {
  if (only.empty()) return all;
  for (const std::string& name : only) {
    const bool known = std::any_of(all.begin(), all.end(), [&](const StressCase& each) {
      return each.name == name || each.group == name;
    });
    if (!known) {
      throw InputError("--only " + name +
                       ": is no case and no group; hpdm stress --list names all");
    }
  }
  std::erase_if(all, [&](const StressCase& each) {
    return std::find(only.begin(), only.end(), each.name) == only.end() &&
           std::find(only.begin(), only.end(), each.group) == only.end();
  });
  return all;
}

// Of what was written, the names; a picture that could not be drawn is a remark.
std::string Write(const fs::path& out, const std::vector<StressRow>& rows, const Json& report,
                  std::string* remark) {
  WriteTextFile(out / "stress.csv", StressCsv(rows));
  WriteTextFile(out / "stress.md", StressMarkdown(rows));
  WriteTextFile(out / "stress.json", JsonText(report) + "\n");
  *remark = RunPlotScript(kPlotStressScript,
                          {(out / "stress.csv").string(), (out / "stress.png").string()});
  return out.string() + ": stress.csv, stress.json, stress.md" +
         (remark->empty() ? ", stress.png\n" : "\n");
}

void Stress(const StressOptions& options) {
  const std::vector<StressCase> cases = Chosen(AllCases(options.quick), options.only);
  if (options.list) {
    for (const StressCase& each : cases) {
      std::cout << each.name << " (" << each.group << "): " << each.title << "\n";
    }
    return;
  }
  if (!options.out.empty()) {
    std::error_code error;
    fs::create_directories(options.out, error);
    if (error) {
      throw InputError(options.out + ": cannot be created (" + error.message() +
                       "); choose another --out");
    }
  }
  const MachineFacts machine = ThisMachine();
  std::vector<StressRow> rows;
  for (const StressCase& each : cases) {
    rows.push_back({each, {}});
    for (const StressModel model : each.models) {
      rows.back().results.push_back(Examine(each, model, options.quick ? kQuickRounds : kRounds));
    }
    if (!options.json) std::cout << StressText(rows.back()) << std::flush;
  }
  const std::vector<std::string> harms = Harms(rows);
  Json report = {{"machine", ToJson(machine)}, {"cases", Json::array()}, {"harms", harms}};
  for (const StressRow& row : rows) report["cases"].push_back(ToJson(row));
  std::string written, remark;
  if (!options.out.empty()) written = Write(options.out, rows, report, &remark);
  std::cout << (options.json ? JsonText(report) + "\n" : written);
  if (!remark.empty()) std::fprintf(stderr, "hpdm: %s\n", remark.c_str());
  for (const std::string& harm : harms) std::fprintf(stderr, "hpdm: %s\n", harm.c_str());
  if (!harms.empty()) throw CLI::RuntimeError(1);
}

}  // namespace

void AddStressCommand(CLI::App& app) {
  const auto options = std::make_shared<StressOptions>();
  CLI::App* stress =
      app.add_subcommand("stress", "Go where methods fail, and say which fails where");
  stress->add_option("--only", options->only, "These cases or groups alone");
  stress->add_option("--out", options->out,
                     "Folder for the table and the picture; made if missing");
  stress->add_flag("--json", options->json, "Print JSON");
  stress->add_flag("--quick", options->quick, "Smaller bodies, coarser boundaries");
  stress->add_flag("--list", options->list, "Name the cases and end");
  stress->callback([options] { Stress(*options); });
}

}  // namespace hpdm
