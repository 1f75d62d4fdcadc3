#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <future>
#include <iostream>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <thread>

#include "engine/base/error.h"
#include "scenes/generator/meshing/obj_writer.h"
#include "tools/command_line.h"
#include "tools/commands.h"
#include "tools/plots/plot_stress.h"
#include "tools/plots/python_plot.h"
#include "tools/shared/json_text.h"
#include "tools/shared/machine_facts.h"
#include "tools/shared/staged_file.h"
#include "tools/stress/stress_cases.h"
#include "tools/stress/stress_report.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kRounds = 6;  // locates a boundary to 1/64 of its bracket
constexpr int kQuickRounds = 2;

struct StressOptions {
  std::vector<std::string> only;
  std::string out;
  bool json = false;
  bool quick = false;
  bool list = false;
  double random_seconds = 20;
};

std::vector<StressCase> AllCases(const StressOptions& options) {
  const bool quick = options.quick;
  std::vector<StressCase> all;
  for (std::vector<StressCase> group :
       {MaterialStress(quick), ContactStress(quick), MotionStress(quick), HapticStress(quick),
        TouchStress(quick, options.random_seconds), OrganStress(quick), PartStress(quick)}) {
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
      throw InputError("--only: unknown case or group \"" + name +
                       "\"; hpdm stress --list names all");
    }
  }
  std::erase_if(all, [&](const StressCase& each) {
    return std::find(only.begin(), only.end(), each.name) == only.end() &&
           std::find(only.begin(), only.end(), each.group) == only.end();
  });
  return all;
}

// Examines all cases. They share nothing, so as many run at a time as there are processors. Each is
// reported in its turn.
std::vector<StressRow> ExamineAll(const std::vector<StressCase>& cases,
                                  const StressOptions& options) {
  std::vector<StressRow> rows;
  for (const StressCase& each : cases) rows.push_back({each, {}});
  std::vector<bool> done(cases.size(), false);
  std::size_t next = 0, reported = 0;
  std::mutex mutex;  // guards all of the above except the row that a worker fills
  const auto work = [&] {
    for (std::unique_lock lock(mutex); next < rows.size();) {
      const std::size_t mine = next++;
      lock.unlock();
      for (const StressModel model : cases[mine].models) {
        rows[mine].results.push_back(
            Examine(cases[mine], model, options.quick ? kQuickRounds : kRounds));
      }
      lock.lock();
      done[mine] = true;
      for (; reported < rows.size() && done[reported]; ++reported) {
        if (!options.json) std::cout << StressText(rows[reported]) << std::flush;
      }
    }
  };
  std::vector<std::future<void>> workers;
  for (unsigned i = 0; i < std::max(1u, std::thread::hardware_concurrency()); ++i) {
    workers.push_back(std::async(std::launch::async, work));
  }
  for (std::future<void>& worker : workers) worker.get();
  return rows;
}

// Writes the results. Returns the names of the files; a picture that could not be drawn is a
// remark.
std::string Write(const fs::path& out, const std::vector<StressRow>& rows, const Json& report,
                  std::string* remark) {
  WriteTextFile(out / "stress.csv", StressCsv(rows));
  WriteTextFile(out / "stress.md", StressMarkdown(rows));
  std::map<std::string, std::vector<StressRow>> groups;
  for (const StressRow& row : rows) groups[row.stress_case.group].push_back(row);
  for (const auto& [group, of_group] : groups) {
    WriteTextFile(out / (group + ".md"), StressMarkdown(of_group));
  }
  WriteTextFile(out / "stress.json", JsonText(report) + "\n");
  *remark = RunPlotScript(kPlotStressScript,
                          {(out / "stress.csv").string(), (out / "stress.png").string()});
  return out.string() + ": stress.csv, stress.json, stress.md, GROUP.md" +
         (remark->empty() ? ", stress.png\n" : "\n");
}

void Stress(const StressOptions& options) {
  const std::vector<StressCase> cases = Chosen(AllCases(options), options.only);
  if (options.list) {
    for (const StressCase& each : cases) {
      std::cout << each.name << " (" << each.group << "): " << each.title << "\n";
    }
    return;
  }
  if (!options.out.empty()) MakeOutFolder(options.out);
  const MachineFacts machine = ThisMachine();
  const std::vector<StressRow> rows = ExamineAll(cases, options);
  const std::vector<std::string> harms = Harms(rows);
  Json report = {{"machine", ToJson(machine)}, {"cases", Json::array()}, {"harms", harms}};
  for (const StressRow& row : rows) report["cases"].push_back(ToJson(row));
  std::string written, remark;
  if (!options.out.empty()) written = Write(options.out, rows, report, &remark);
  std::cout << (options.json ? JsonText(report) + "\n" : written);
  if (!remark.empty()) std::fprintf(stderr, "hpdm: %s\n", remark.c_str());
  for (const std::string& harm : harms) std::fprintf(stderr, "hpdm: %s\n", harm.c_str());
  if (!harms.empty()) throw CheckFailed();
}

}  // namespace

void AddStressCommand(Command app) {
  const auto options = std::make_shared<StressOptions>();
  Command stress =
      app.AddCommand("stress", "Raise difficulty until methods fail, and report each boundary");
  stress.AddOption("--only", options->only, "Run only these cases or groups");
  stress.AddOption("--out", options->out,
                   "Folder for the table and the picture; created if missing");
  stress
      .AddOption("--random-seconds", options->random_seconds,
                 "Length of random motions, in virtual time; 3600 takes minutes for each trial")
      .ShowDefault()
      .From(5, 36000);
  stress.AddFlag("--json", options->json, "Print JSON");
  stress.AddFlag("--quick", options->quick, "Smaller bodies, coarser boundaries");
  stress.AddFlag("--list", options->list, "List the cases and exit");
  stress.OnRun([options] { Stress(*options); });
}

}  // namespace hpdm
