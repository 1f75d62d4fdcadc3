// Sessions end to end: the hpdm program on real scenes.

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "lcmtypes/log/log.h"
#include "lcmtypes/wire/codec.h"
#include "tests/support/flow_fixture.h"
#include "tests/support/network_namespace.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// What the log says of one session's haptic ticks.
struct LoggedTicks {
  std::uint64_t count = 0;
  std::uint64_t gaps = 0;           // numbers that are neither logged nor counted as skipped
  std::uint64_t grasping = 0;       // ticks with tissue in the jaws
  double largest_force_step = 0;    // N, from tick to tick
  double largest_displacement = 0;  // m, of a control point
};

LoggedTicks ReadTicks(const fs::path& log) {
  LogReader reader(log.string());
  LogEvent event;
  force_t message;
  HapticSample sample;
  LoggedTicks ticks;
  std::uint64_t next = 0;
  std::array<Vector3d, kMaxInstruments> last;
  last.fill(Vector3d::Zero());
  while (reader.Next(&event)) {
    if (event.channel == kOrganChannel) {
      organ_t organ;
      OrganSnapshot shape;
      if (!DecodeMessage(event.data, &organ) || !FromMessage(organ, &shape)) return {};
      if (shape.control_displacements.rows() == 0) continue;  // a rigid organ
      ticks.largest_displacement = std::max(
          ticks.largest_displacement, shape.control_displacements.rowwise().norm().maxCoeff());
    }
    if (event.channel == kToolChannel) {
      tool_t input;
      if (!DecodeMessage(event.data, &input) || !FromMessage(input, &sample)) return {};
    }
    if (event.channel != kForceChannel) continue;
    if (!DecodeMessage(event.data, &message) || !FromMessage(message, &sample)) return {};
    ++ticks.count;
    if (sample.tick != next + sample.skipped.Total()) ++ticks.gaps;
    next = sample.tick + 1;
    for (int t = 0; t < sample.tool_count; ++t) {
      ticks.grasping += sample.tools[t].kind == ContactKind::kGrasp;
      const Vector3d& force = sample.tools[t].force_W;
      ticks.largest_force_step = std::max(ticks.largest_force_step, (force - last[t]).norm());
      last[t] = force;
    }
  }
  EXPECT_EQ(reader.damaged_stretches(), 0u);
  return ticks;
}

TEST_F(Flow, LockstepRunGivesTheSameLogAndPictureTwice) {
  SKIP_WITHOUT_EGL();
  for (const char* name : {"a", "b"}) {
    const Outcome outcome =
        Hpdm("run " + kScene + " --clock lockstep --seconds 3 --fps 1 --out " + Folder(name));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  }
  for (const char* file : {"session.lcmlog", "timeline.csv", "deepest.png", "last.png"}) {
    const std::string a = ReadFile(folder_ / "a" / file), b = ReadFile(folder_ / "b" / file);
    EXPECT_GT(a.size(), 1000u) << file;
    EXPECT_TRUE(a == b) << file << " differs between two lockstep runs";
  }
}

TEST_F(Flow, LockstepLosesNoTickHoweverRareTheStepsAre) {
  SKIP_WITHOUT_EGL();
  std::ofstream(folder_ / "rare.toml")
      << "[timing]\nhaptic_hz = 5000\ndeformation_hz = 1\n[[organ]]\nname = \"liver\"\nmesh = \""
      << (kSource / "scenes" / "meshes" / "liver_274.obj").string()
      << "\"\nenergy.type = \"metric\"\n"
         "[[instrument]]\nname = \"probe\"\ntrocar = [0.05, -0.12, 0.16]\n";
  const Outcome outcome = Hpdm("run " + Folder("rare.toml") +
                               " --clock lockstep --seconds 3 --fps 0 --json --out " + Folder("s"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json summary = Json::parse(outcome.out);
  EXPECT_EQ(summary["log"]["ticks"], 15000);
  EXPECT_EQ(summary["log"]["ticks_lost"], 0);
}

TEST_F(Flow, AFullDiskIsToldAfterTheSummary) {
  SKIP_WITHOUT_EGL();
  // A file cannot grow beyond this limit, which the program meets as it meets a full disk.
  const Outcome outcome =
      Hpdm("run " + kScene + " --clock lockstep --seconds 3 --fps 0 --json --out " + Folder("s"),
           "ulimit -f 1000; ");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("incomplete: the log cannot be written"), std::string::npos)
      << outcome.err;
  const Json summary = Json::parse(outcome.out);
  EXPECT_GT(summary["log"]["dropped"], 0);
  EXPECT_EQ(summary, Json::parse(ReadFile(folder_ / "s" / "summary.json")));
}

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

TEST_F(Flow, EveryTickIsLoggedOnceAndNoForceStepExceedsTheSlewLimit) {
  SKIP_WITHOUT_EGL();
  const std::string common = " --seconds 5 --fps 0 --json --out ";
  for (const std::string clock : {"real", "lockstep"}) {
    const Outcome outcome = Hpdm("run " + kScene + " --clock " + clock + common + Folder(clock));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const LoggedTicks ticks = ReadTicks(folder_ / clock / "session.lcmlog");
    EXPECT_EQ(ticks.count, Json::parse(outcome.out)["haptic"]["ticks"]) << clock;
    EXPECT_EQ(ticks.gaps, 0u) << clock;
    EXPECT_GT(ticks.largest_force_step, 0) << clock;
    // DeviceProfile::max_force_rate over one period of 1 ms.
    EXPECT_LE(ticks.largest_force_step, 2000 * 1e-3 * (1 + 1e-12)) << clock;
    // A palpating hand moves by less than 0.2 mm a tick into a tissue of less than 300 N/m; where a
    // patch arrives after the contact has slipped at the liver's notch, 0.16 N were seen. On the
    // real clock it may have moved for several skipped ticks.
    if (clock == "lockstep") {
      EXPECT_LT(ticks.largest_force_step, 0.25);
    }
  }
}

TEST_F(Flow, RealClockAccountsForEveryTickAndStepsAtThirtyHertz) {
  SKIP_WITHOUT_EGL();
  const Outcome outcome = Hpdm("run " + kScene + " --seconds 3 --json --out " + Folder("s"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json summary = Json::parse(outcome.out);
  const Json& haptic = summary["haptic"];
  EXPECT_EQ(haptic["ticks"].get<long>() + haptic["skipped"]["total"].get<long>(), 3000);
  // How many are skipped is the machine's affair; that every one that ran is in the log is ours.
  EXPECT_EQ(summary["log"]["ticks"], haptic["ticks"]);
  EXPECT_GT(summary["deformation"]["steps"], 0);
  const Json& skipped = haptic["skipped"];
  EXPECT_EQ(skipped["late_wake_up"].get<long>() + skipped["long_compute"].get<long>() +
                skipped["stalled"].get<long>(),
            skipped["total"].get<long>());
  for (const char* latency : {"wake_up", "compute", "device_to_force"}) {
    EXPECT_EQ(haptic[latency]["count"], haptic["ticks"]) << latency;
  }
  EXPECT_EQ(haptic["period"]["count"].get<long>(), haptic["ticks"].get<long>() - 1);
  EXPECT_EQ(summary["render"]["device_to_photon"]["count"], summary["render"]["frames"]);
  // An empty loop ran for a second before.
  const Json& machine = summary["machine"];
  EXPECT_EQ(machine["wake_up"]["count"].get<long>() + machine["skipped"]["total"].get<long>(),
            1000);
  for (const char* file : {"session.lcmlog", "scene.toml", "summary.json", "timeline.csv",
                           "deepest.png", "last.png", "latency.csv", "latency.png"}) {
    EXPECT_TRUE(fs::exists(folder_ / "s" / file)) << file;
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
  text += R"(
[[instrument]]
name = "grasper"
type = "grasper"
trocar = [-0.06, -0.12, 0.15]
  [instrument.hand]
  script = "grasp_lift"
  seed = 3
)";
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
  const std::string scene = (kSource / "scenes" / "abdomen.toml").string();
  const Outcome check = Hpdm("check --json " + scene);
  ASSERT_EQ(check.exit_code, 0) << check.err;
  const Json facts = Json::parse(check.out);
  EXPECT_EQ(facts["remarks"], Json::array()) << "nothing in it looks wrong";
  ASSERT_EQ(facts["walls"].size(), 2u) << "of each hand at the stomach";
  for (const Json& wall : facts["walls"]) {
    EXPECT_EQ(wall["stiffness_N_per_m"], wall["stable_to_N_per_m"].get<double>() / 2);
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
  std::ofstream(folder_ / "arms.toml") << "[[organ]]\nname = \"liver\"\nmesh = \""
                                       << (kSource / "scenes" / "meshes" / "liver_274.obj").string()
                                       << R"("
energy.type = "metric"
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

// The example driver as a user starts it, against the real clock, in a network of its own.
TEST_F(Flow, AnExternalDriverMovesTheProbeAndIsMissedWhenItGoes) {
  SKIP_WITHOUT_EGL();
  const std::string enter = NetworkNamespaceCommand();
  if (enter.empty()) GTEST_SKIP() << "network namespaces are refused here";
  std::ofstream(folder_ / "session.sh")
      << "ip link set lo up; ip link set lo multicast on; ip route add 239.255.76.67 dev lo\n"
      << "unset LCM_DEFAULT_URL\n"
      << kHpdmProgram << " run " << kScene << " --device lcm --seconds 4 --fps 0 --json --out "
      << Folder("s") << " & session=$!\n"
      << HPDM_BINARY_DIR "/tools/hpdm_example_driver"
      << " & driver=$!\n"
      // Two seconds of log, or half a minute of patience.
      << "for i in $(seq 300); do sleep 0.1; [ -n \"$(find " << Folder("s")
      << "/session.lcmlog -size +1000k 2>/dev/null)\" ] && break; done\n"
      << "kill $driver; wait $session\n";
  ASSERT_EQ(std::system((enter + " sh " + Folder("session.sh") + " >" + Folder("out") + " 2>" +
                         Folder("err"))
                            .c_str()),
            0)
      << ReadFile(folder_ / "err");
  const Json summary = Json::parse(ReadFile(folder_ / "s" / "summary.json"));
  const Json& link = summary["device_link"];
  EXPECT_GT(link["received"], 500) << "of a driver of 1 kHz";
  EXPECT_EQ(link["refused"], 0);
  // The link sends the ramp-out's ticks too, at most 15.
  const long linked = link["sent"].get<long>() + link["overflows"].get<long>();
  EXPECT_GT(linked, summary["haptic"]["ticks"].get<long>());
  EXPECT_LE(linked, summary["haptic"]["ticks"].get<long>() + 15);
  std::vector<std::string> events;
  LogReader reader((folder_ / "s" / "session.lcmlog").string());
  event_t message;
  for (LogEvent event; reader.Next(&event);) {
    if (event.channel != kEventChannel || !DecodeMessage(event.data, &message)) continue;
    if (message.name.starts_with("device.")) events.push_back(message.name);
  }
  ASSERT_FALSE(events.empty());
  EXPECT_EQ(events.back(), "device.lost");
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

TEST_F(Flow, ReplayOfASessionFolderIsTheSameBitForBitInBothClocks) {
  SKIP_WITHOUT_EGL();
  for (const std::string clock : {"real", "lockstep"}) {
    ASSERT_EQ(
        Hpdm("run " + kScene + " --clock " + clock + " --seconds 2 --fps 0 --out " + Folder(clock))
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

TEST_F(Flow, InterruptClosesTheLogAndWritesTheSummary) {
  SKIP_WITHOUT_EGL();
  for (const int signal : {SIGINT, SIGTERM}) {
    const std::string out = Folder(std::to_string(signal));
    const pid_t child = fork();
    if (child == 0) {
      if (freopen("/dev/null", "w", stdout) == nullptr) _exit(127);
      execl(kHpdmProgram.c_str(), "hpdm", "run", kScene.c_str(), "--out", out.c_str(), nullptr);
      _exit(127);
    }
    // Ready once the log holds more than its first events.
    const fs::path log = fs::path(out) / "session.lcmlog";
    for (int i = 0; i < 600; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      std::error_code none;
      if (fs::file_size(log, none) > 300'000 && !none) break;
    }
    ASSERT_EQ(kill(child, signal), 0);
    int status = -1;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 0);
    const Json summary = Json::parse(ReadFile(fs::path(out) / "summary.json"));
    EXPECT_TRUE(summary["interrupted"]);
    EXPECT_EQ(summary["log"]["ticks"], summary["haptic"]["ticks"]);
    EXPECT_EQ(ReadTicks(log).count, summary["haptic"]["ticks"]);
  }
}

TEST_F(Flow, ARealTimeStateThatIsRefusedIsReportedAndExitThreeWhereItIsRequired) {
  SKIP_WITHOUT_EGL();
  // Neither the rights nor the limits for it, whoever runs this.
  if (std::system("setpriv --bounding-set -sys_nice,-ipc_lock true 2>/dev/null") != 0 &&
      geteuid() == 0) {
    GTEST_SKIP() << "rights cannot be dropped here";
  }
  const std::string limits = "ulimit -r 0; ulimit -l 64; ";
  const std::string without =
      limits + (geteuid() == 0 ? "setpriv --bounding-set -sys_nice,-ipc_lock " : "");
  const std::string run = "run " + kScene + " --seconds 0.2 --fps 0 --json --out ";
  const Outcome refused = Hpdm(run + Folder("s") + " --require-rt", without);
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_NE(refused.err.find("--require-rt: locked memory: refused"), std::string::npos)
      << refused.err;
  EXPECT_EQ(std::count(refused.err.begin(), refused.err.end(), '\n'), 1) << refused.err;
  EXPECT_FALSE(fs::exists(folder_ / "s")) << "nothing was begun";
  const Outcome reported = Hpdm(run + Folder("s"), without);
  ASSERT_EQ(reported.exit_code, 0) << reported.err;
  const Json realtime = Json::parse(reported.out)["realtime"];
  EXPECT_NE(realtime["haptic"][0].get<std::string>().find("SCHED_FIFO: refused"), std::string::npos)
      << realtime;
}

TEST_F(Flow, SessionFolderIsNeverOverwritten) {
  SKIP_WITHOUT_EGL();
  const std::string run =
      "run " + kScene + " --clock lockstep --seconds 0.1 --fps 0 --out " + Folder("s");
  ASSERT_EQ(Hpdm(run).exit_code, 0);
  const std::string log = ReadFile(folder_ / "s" / "session.lcmlog");
  const Outcome again = Hpdm(run);
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_NE(again.err.find("--out"), std::string::npos);
  EXPECT_EQ(ReadFile(folder_ / "s" / "session.lcmlog"), log);
}

}  // namespace
}  // namespace hpdm
