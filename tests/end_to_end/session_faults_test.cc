// Real sessions whose disk, folder, spies and network misbehave. Each runs in a private network and
// mount namespace: the test starts itself again inside.

#include <gtest/gtest.h>
#include <sys/mount.h>

#include <atomic>
#include <lcm/lcm-cpp.hpp>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <set>

#include "lcmtypes/analysis/log_health.h"
#include "lcmtypes/log/log.h"
#include "lcmtypes/wire/codec.h"
#include "tests/support/network_namespace.h"
#include "tests/support/program.h"
#include "tests/support/scratch_folder.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr char kUrl[] = "udpm://239.255.76.67:7667?ttl=0";

// Receives a session's messages on its own thread.
class Listener {
 public:
  Listener() : lcm_(std::string(kUrl) + "&recv_buf_size=2000000") {
    lcm_.subscribeFunction("HPDM_.*", Receive, this)->setQueueCapacity(10'000);
    thread_ = std::jthread([this](std::stop_token stop) {
      while (!stop.stop_requested()) lcm_.handleTimeout(20);
    });
  }

  int Events(const std::string& name) const {
    const std::lock_guard lock(mutex_);
    const auto at = events_.find(name);
    return at == events_.end() ? 0 : at->second;
  }
  int ticks() const { return ticks_; }

 private:
  // A plain function: GCC 12's undefined-behaviour sanitizer misjudges LCM's calls of members.
  static void Receive(const lcm::ReceiveBuffer* message, const std::string& channel,
                      Listener* self) {
    const auto* data = static_cast<const std::uint8_t*>(message->data);
    if (channel == kToolChannel) ++self->ticks_;
    event_t event;
    if (channel != kEventChannel || !DecodeMessage({data, message->data_size}, &event)) return;
    const std::lock_guard lock(self->mutex_);
    ++self->events_[event.name];
  }

  lcm::LCM lcm_;
  mutable std::mutex mutex_;
  std::map<std::string, int> events_;
  std::atomic<int> ticks_ = 0;
  std::jthread thread_;
};

// The rest of the test runs in the copy of this program inside a namespace.
#define RUN_INSIDE_NAMESPACE()                                                                \
  if (!InsideNetworkNamespace()) {                                                            \
    const std::string enter = NetworkNamespaceCommand(true);                                  \
    if (enter.empty()) GTEST_SKIP() << "network and mount namespaces are refused here";       \
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();                 \
    EXPECT_EQ(RunInNetworkNamespace(enter, std::string("SessionFaults.") + test->name()), 0); \
    return;                                                                                   \
  }

class SessionFaults : public testing::Test {
 protected:
  void SetUp() override {
    if (!InsideNetworkNamespace()) return;
    listener_.emplace();
    fs::create_directory(disk());
    fs::copy_file(kScenes / "meshes/liver_274.obj", folder_ / "liver.obj");
    std::ofstream(folder_ / "scene.toml") << "[[organ]]\nname = \"liver\"\nmesh = \"liver.obj\"\n"
                                             "energy.type = \"metric\"\n"
                                             "[[instrument]]\nname = \"probe\"\n"
                                             "trocar = [0.05, -0.12, 0.16]\n";
  }
  void TearDown() override {
    if (InsideNetworkNamespace()) umount2(disk().c_str(), MNT_DETACH);
  }

  std::string disk() const { return folder_ / "disk"; }
  std::string out() const { return disk() + "/out"; }
  // A disk of its own for the session.
  void MountDisk(const std::string& options) const {
    ASSERT_EQ(mount("none", disk().c_str(), "tmpfs", 0, options.c_str()), 0);
  }

  // Starts a session of `seconds` and waits until it runs.
  void Start(int seconds, const std::string& options) {
    ticks_ = 1000 * seconds;
    session_ = std::make_unique<BackgroundCommand>(
        "exec " + kHpdmProgram + " run " + (folder_ / "scene.toml") + " --live --json " +
            "--seconds " + std::to_string(seconds) + " --out " + out() + " " + options,
        folder_ / "stdout", folder_ / "stderr");
    ASSERT_TRUE(Becomes([&] { return listener_->ticks() > 0; })) << session_->err();
  }

  // Ends the session and checks every session's promises: each tick ran or was skipped for an
  // external reason, and the telemetry saw it.
  Json End(int exit_code) {
    EXPECT_EQ(session_->Wait(), exit_code) << session_->err();
    Json summary = Json::parse(session_->out());
    const Json& haptic = summary["haptic"];
    EXPECT_EQ(haptic["ticks"].get<int>() + haptic["skipped"]["total"].get<int>(), ticks_);
    EXPECT_EQ(summary["log"]["ticks"], haptic["ticks"]);
    EXPECT_EQ(summary["log"]["ticks_lost"], 0);
    return summary;
  }

  // Prints one line when it happens and one at the end.
  void ExpectToldOnce(const std::string& failure) const {
    const std::string err = session_->err();
    EXPECT_EQ(Count(err, "hpdm: note: " + failure), 1) << err;
    EXPECT_EQ(Count(err, "incomplete: " + failure), 1) << err;
    EXPECT_EQ(Count(err, "incomplete"), 1) << err;
  }

  LogHealth Health() const { return CheckLog(out() + "/session.lcmlog", MessageSchemas::Hpdm()); }
  std::map<std::string, int> LoggedEvents(const std::string& folder) const {
    std::map<std::string, int> events;
    LogReader reader(folder + "/session.lcmlog");
    for (LogEvent logged; reader.Next(&logged);) {
      event_t event;
      if (logged.channel == kEventChannel && DecodeMessage(logged.data, &event)) {
        ++events[event.name];
      }
    }
    return events;
  }

  const ScratchFolder folder_;
  std::optional<Listener> listener_;
  std::unique_ptr<BackgroundCommand> session_;
  int ticks_ = 0;
};

TEST_F(SessionFaults, AFullDiskCostsWhatDoesNotFitAndNothingElse) {
  RUN_INSIDE_NAMESPACE()
  MountDisk("size=900k");  // the log takes half a megabyte a second
  Start(3, "--no-pictures");
  const Json summary = End(2);
  ExpectToldOnce("the log cannot be written (No space left on device)");
  EXPECT_EQ(listener_->Events("log.failed"), 1);
  EXPECT_LE(listener_->Events("timeline.failed"), 1);
  EXPECT_EQ(listener_->Events("session.end"), 1) << "live goes on to the end";
  EXPECT_GT(summary["log"]["dropped"], 0);
  EXPECT_EQ(Json::parse(ReadFile(out() + "/summary.json")), summary) << "its space was reserved";
  const LogHealth health = Health();
  EXPECT_EQ(health.damaged_bytes + health.torn_bytes, 0u) << "what is there is whole";
  EXPECT_EQ(health.events, summary["log"]["events"]);
}

TEST_F(SessionFaults, ATeacherPausesContinuesPointsRestartsAndBeginsABleeding) {
  RUN_INSIDE_NAMESPACE()
  const auto teach = [](const std::string& request) {
    return Shell(kHpdmProgram + " teach " + request);
  };
  Start(8, "--no-pictures --teacher");
  ASSERT_EQ(teach("pause"), 0);
  ASSERT_TRUE(Becomes([&] { return listener_->Events("session.paused") == 1; }));
  ASSERT_EQ(teach("continue"), 0);
  ASSERT_TRUE(Becomes([&] { return listener_->Events("session.resumed") == 1; }));
  ASSERT_EQ(teach("point --x 0.25 --y 0.5 --text here"), 0);
  ASSERT_EQ(teach("restart --step 2"), 0);
  ASSERT_EQ(teach("bleed --x 0.75"), 0);
  ASSERT_TRUE(Becomes([&] { return listener_->Events("teacher.bleeding") == 1; }));
  End(0);
  std::map<std::string, int> events = LoggedEvents(out());
  for (const char* name :
       {"teacher.paused", "session.paused", "teacher.continued", "session.resumed", "teacher.point",
        "teacher.restart", "teacher.bleeding"}) {
    EXPECT_EQ(events[name], 1) << name;
  }
  EXPECT_TRUE(Health().Sound());
  EXPECT_EQ(Shell(kHpdmProgram + " replay --json --tolerance 0 " + out() + " >/dev/null"), 0);
}

TEST_F(SessionFaults, ASessionThatDoesNotListenHasNoTeacher) {
  RUN_INSIDE_NAMESPACE()
  Start(2, "--no-pictures");
  EXPECT_EQ(Shell(kHpdmProgram + " teach pause"), 0) << "nobody answers";
  End(0);
  EXPECT_EQ(LoggedEvents(out())["session.paused"], 0);
}

TEST_F(SessionFaults, AFullDiskEndsTheFilmWithAWholePicture) {
  RUN_INSIDE_NAMESPACE()
  MountDisk("size=1000k");
  Start(3, "--size 320x240 --fps 30");
  if (session_->err().find("EGL") != std::string::npos) GTEST_SKIP() << session_->err();
  const Json summary = End(2);
  EXPECT_EQ(listener_->Events("render.recording"), 1);
  EXPECT_EQ(Count(session_->err(), "out/frames/frame_"), 1) << session_->err();
  EXPECT_EQ(summary["render"]["frames_written"],
            std::distance(fs::directory_iterator(out() + "/frames"), {}));
  EXPECT_GT(summary["render"]["frames"], summary["render"]["frames_written"]) << "drawing goes on";
  EXPECT_EQ(Json::parse(ReadFile(out() + "/summary.json")), summary);
}

TEST_F(SessionFaults, ALostNetworkIsReportedOnceAndTheLogIsWhole) {
  RUN_INSIDE_NAMESPACE()
  Start(2, "--no-pictures");
  ASSERT_EQ(Shell("ip link set lo down"), 0);
  const Json summary = End(0);
  EXPECT_EQ(Shell("ip link set lo up"), 0);
  EXPECT_GT(summary["live"]["errors"], 0);
  EXPECT_EQ(LoggedEvents(out())["live.failed"], 1);
  EXPECT_EQ(Count(session_->err(), "the network refused messages of --live"), 1);
  EXPECT_TRUE(Health().Sound());
}

TEST_F(SessionFaults, AFullDiskIsReportedBeforeTheSession) {
  RUN_INSIDE_NAMESPACE()
  MountDisk("size=200k");
  BackgroundCommand run("exec " + kHpdmProgram + " run " + (folder_ / "scene.toml") +
                            " --seconds 1 --no-pictures --out " + out(),
                        folder_ / "stdout", folder_ / "stderr");
  EXPECT_EQ(run.Wait(), 2);
  EXPECT_EQ(run.out(), "") << "no session began";
  EXPECT_NE(run.err().find(out()), std::string::npos) << run.err();
  EXPECT_NE(run.err().find("no space left; free space"), std::string::npos) << run.err();
  EXPECT_FALSE(fs::exists(out())) << "the next try needs the name";
}

TEST_F(SessionFaults, AReadOnlyFolderIsReportedBeforeTheSession) {
  RUN_INSIDE_NAMESPACE()
  MountDisk("ro");
  BackgroundCommand run("exec " + kHpdmProgram + " run " + (folder_ / "scene.toml") +
                            " --seconds 1 --no-pictures --out " + out(),
                        folder_ / "stdout", folder_ / "stderr");
  EXPECT_EQ(run.Wait(), 2);
  const std::string expected =
      out() + ": cannot be created (Read-only file system); choose another folder with --out";
  EXPECT_NE(run.err().find(expected), std::string::npos) << run.err();
  EXPECT_EQ(run.err().find("preparing"), std::string::npos) << run.err();
}

TEST_F(SessionFaults, ARenamedFolderTakesTheSessionAlong) {
  RUN_INSIDE_NAMESPACE()
  Start(2, "--no-pictures");
  fs::rename(out(), disk() + "/renamed");
  const Json summary = End(0);
  EXPECT_EQ(Count(session_->err(), "hpdm: note: the session folder was moved"), 1)
      << session_->err();
  EXPECT_FALSE(fs::exists(out()));
  for (const char* file : {"summary.json", "timeline.csv", "latency.csv", "scene.toml"}) {
    EXPECT_TRUE(fs::exists(disk() + "/renamed/" + file)) << file;
  }
  EXPECT_EQ(listener_->Events("log.moved"), 1);
  std::map<std::string, int> events = LoggedEvents(disk() + "/renamed");
  EXPECT_EQ(events["log.moved"], 1);
  EXPECT_EQ(events["session.end"], 1);
}

TEST_F(SessionFaults, ADeletedFolderEndsTheLogAndNotTheSession) {
  RUN_INSIDE_NAMESPACE()
  Start(2, "--no-pictures");
  fs::remove_all(out());
  End(2);
  ExpectToldOnce("the log was deleted while it was written");
  EXPECT_EQ(listener_->Events("log.failed"), 1);
  EXPECT_EQ(listener_->Events("session.end"), 1);
  EXPECT_FALSE(fs::exists(out())) << "nobody wants it back";
}

TEST_F(SessionFaults, SpiesThatStopOrDieAreNotNoticed) {
  RUN_INSIDE_NAMESPACE()
  std::map<std::string, std::unique_ptr<BackgroundCommand>> spies;
  for (const char* name : {"reading", "stopped", "killed"}) {
    spies[name] = std::make_unique<BackgroundCommand>(
        "exec lcm-logger --lcm-url='" + std::string(kUrl) + "' " + (folder_ / name) + ".lcmlog",
        folder_ / "spy_out", folder_ / "spy_err");
  }
  Start(2, "--no-pictures");
  ASSERT_TRUE(Becomes([&] { return fs::file_size(folder_ / "stopped.lcmlog") > 100'000; }));
  spies["stopped"]->Signal(SIGSTOP);
  spies["killed"]->Signal(SIGKILL);
  End(0);
  EXPECT_TRUE(Health().Sound());
  // Most of the session's megabyte: a busy machine skips ticks, which leave no message.
  EXPECT_GT(fs::file_size(folder_ / "reading.lcmlog"), 500'000u);
}

// Sends random bytes on every channel of HPDM and on 10,000 others, some messages of 60 kB.
void Flood(std::stop_token stop, std::atomic<long>* sent) {
  lcm::LCM network(kUrl);
  std::mt19937 random(5);
  constexpr unsigned kMaxBytes = 60'000;
  std::vector<std::uint8_t> body(kMaxBytes + 100);
  for (std::uint8_t& byte : body) byte = static_cast<std::uint8_t>(random());
  device_t stale{};
  stale.sequence = 1;
  std::vector<std::uint8_t> buffer;
  const std::span<const std::uint8_t> reading = EncodeMessage(stale, &buffer);
  constexpr auto kBurst = std::chrono::milliseconds(10);
  for (auto next = std::chrono::steady_clock::now(); !stop.stop_requested(); next += kBurst) {
    for (int i = 0; i < 100; ++i) {
      const std::string channel =
          i % 2 == 0 ? "FLOOD_" + std::to_string(random() % 10'000)
                     : std::string(kSessionChannels[random() % std::size(kSessionChannels)]);
      const unsigned size = i == 0 ? kMaxBytes : static_cast<unsigned>(random() % 300);
      network.publish(channel, body.data() + random() % 100, size);
    }
    network.publish(kDeviceChannel, reading.data(), static_cast<unsigned>(reading.size()));
    *sent += 101;
    std::this_thread::sleep_until(next);
  }
}

TEST_F(SessionFaults, AFloodOfForeignMessagesIsRefusedCountedAndReportedOnce) {
  RUN_INSIDE_NAMESPACE()
  std::atomic<long> sent = 0;
  std::jthread flood([&sent](std::stop_token stop) { Flood(stop, &sent); });
  ASSERT_TRUE(Becomes([&] { return sent > 1000; }));
  BackgroundCommand spy("exec " + kHpdmProgram + " spy --once --json --seconds 100",
                        folder_ / "spy_out", folder_ / "spy_err");
  Start(2, "--no-pictures --device lcm");
  const Json summary = End(0);
  spy.Signal(SIGINT);
  ASSERT_EQ(spy.Wait(), 0) << spy.err();
  // At most 64 MB of messages wait; the rest is what their channels keep.
  EXPECT_LT(spy.peak_kb(), 256'000);
  const Json spied = Json::parse(spy.out());
  EXPECT_GT(spied["other_messages"], 0) << "the names are too many for the table";
  std::set<std::string> shown;
  for (const Json& channel : spied["channels"]) {
    const std::string name = channel["channel"];
    if (!name.starts_with("HPDM_")) continue;
    shown.insert(name);
    // This session has neither: no message tells the type, and what has none is not read.
    if (name == kExerciseChannel || name == kTeacherChannel) continue;
    EXPECT_GT(channel["unreadable"], 0) << name << ": garbage is told apart";
    // Every readable message comes from the session.
    if (name == kToolChannel) {
      const int ticks = channel["messages"].get<int>() - channel["unreadable"].get<int>();
      EXPECT_LE(ticks, ticks_);
      EXPECT_GT(ticks, ticks_ / 2);
      EXPECT_EQ(channel["last"]["values"]["tool_count"], 1);
    }
  }
  EXPECT_EQ(shown.size(), std::size(kSessionChannels));
  flood.request_stop();
  flood.join();
  EXPECT_GT(sent, 1000);
  EXPECT_TRUE(Health().Sound());
  EXPECT_GT(summary["device_link"]["refused"], 100);
  // Garbage and an outdated reading are each reported once.
  std::map<std::string, int> events = LoggedEvents(out());
  EXPECT_EQ(events["device.refused"], 2);
  EXPECT_EQ(Count(session_->err(), "HPDM_DEVICE was refused"), 2) << session_->err();
}

TEST(LongSession, LosesNoMessageInItsShortForm) {
  if (geteuid() != 0 || NetworkNamespaceCommand().empty()) {
    GTEST_SKIP() << "network namespaces are refused here";
  }
  const ScratchFolder folder;
  const std::string script = (kScenes.parent_path() / "tools/soak.py").string();
  EXPECT_EQ(Shell("/usr/bin/python3 -B " + script + " --seconds 2 --hpdm " + kHpdmProgram + " >" +
                  (folder / "out") + " 2>&1"),
            0)
      << ReadFile(folder / "out");
  EXPECT_NE(ReadFile(folder / "out").find("complete  ok"), std::string::npos);
}

}  // namespace
}  // namespace hpdm
