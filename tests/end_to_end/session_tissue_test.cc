// Tissue, instruments and hands of whole sessions: the hpdm program on real scenes.

#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/support/flow_fixture.h"
#include "tests/support/liver_scene.h"
#include "tests/support/logged_ticks.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

TEST_F(Flow, HandFeelsTheLiverAndTheLiverIsDented) {
  SKIP_WITHOUT_EGL();
  const Outcome outcome =
      Hpdm("run " + kScene + " --clock lockstep --seconds 4 --json --out " + Folder("s"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json summary = Json::parse(outcome.out);
  EXPECT_EQ(summary, Json::parse(ReadFile(folder_ / "s" / "summary.json")));
  EXPECT_EQ(summary["haptic"]["ticks"], 4000);
  EXPECT_EQ(summary["log"]["ticks"], 4000);
  EXPECT_EQ(summary["log"]["ticks_lost"], 0);
  const Json& probe = summary["tools"][0];
  EXPECT_GT(probe["peak_force_N"], 0.3);
  EXPECT_LT(probe["peak_force_N"], 8.9);
  EXPECT_GT(probe["contact_time_s"], 0.5);
  EXPECT_GT(probe["deepest_press_m"], 0.005);
  EXPECT_LT(probe["deepest_press_m"], 0.03);
  EXPECT_GT(ReadTicks(folder_ / "s" / "session.lcmlog").largest_displacement, 0.005);
}

// Returns the first block of code of scenes/README.md, with meshes that are found from anywhere.
std::string CompleteScene() {
  std::istringstream readme(ReadFile(kSource / "scenes/README.md"));
  std::string scene, line;
  while (std::getline(readme, line)) {
    if (line.starts_with("    ")) {
      scene += line.substr(4) + "\n";
    } else if (!line.empty() && !scene.empty()) {
      break;
    }
  }
  const std::size_t mesh = scene.find("meshes/");
  return scene.insert(mesh, (kSource / "scenes").string() + "/");
}

TEST_F(Flow, TheCompleteSceneOfTheReadmeIsFeltAndCheckSaysWhatHoldsIt) {
  std::ofstream(folder_ / "s.toml") << CompleteScene();
  const Outcome check = Hpdm("check " + Folder("s.toml"));
  ASSERT_EQ(check.exit_code, 0) << check.err;
  for (const char* said :
       {"box from [-0.080, -0.102, -0.077] to [0.133, 0.068, 0.057] m", "support[0] (fixed) holds ",
        "the hand's target is [", " mm from the trocar",
        "organ \"liver\": no [[organ.support]]: its rear 30 %, y above 0.017 m, is held"}) {
    EXPECT_NE(check.out.find(said), std::string::npos) << said << "\n" << check.out;
  }
  EXPECT_EQ(check.out.find("nothing will be felt"), std::string::npos) << check.out;
  const Outcome outcome = Hpdm("run " + Folder("s.toml") +
                               " --clock lockstep --seconds 3 --fps 0 --json --out " + Folder("s"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_GT(Json::parse(outcome.out)["tools"][0]["peak_force_N"], 0.2);
}

TEST_F(Flow, SurfaceModelsRunASessionThatDentsTheOrganAndIsFelt) {
  const std::string mesh = (kSource / "scenes" / "meshes" / "liver_1332.obj").string();
  for (const std::string model : {"continuum", "mass_spring"}) {
    std::ofstream(folder_ / "s.toml")
        << "[[organ]]\nname = \"liver\"\nmesh = \"" + mesh + "\"\nmodel = \"" + model + "\"\n" + R"(
  [[organ.support]]
  box_fraction = { min = [0.0, 0.67, 0.0], max = [1.0, 1.0, 1.0] }
  fixed = true
[[instrument]]
name = "probe"
trocar = [0.05, -0.12, 0.16]
)";
    EXPECT_EQ(Hpdm("check " + Folder("s.toml")).exit_code, 0);
    const Outcome outcome =
        Hpdm("run " + Folder("s.toml") + " --clock lockstep --seconds 3 --fps 0 --json --out " +
             Folder(model));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_GT(Json::parse(outcome.out)["tools"][0]["peak_force_N"], 0.3) << model;
    EXPECT_GT(ReadTicks(folder_ / model / "session.lcmlog").largest_displacement, 0.005) << model;
  }
}

TEST_F(Flow, TwoInstrumentsShareTheLiver) {
  SKIP_WITHOUT_EGL();
  std::string text = ReadFile(kScene);
  const std::string scenes = (kSource / "scenes").string() + "/";
  for (const std::string folder : {"meshes/", "textures/"}) {
    std::size_t at = text.find(folder);
    for (; at != std::string::npos; at = text.find(folder, at + scenes.size() + 1)) {
      text.insert(at, scenes);
    }
  }
  text += Grasper("script = \"grasp_lift\"\nseed = 3\n");
  std::ofstream(folder_ / "two.toml") << text;
  const Outcome outcome = Hpdm("run " + Folder("two.toml") +
                               " --clock lockstep --seconds 6 --json --out " + Folder("s"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json tools = Json::parse(outcome.out)["tools"];
  ASSERT_EQ(tools.size(), 2u);
  for (const Json& tool : tools) EXPECT_GT(tool["contact_time_s"], 0.5) << tool["name"];
  EXPECT_GT(ReadTicks(folder_ / "s" / "session.lcmlog").grasping, 500u);
}

// Liver, hollow gallbladder and a stomach that does not deform, with what can be exchanged.
TEST_F(Flow, AbdomenIsSoundAndItsHandsWorkOnLiverAndGallbladder) {
  const std::string scene = (kSource / "scenes" / "abdomen_on_springs.toml").string();
  const Outcome check = Hpdm("check --json " + scene);
  ASSERT_EQ(check.exit_code, 0) << check.err;
  const Json facts = Json::parse(check.out);
  EXPECT_EQ(facts["remarks"], Json::array()) << "nothing in it looks wrong";
  ASSERT_EQ(facts["walls"].size(), 2u) << "of each hand at the stomach";
  for (const Json& wall : facts["walls"]) {
    EXPECT_GT(wall["median_N_per_m"].get<double>(), 2500);
    EXPECT_GT(wall["least_N_per_m"].get<double>(),
              wall["every_direction_to_N_per_m"].get<double>());
  }
  SKIP_WITHOUT_EGL();
  const Outcome outcome =
      Hpdm("run " + scene + " --clock lockstep --seconds 2.5 --fps 0 --json --out " + Folder("s"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const Json& tool : Json::parse(outcome.out)["tools"]) {
    EXPECT_GT(tool["contact_time_s"], 0.5) << tool["name"];
    EXPECT_GT(tool["peak_force_N"], 0.2) << tool["name"];
    EXPECT_LT(tool["peak_force_N"], 8) << tool["name"] << ": a trainee's range";
  }
  const LoggedTicks ticks = ReadTicks(folder_ / "s" / "session.lcmlog");
  EXPECT_EQ(ticks.count, 2500u);
  EXPECT_EQ(ticks.gaps, 0u);
  EXPECT_GT(ticks.grasping, 300u) << "the fundus";
  EXPECT_EQ(Hpdm("replay " + Folder("s")).exit_code, 0) << "the same bit for bit";
}

// Recorded two-arm teleoperation in robot coordinates: fitted to the organ, each arm presses it.
TEST_F(Flow, RecordedArmsPressTheLiverAndTheSessionLastsAsLongAsTheyDo) {
  SKIP_WITHOUT_EGL();
  const fs::path left = kSharedData / "traces" / "desk_taurus_S10_T1_left.csv";
  const fs::path right = kSharedData / "traces" / "desk_taurus_S10_T1_right.csv";
  if (!fs::exists(left)) GTEST_SKIP() << "shared test data is absent: " << left;
  std::ofstream(folder_ / "arms.toml") << kMetricLiver << R"(
  [[organ.support]]
  box_fraction = { min = [0.0, 0.67, 0.0], max = [1.0, 1.0, 1.0] }
  fixed = true
[[instrument]]
name = "left"
trocar = [0.08, -0.12, 0.16]
  [instrument.trace]
  file = ")" << left.string() << R"("
  speed = 4
[[instrument]]
name = "right"
type = "grasper"
trocar = [-0.04, -0.12, 0.16]
  [instrument.trace]
  speed = 4
)";
  const std::string device = " --device right=trace:" + right.string();
  const Outcome check = Hpdm("check --json " + Folder("arms.toml"));
  ASSERT_EQ(check.exit_code, 0) << check.err;
  const Json instruments = Json::parse(check.out)["instruments"];
  EXPECT_EQ(instruments[0]["device"], "trace:" + left.string());
  EXPECT_EQ(instruments[1]["device"], "sim");

  const Outcome outcome = Hpdm("run " + Folder("arms.toml") + device +
                               " --clock lockstep --fps 0 --json --out " + Folder("s"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json summary = Json::parse(outcome.out);
  // 28.827648 s at four times the speed; the last tick begins at or before its end.
  EXPECT_EQ(summary["haptic"]["ticks"], 7207);
  ASSERT_EQ(summary["tools"].size(), 2u);
  for (const Json& tool : summary["tools"]) {
    EXPECT_GT(tool["contact_time_s"], 0.5) << tool;
    EXPECT_GT(tool["peak_force_N"], 0.1) << tool;
  }
  for (const Json& remark : summary["remarks"]) {
    if (remark.get<std::string>().find(": plays ") == std::string::npos) continue;
    EXPECT_NE(remark.get<std::string>().find("1 gap, the longest 1.66 s"), std::string::npos);
    EXPECT_EQ(remark.get<std::string>().find("outside the device's workspace"), std::string::npos);
  }
}

TEST_F(Flow, SameSessionRunsOnAnotherLiverByMeshUnitAndPose) {
  SKIP_WITHOUT_EGL();
  const fs::path mesh = kSharedData / "organs" / "sofa_liver-smooth.obj";
  if (!fs::exists(mesh)) GTEST_SKIP() << "shared test data is absent: " << mesh;
  std::string text = ReadFile(kScene);
  const auto replace = [&](const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
  };
  replace("mesh = \"meshes/liver_5000.obj\"", "mesh = \"" + mesh.string() + "\"");
  replace("unit = \"m\"", "unit = 0.031");
  replace("texture = ", "# not of this mesh: ");
  replace("meshes/probe", (kSource / "scenes" / "meshes" / "probe").string());
  replace("  [organ.lattice]",
          "  [organ.pose]\n  position = [0.08, 0.02, -0.1]\n\n  [organ.lattice]");
  std::ofstream(folder_ / "other.toml") << text;
  const Outcome outcome = Hpdm("run " + Folder("other.toml") +
                               " --clock lockstep --seconds 4 --json --out " + Folder("s"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_GT(Json::parse(outcome.out)["tools"][0]["contact_time_s"], 0.5);
}

}  // namespace
}  // namespace hpdm
