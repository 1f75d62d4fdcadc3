// Replay of sessions and of recorded motions: the hpdm program on real scenes.

#include <cmath>
#include <filesystem>
#include <fstream>

#include "tests/support/flow_fixture.h"

namespace hpdm {
namespace {

using Json = nlohmann::json;

TEST_F(Flow, ReplayOfASessionFolderIsTheSameBitForBitInBothClocks) {
  SKIP_WITHOUT_EGL();
  for (const std::string clock : {"real", "lockstep"}) {
    ASSERT_EQ(Hpdm("run " + kScene + " --clock " + clock +
                   " --seconds 2 --headless --fps 0 --out " + Folder(clock))
                  .exit_code,
              0);
    const Outcome outcome = Hpdm("replay --json --tolerance 0 " + Folder(clock));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
    const Json report = Json::parse(outcome.out);
    EXPECT_EQ(report["result"], "identical") << clock;
    EXPECT_EQ(report["ticks"]["compared"], report["ticks"]["logged"]) << clock;
    EXPECT_EQ(report["steps"]["compared"], report["steps"]["logged"]) << clock;
    EXPECT_EQ(report["damage"]["segments"], 0) << clock;
    EXPECT_EQ(report["damage"]["stretches"], 0) << "the deprecated name";
    EXPECT_GT(report["forces"][0]["logged_peak_N"], 0.1) << clock;
  }
  // A scene of the same shapes but softer tissue plays, and differs from the first contact on.
  std::string softer = ReadFile(folder_ / "lockstep" / "scene.toml");
  softer.replace(softer.find("young = 5000"), 12, "young = 4000");
  std::ofstream(folder_ / "lockstep" / "softer.toml") << softer;
  const Outcome differs = Hpdm("replay --json " + Folder("lockstep") + " --scene " +
                               (folder_ / "lockstep" / "softer.toml").string());
  EXPECT_EQ(differs.exit_code, 1) << differs.err;
  const Json report = Json::parse(differs.out);
  EXPECT_EQ(report["result"], "differs");
  for (const char* key : {"field", "logged", "replayed"}) {
    EXPECT_TRUE(report["first_beyond_tolerance"].contains(key)) << key;
  }
  const Outcome other = Hpdm("replay " + Folder("lockstep") + " --scene " +
                             (kSource / "tests" / "golden" / "press.toml").string());
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_NE(other.err.find("not a log of"), std::string::npos) << other.err;
}

// The scene of two hands with two more, which press the liver beside the first two.
TEST_F(Flow, FourHandsAreCheckedReplayedAndReported) {
  std::string scene = ReadFile(kScenes / "two_hands.toml");
  for (std::size_t at = 0; (at = scene.find("\"meshes/", at)) != scene.npos;) {
    scene.insert(at + 1, kScenes.string() + "/");
  }
  scene.erase(scene.find("texture"),
              scene.find('\n', scene.find("texture")) - scene.find("texture"));
  for (const auto& [name, place] : {std::pair{"second probe", "[0.045, -0.02, 0.05]"},
                                    {"assistant", "[-0.005, -0.045, 0.05]"}}) {
    scene += "\n[[instrument]]\nname = \"" + std::string(name) +
             "\"\ntype = \"probe\"\ntrocar = [0.02, -0.15, 0.20]\n  [instrument.hand]\n"
             "  script = \"palpate\"\n  organ = \"liver\"\n  target = " +
             place + "\n  depth = 0.012\n";
  }
  std::ofstream(folder_ / "scene.toml") << scene;
  const Outcome run = Hpdm("run " + Folder("scene.toml") +
                           " --clock lockstep --seconds 3 --fps 0 --out " + Folder("s"));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(Hpdm("log check " + Folder("s")).exit_code, 0);
  const Outcome replay = Hpdm("replay --json --tolerance 0 " + Folder("s"));
  ASSERT_EQ(replay.exit_code, 0) << replay.err;
  const Json replayed = Json::parse(replay.out);
  EXPECT_EQ(replayed["result"], "identical");
  ASSERT_EQ(replayed["forces"].size(), 4);
  for (const Json& force : replayed["forces"]) EXPECT_GT(force["logged_peak_N"], 0.1);
  const Outcome report = Hpdm("report --json --out " + Folder("report.html") + " " + Folder("s"));
  ASSERT_EQ(report.exit_code, 0) << report.err;
  EXPECT_EQ(Json::parse(report.out)["hands"].size(), 4);
}

TEST_F(Flow, ALeftHandedSessionIsReplayedAndReportedAsOne) {
  const Outcome run = Hpdm("run " + (kScenes / "two_hands.toml").string() +
                           " --left-handed --palette colour-blind --clock lockstep --seconds 2 "
                           "--no-pictures --out " +
                           Folder("s"));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(ReadFile(folder_ / "s" / "scene.toml").find("left_handed = true"), std::string::npos);
  EXPECT_EQ(Hpdm("log check " + Folder("s")).exit_code, 0);
  const Outcome replay = Hpdm("replay --json --tolerance 0 " + Folder("s"));
  ASSERT_EQ(replay.exit_code, 0) << replay.err;
  EXPECT_EQ(Json::parse(replay.out)["result"], "identical");
  // With the ports as they were the same input is another session.
  std::string right = ReadFile(folder_ / "s" / "scene.toml");
  right.replace(right.find("left_handed = true"), 18, "left_handed = false");
  std::ofstream(folder_ / "s" / "right.toml") << right;
  EXPECT_EQ(Hpdm("replay " + Folder("s") + " --scene " + Folder("s") + "/right.toml").exit_code, 1);
  const Outcome report = Hpdm("report --json --out " + Folder("report.html") + " " + Folder("s"));
  ASSERT_EQ(report.exit_code, 0) << report.err;
  EXPECT_EQ(Json::parse(report.out)["left_handed"], true);
  EXPECT_NE(ReadFile(folder_ / "report.html").find("left-handed: their ports exchanged"),
            std::string::npos);
  const Outcome one = Hpdm("run " + kScene + " --left-handed --seconds 1 --out " + Folder("one"));
  EXPECT_EQ(one.exit_code, 2);
  EXPECT_NE(one.err.find("fewer than two instruments"), std::string::npos) << one.err;
}

TEST_F(Flow, ReplayPlaysARecordedMotionInBothClocks) {
  std::ofstream motion(folder_ / "motion.csv");
  motion << "t,px,py,pz\n";
  for (int row = 0; row < 60; ++row) {
    motion << 0.02 * row << ",0,0," << 0.02 * std::cos(0.1 * row) << "\n";
  }
  motion.close();
  const std::string command = "replay --json " + Folder("motion.csv") + " --scene " +
                              (kSource / "tests" / "golden" / "press.toml").string();
  for (const std::string clock : {"logged", "real"}) {
    const Outcome outcome = Hpdm(command + " --clock " + clock);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const Json report = Json::parse(outcome.out);
    EXPECT_GT(report["tools"][0]["peak_force_N"], 0.05) << clock;
    if (clock == "logged") {
      EXPECT_EQ(report["ticks"], 1181) << "59 rows of 20 ms, both ends";
    } else {
      EXPECT_GT(report["latency"]["wake_up"]["count"], 0);
    }
  }
}

}  // namespace
}  // namespace hpdm
