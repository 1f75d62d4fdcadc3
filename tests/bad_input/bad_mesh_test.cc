#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>

#include "tests/bad_input/bad_input.h"
#include "tests/bad_input/bounded_program.h"
#include "tests/bad_input/meshes/mesh_faults.h"
#include "tests/support/scratch_folder.h"

// Reads every file of tests/bad_input/meshes.csv (README.md there) with `hpdm inspect`. An accepted
// file is checked as an organ (`hpdm check`), in bounded memory and time.
namespace hpdm {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::uint32_t kSeed = 7;

/// The outcome of a file, in the table's words.
struct Found {
  std::string outcome, what;
};

/// A refusal is one line on standard error that names the file and a remedy, without control
/// characters or other output.
std::string Refusal(const BoundedOutcome& run) {
  const std::string line = run.err.substr(0, run.err.find('\n'));
  EXPECT_EQ(line.size() + 1, run.err.size()) << "not one line: " << run.err.substr(0, 1000);
  EXPECT_TRUE(std::none_of(line.begin(), line.end(),
                           [](char c) { return (c >= 0 && c < ' ') || c == '\x7f'; }));
  EXPECT_EQ(line.rfind("hpdm: ", 0), 0u) << line;
  EXPECT_NE(line.find("; "), std::string::npos) << "no remedy: " << line;
  EXPECT_EQ(run.out, "");
  return line;
}

bool Ended(const BoundedOutcome& run) {
  EXPECT_EQ(run.signal, 0) << "a crash, or too much memory or time";
  EXPECT_TRUE(run.exit_code == 0 || run.exit_code == 2) << run.exit_code << ": " << run.err;
  return run.signal == 0 && (run.exit_code == 0 || run.exit_code == 2);
}

/// Returns the scene's line that makes the mesh 0.2 m across, or "" if it has an organ's size or no
/// unit that a scene takes does so.
std::string UnitOfOrgan(const Json& facts) {
  constexpr double kMinAcross = 1e-3, kMaxAcross = 0.46;  // m; 0.46 m is a cube of 0.1 m^3
  double across = 0;
  for (int d = 0; d < 3; ++d) {
    const double side = facts["box_max_m"][d].get<double>() - facts["box_min_m"][d].get<double>();
    across = std::max(across, side);
  }
  constexpr double kMaxUnit = 1000;  // m, of a scene
  if (across >= kMinAcross && across <= kMaxAcross) return "";
  if (0.2 / across > kMaxUnit) return "";
  std::ostringstream unit;
  unit << "unit = " << 0.2 / across << "\n";
  return unit.str();
}

/// Builds the mesh as an organ of each model, or expects a refusal. The lattice model, which
/// accepts open surfaces too, is also pressed. Returns the lattice's refusal or "".
std::string BuildOrgan(const std::string& mesh, const Json& facts, const fs::path& folder) {
  std::string refusal;
  for (const std::string model : {"rigid", "mass_spring", "continuum", "hpdm"}) {
    SCOPED_TRACE(model);
    const bool lattice = model == "hpdm";
    std::ofstream(folder / "scene.toml")
        << "[[organ]]\nname = 'body'\nmesh = '" << mesh << "'\nmodel = '" << model << "'\n"
        << UnitOfOrgan(facts)
        << (lattice ? "lattice.cells = [2, 2, 2]\n[[load]]\norgan = 'body'\npressure = 10\n" : "");
    BoundedRun run{.words = {"check", "--json", "scene.toml"}, .folder = folder};
    if (lattice) run.words = {"solve", "--json", "--out", "moved.csv", "scene.toml"};
    run.environment = {{"HPDM_CACHE", "off"}};
    const BoundedOutcome built = RunBounded(run);
    if (!Ended(built)) return "ended";
    refusal = built.exit_code == 2 ? Refusal(built) : "";
    EXPECT_EQ(built.out.find("null"), std::string::npos) << "not finite: " << built.out;
  }
  return refusal;
}

/// `organs`: outcomes of meshes as organs, by their facts; each is built once.
Found Find(const std::string& mesh, const fs::path& folder, bool readable,
           std::map<std::string, std::string>* organs) {
  const BoundedOutcome run = RunBounded({.words = {"inspect", "--json", "--unit", "m", mesh},
                                         .folder = folder,
                                         .environment = {{"HPDM_CACHE", "off"}},
                                         .as_nobody_else = !readable});
  if (!Ended(run)) return {"ended", ""};
  if (run.exit_code == 2) return {"refused", Refusal(run)};
  Json facts = Json::parse(run.out);
  const auto number = [&](const char* key) { return std::to_string(facts[key].get<int>()); };
  std::string what;
  for (const auto& [name, count] : facts["repairs"].items()) {
    what += (what.empty() ? "" : ", ") + name + ' ' + std::to_string(count.get<int>());
  }
  const bool repaired = !what.empty();
  what += std::string(repaired ? "; " : "") + number("vertices") + " vertices, " +
          number("triangles") + " triangles, " + number("components") +
          (facts["components"] == 1 ? " component, " : " components, ") +
          (facts["closed"] ? "closed" : "not closed");
  for (const char* key : {"volume_m3", "area_m2", "min_edge_m", "mean_edge_m"}) {
    EXPECT_TRUE(facts[key].is_number()) << key << " is not finite";
  }
  for (const char* of_the_file : {"mesh", "repairs", "as_read"}) facts.erase(of_the_file);
  const auto [organ, is_new] = organs->try_emplace(facts.dump());
  if (is_new) organ->second = BuildOrgan(mesh, facts, folder);
  const std::string& refusal = organ->second;
  return {repaired ? "repaired" : "accepted",
          what + (refusal.empty() ? "; an organ" : "; no organ: " + refusal)};
}

/// Returns the name of a file as in the table.
std::string RowName(std::string file) {
  for (char& c : file) c = c < ' ' || c == '\x7f' ? '?' : c;
  return file;
}

class BadMeshes : public testing::Test {
 protected:
  /// Compares a file with its row.
  void Compare(const std::string& row_name, const std::string& mesh, const fs::path& folder) {
    SCOPED_TRACE(row_name);
    const Found found = Find(mesh, folder, row_name != "file/unreadable.obj", &organs_);
    const auto row = rows_.find(row_name);
    if (row == rows_.end()) {
      ADD_FAILURE() << "no row: " << row_name << ',' << found.outcome << ',' << found.what;
      return;
    }
    const ExpectedOutcome expected = row->second;
    rows_.erase(row);
    EXPECT_EQ(found.outcome, expected.outcome) << found.what;
    EXPECT_TRUE(Says(found.what, expected.what))
        << "expected " << expected.what << "\nfound    " << found.what;
  }

  /// Rows of a group with which nothing was compared.
  void ExpectNoRowsLeft(const std::string& group) const {
    for (const auto& [name, row] : rows_) {
      EXPECT_FALSE(name.starts_with(group + "/")) << "no such input: " << name;
    }
  }

 private:
  static std::map<std::string, ExpectedOutcome> Rows() {
    std::map<std::string, ExpectedOutcome> rows;
    for (const ExpectedOutcome& row : ReadOutcomes("meshes")) {
      EXPECT_TRUE(rows.emplace(row.input, row).second) << "two rows: " << row.input;
    }
    return rows;
  }

  std::map<std::string, ExpectedOutcome> rows_ = Rows();
  std::map<std::string, std::string> organs_;
};

TEST_F(BadMeshes, EveryNastyFileHasTheOutcomeOfItsRow) {
  const fs::path folder = kDataFolder + "nasty";
  if (!fs::exists(folder)) GTEST_SKIP() << "no shared data: " << folder;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const ScratchFolder scratch;
    Compare("nasty/" + entry.path().filename().string(), fs::canonical(entry.path()),
            scratch.path());
  }
  ExpectNoRowsLeft("nasty");
}

struct Group {
  const char* name;
  void (*add)(MeshFaults* faults);
};
void PrintTo(const Group& group, std::ostream* out) { *out << group.name; }

constexpr Group kGroups[] = {{"shape", AddShapeFaults},
                             {"obj", AddObjFaults},
                             {"ply", AddPlyFaults},
                             {"stl", AddStlFaults},
                             {"file", AddFileFaults}};

TEST_F(BadMeshes, EveryRowBelongsToAGroup) {
  std::set<std::string> names = {"nasty"};
  for (const Group& group : kGroups) names.insert(group.name);
  for (const ExpectedOutcome& row : ReadOutcomes("meshes")) {
    EXPECT_TRUE(names.contains(row.input.substr(0, row.input.find('/')))) << row.input;
  }
}

class MadeMeshes : public BadMeshes, public testing::WithParamInterface<Group> {};

TEST_P(MadeMeshes, HaveTheOutcomesOfTheirRows) {
  const std::string group = GetParam().name;
  MeshFaults faults(kSeed);
  GetParam().add(&faults);
  for (const MeshFault& fault : faults.all()) {
    const ScratchFolder scratch;
    fault.make(scratch.path() / fault.file);
    Compare(group + "/" + RowName(fault.file), fault.file, scratch.path());
  }
  ExpectNoRowsLeft(group);
}

INSTANTIATE_TEST_SUITE_P(All, MadeMeshes, testing::ValuesIn(kGroups),
                         [](const auto& group) { return std::string(group.param.name); });

}  // namespace
}  // namespace hpdm
