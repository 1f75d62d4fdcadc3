// The other commands end to end.

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "tests/support/flow_fixture.h"
#include "tests/support/liver_scene.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class Commands : public Flow {};

TEST_F(Commands, LoadsOnARigidOrganAreRefused) {
  std::ofstream(folder_ / "rigid.toml")
      << "[[organ]]\nname = \"stomach\"\nmodel = \"rigid\"\nmesh = \""
      << (kSource / "scenes/meshes/stomach_2132.obj").string()
      << "\"\n[[load]]\norgan = \"stomach\"\npoint = [0, 0, 0.05]\nradius = 0.1\n"
         "force = [0, 0, -1]\n";
  const Outcome outcome = Hpdm("solve " + Folder("rigid.toml") + " --out " + Folder("f.csv"));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("organ \"stomach\" is rigid"), std::string::npos) << outcome.err;
}

TEST_F(Commands, CheckSaysWhatWouldBeBuilt) {
  const Outcome outcome = Hpdm("check --json " + kScene);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json facts = Json::parse(outcome.out);
  const Json& liver = facts["organs"][0];
  EXPECT_EQ(liver["triangles"], 5000);
  EXPECT_NEAR(liver["tissue_volume_m3"].get<double>(), 1.5e-3, 0.05e-3);
  EXPECT_GT(liver["control_points"], 100);
  EXPECT_LT(liver["control_points"], 512);
}

// The lattice's promise: no worse than linear tetrahedra of about 4,000 nodes on solid organs.
TEST_F(Commands, SolveIsNoWorseThanThousandsOfLinearTetrahedra) {
  for (const std::string name : {"liver_press", "liver_lift", "beam"}) {
    const std::string reference = (kSource / "tests" / "reference" / name).string();
    const Outcome outcome =
        Hpdm("solve --json " + (kSource / "scenes" / "cases" / name).string() + ".toml --out " +
             Folder(name + ".csv") + " --reference " + reference + ".csv");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const Json results = Json::parse(outcome.out);
    for (const Json& linear : Json::parse(ReadFile(reference + ".json"))["linear"]) {
      if (linear["nodes"] < 3500 || linear["nodes"] > 4500) continue;
      EXPECT_LT(results["error"], linear["error"]) << name;
    }
    EXPECT_LT(results["control_points"], 250);
    EXPECT_LT(results["residual"], 1e-9);
    EXPECT_GT(results["compliance_m_per_N"], 0);
    EXPECT_GT(results["setup_ms"], 0);
    EXPECT_GT(results["step_us"], 0);
    EXPECT_EQ(ReadFile(folder_ / (name + ".csv")).substr(0, 15), "x,y,z,ux,uy,uz\n");
  }
}

TEST_F(Commands, CheckReportsTheMetricEnergysErrorAndNoneForStrain) {
  for (const bool metric : {true, false}) {
    std::ofstream(folder_ / "s.toml") << (metric ? kMetricLiver : kLiver);
    const Outcome outcome = Hpdm("check " + Folder("s.toml"));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    int lines = 0;
    std::istringstream out(outcome.out);
    for (std::string line; std::getline(out, line);) {
      const bool says = line.starts_with("note: organ \"liver\": energy.type = \"metric\"") &&
                        line.find("51 to 91 %") != std::string::npos;
      EXPECT_EQ(says, line.find("metric") != std::string::npos) << line;
      lines += says;
    }
    EXPECT_EQ(lines, metric);
    const Json facts = Json::parse(Hpdm("check --json " + Folder("s.toml")).out);
    int notes = 0;
    for (const Json& remark : facts["remarks"]) {
      notes += remark.get<std::string>().find("51 to 91 %") != std::string::npos;
    }
    EXPECT_EQ(notes, metric);
    const Json& organ_facts = facts["organs"][0];
    EXPECT_EQ(organ_facts.contains("local_functions"), !metric);
    for (const char* key : {"refinement_functions", "local_candidates"}) {
      EXPECT_EQ(organ_facts.contains(key), !metric) << key;
    }
    for (const char* key : {"refinement_bytes", "local_bytes"}) {
      EXPECT_EQ(organ_facts["cost"].contains(key), !metric) << key;
    }
  }
}

TEST_F(Commands, AGeneratedAnatomyIsASoundScene) {
  const Outcome made = Hpdm("generate --anatomy short_duct --seed 4 --out " + Folder("anatomy"));
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const Outcome check = Hpdm("check --json " + Folder("anatomy/anatomy.toml"));
  ASSERT_EQ(check.exit_code, 0) << check.err;
  const Json facts = Json::parse(check.out);
  EXPECT_EQ(facts["organs"].size(), 6);
  EXPECT_EQ(facts["attachments"].size(), 2) << "bed and leaf";
  EXPECT_EQ(facts["ducts"].size(), 2);
  EXPECT_EQ(Hpdm("generate --seed 4 --out " + Folder("none")).exit_code, 2) << "of no anatomy";
  EXPECT_FALSE(fs::exists(folder_ / "none"));
}

TEST_F(Commands, InspectStatesTheFactsOfAMesh) {
  const Outcome outcome =
      Hpdm("inspect --json " + (kSource / "scenes" / "meshes" / "liver_274.obj").string());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json facts = Json::parse(outcome.out);
  EXPECT_EQ(facts["triangles"], 274);
  EXPECT_EQ(facts["vertices"], 139);
  EXPECT_EQ(facts["boundary_edges"], 0);
  EXPECT_EQ(facts["nonmanifold_edges"], 0);
  EXPECT_EQ(facts["components"], 1);
  EXPECT_NEAR(facts["volume_m3"].get<double>(), 1.5e-3, 0.1e-3);
  EXPECT_TRUE(facts.contains("repairs"));
}

TEST_F(Commands, InstalledEngineCanBeEmbedded) {
  const std::string prefix = Folder("prefix"), build = Folder("embed");
  const auto shell = [&](const std::string& command) {
    return std::system((command + " >>" + Folder("log") + " 2>&1").c_str());
  };
  ASSERT_EQ(shell("cmake --install " HPDM_BINARY_DIR " --prefix " + prefix), 0)
      << ReadFile(folder_ / "log");
  for (const char* file :
       {"lcmtypes/device.lcm", "lcmtypes/force.lcm", "scenes/scene.schema.json"}) {
    EXPECT_TRUE(std::filesystem::exists(prefix + "/share/hpdm/" + file)) << file;
  }
  ASSERT_EQ(shell("cmake -S " + (kSource / "tests" / "embed").string() + " -B " + build +
                  " -DCMAKE_PREFIX_PATH=" + prefix + " -DCMAKE_CXX_FLAGS='" HPDM_LINK_FLAGS "'"),
            0)
      << ReadFile(folder_ / "log");
  ASSERT_EQ(shell("cmake --build " + build), 0) << ReadFile(folder_ / "log");
  ASSERT_EQ(shell(build + "/embed " + prefix + "/share/hpdm/scenes/meshes/liver_274.obj"), 0)
      << ReadFile(folder_ / "log");
}

}  // namespace
}  // namespace hpdm
