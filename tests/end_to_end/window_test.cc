// The trainee's window as a user has it, on a virtual display, with synthetic mouse and keys.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "lcmtypes/log/log.h"
#include "lcmtypes/wire/codec.h"
#include "render/image/image_file.h"
#include "tests/support/program.h"
#include "tests/support/virtual_display.h"

// Last: its macros break others' headers.
#include <X11/Xlib.h>

namespace hpdm {
namespace {

namespace fs = std::filesystem;

bool Runs(const std::string& command) {
  return std::system((command + " >/dev/null 2>&1").c_str()) == 0;
}

void Sleep(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

/// A tip's path and force by session time, and the events, from the log.
struct Logged {
  struct Tick {
    Nanoseconds time_ns;
    Vector3d p_tip_W;
    double force;
  };
  std::vector<Tick> ticks;
  std::vector<std::pair<std::string, Nanoseconds>> events;

  explicit Logged(const fs::path& file) {
    LogReader reader(file.string());
    LogEvent event;
    tool_t tool;
    force_t force;
    event_t happened;
    HapticSample sample;
    while (reader.Next(&event)) {
      if (event.channel == kToolChannel && DecodeMessage(event.data, &tool)) {
        FromMessage(tool, &sample);
      } else if (event.channel == kForceChannel && DecodeMessage(event.data, &force)) {
        FromMessage(force, &sample);
        ticks.push_back({sample.time_ns, sample.tools[0].p_tip_W, sample.tools[0].force_W.norm()});
      } else if (event.channel == kEventChannel && DecodeMessage(event.data, &happened)) {
        events.emplace_back(happened.name, happened.time_ns);
      }
    }
  }
  std::vector<Nanoseconds> Times(const std::string& name) const {
    std::vector<Nanoseconds> times;
    for (const auto& [what, when] : events) {
      if (what == name) times.push_back(when);
    }
    return times;
  }
  /// Returns the first tick at or after a session time.
  const Tick& At(Nanoseconds time_ns) const {
    for (const Tick& tick : ticks) {
      if (tick.time_ns >= time_ns) return tick;
    }
    return ticks.back();
  }
};

class WindowTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!Runs("command -v Xvfb") || !Runs("command -v xdotool")) {
      GTEST_SKIP() << "no window can be tried here: install the packages xvfb and xdotool";
    }
    display_.emplace();
    ASSERT_FALSE(display_->name().empty()) << "Xvfb does not start";
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / (std::string("hpdm_window_") + test->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override {
    session_.reset();
    if (!HasFailure()) fs::remove_all(folder_);  // otherwise a window is shown
  }

  /// Starts a session in a window and waits until it draws and has the keyboard.
  void Start(const std::string& scene, const std::string& arguments) {
    session_.emplace(std::vector<std::string>{
        "/bin/sh", "-c",
        "exec " + kHpdmProgram + " run " + (kSource / "scenes" / scene).string() +
            " --window --json --out " + Out("").string() + " " + arguments + " >" +
            (folder_ / "stdout").string() + " 2>" + (folder_ / "stderr").string()});
    ASSERT_TRUE(Becomes([this] {
      const std::string id = (folder_ / "id").string();
      return Runs("{ xdotool search --name '^HPDM: ' >" + id + "; } ");
    })) << ReadFile(folder_ / "stderr");
    std::ifstream(folder_ / "id") >> id_;
    // A session that logs also draws. Without a window manager only the test can give a window the
    // keyboard.
    ASSERT_TRUE(Becomes([this] {
      std::error_code error;
      return fs::file_size(Out("session.lcmlog"), error) > 200'000 && !error;
    })) << ReadFile(folder_ / "stderr");
    Do("windowfocus --sync " + id_ + " mousemove --window " + id_ + " 320 240");
  }
  fs::path Out(const std::string& name) const { return folder_ / "session" / name; }
  void Do(const std::string& input) const { EXPECT_TRUE(Runs("xdotool " + input)) << input; }

  /// Takes screenshot number `number`.
  Image Screenshot(int number) const {
    char name[40];
    std::snprintf(name, sizeof name, "screenshots/screenshot_%04d.png", number);
    Do("key s");
    EXPECT_TRUE(Becomes([&] { return fs::exists(Out(name)); })) << name;
    return ReadPng(Out(name));
  }

  fs::path folder_;
  std::optional<VirtualDisplay> display_;
  std::optional<Child> session_;
  std::string id_;
};

/// Pixels brighter than any of the black surroundings in a part of a picture.
int BrightPixels(const Image& image, int x0, int y0, int x1, int y1) {
  int bright = 0;
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) bright += image.At(x, y)[1] > 120;
  }
  return bright;
}

TEST_F(WindowTest, MouseAndKeysDriveASession) {
  Start("liver_palpation.toml", "--seconds 60");
  const Image first = Screenshot(1);
  EXPECT_EQ(first.width, 640);
  EXPECT_GT(BrightPixels(first, 0, 0, 80, 40), 50) << "text in the corner";

  // The probe is taken and pushed 48 mm along its shaft, which starts 30 mm off the liver.
  Do("click 1 sleep 0.1 click --repeat 12 --delay 20 4");
  Sleep(0.5);
  const Image pressed = Screenshot(2);
  EXPECT_NE(pressed.rgb, first.rgb);

  // Back, and to the side.
  Do("click --repeat 10 --delay 10 5 sleep 0.5");
  Screenshot(3);
  for (int i = 0; i < 10; ++i) Do("mousemove_relative -- -6 2");
  Sleep(0.5);
  Screenshot(4);

  // A paused hand does not move.
  Do("key p mousemove_relative 60 0 sleep 0.4");
  const Image paused = Screenshot(5);
  EXPECT_GT(BrightPixels(paused, 260, 40, 380, 75), 50) << "PAUSED at the top of the circle";
  Do("key p sleep 0.4");
  Screenshot(6);

  Do("key r sleep 0.5 key r windowsize --sync " + id_ + " 800 500 sleep 0.3");
  const Image resized = Screenshot(7);
  EXPECT_EQ(resized.width, 800);
  EXPECT_EQ(resized.height, 500);
  Do("key Escape");
  ASSERT_EQ(session_->Wait(20), 0) << ReadFile(folder_ / "stderr");

  const auto summary = nlohmann::json::parse(ReadFile(Out("summary.json")));
  EXPECT_GT(summary["tools"][0]["peak_force_N"], 0.3);
  EXPECT_LT(summary["tools"][0]["peak_force_N"], 8.9);
  EXPECT_EQ(summary["render"]["failure"], "");
  EXPECT_GT(summary["render"]["frames_written"], 4) << "half a second at 30 Hz";
  EXPECT_TRUE(fs::exists(Out("frames/frame_000004.png")));

  const Logged log(Out("session.lcmlog"));
  const std::vector<Nanoseconds> shots = log.Times("render.screenshot");
  ASSERT_EQ(shots.size(), 7u);
  const auto moved = [&](int from, int to) {
    return (log.At(shots[to - 1]).p_tip_W - log.At(shots[from - 1]).p_tip_W).norm();
  };
  EXPECT_EQ(log.At(shots[0]).force, 0);
  EXPECT_GT(log.At(shots[1]).force, 0.3) << "the liver resists";
  EXPECT_GT(moved(1, 2), 0.03) << "beyond where the tissue was";
  EXPECT_GT(moved(3, 4), 0.005) << "60 pixels are some 30 mm at the tip's distance";
  // The device's Coulomb friction and the hand's last approach: far below a pixel's half
  // millimetre.
  EXPECT_LT(moved(4, 6), 2e-4) << "what the mouse did in the pause does not count";
}

/// Copies a scene with another time limit. Its folder has links to the meshes and textures.
fs::path WithTimeLimit(const std::string& scene, const std::string& seconds,
                       const fs::path& folder) {
  for (const auto& entry : fs::directory_iterator(kSource / "scenes")) {
    if (entry.is_directory()) {
      fs::create_directory_symlink(entry.path(), folder / entry.path().filename());
    }
  }
  std::string text = ReadFile(kSource / "scenes" / scene);
  for (const char* key : {"target_time", "time_limit"}) {
    const std::size_t at = text.find(std::string("\n") + key);
    if (at == std::string::npos) continue;
    const std::size_t end = text.find('\n', at + 1);
    text.replace(at, end - at, key == std::string("time_limit") ? "\ntime_limit = " + seconds : "");
  }
  std::ofstream(folder / scene) << text;
  return folder / scene;
}

TEST_F(WindowTest, AnExercisesResultStaysUntilEscIsPressed) {
  const fs::path scene = WithTimeLimit("clip_and_cut.toml", "6.0", folder_);
  Start(scene.string(), "");
  const auto json = [this] { return nlohmann::json::parse(ReadFile(Out("summary.json"))); };
  Sleep(9);
  const Image result = Screenshot(1);
  EXPECT_GT(BrightPixels(result, 160, 140, 480, 340), 300) << "the result in the middle";
  Do("key e key space");
  Sleep(2.5);
  EXPECT_FALSE(fs::exists(Out("summary.json"))) << "the session waits";
  Do("key Escape");
  ASSERT_EQ(session_->Wait(20), 0) << ReadFile(folder_ / "stderr");
  EXPECT_EQ(json()["ended_by"], "exercise");
}

TEST_F(WindowTest, ASessionOutlivesItsDisplayAndSaysSo) {
  Start("liver_palpation.toml", "");
  Do("key p sleep 0.2");  // a pause that no key will end
  display_->End();
  const std::string failure = "rendering ended: the window's display was lost";
  ASSERT_TRUE(Becomes([&] {
    return ReadFile(folder_ / "stderr").find("hpdm: note: " + failure) != std::string::npos;
  })) << ReadFile(folder_ / "stderr");
  Sleep(0.5);
  session_->Signal(SIGTERM);
  ASSERT_EQ(session_->Wait(20), 0) << ReadFile(folder_ / "stderr");
  const auto summary = nlohmann::json::parse(ReadFile(Out("summary.json")));
  EXPECT_EQ(summary["log"]["ticks_lost"], 0);
  EXPECT_NE(summary["render"]["failure"].get<std::string>().find(failure), std::string::npos);
  const Logged log(Out("session.lcmlog"));
  ASSERT_EQ(log.Times("render.ended").size(), 1u);
  EXPECT_GT(log.ticks.back().time_ns, log.Times("render.ended")[0] + 400'000'000);
  EXPECT_EQ(log.Times("session.paused").size(), 1u);
  EXPECT_EQ(log.Times("session.resumed").size(), 1u);
}

TEST_F(WindowTest, ClosingTheWindowEndsTheSession) {
  Start("liver_palpation.toml", "");
  // Sends the message of a window manager's close button.
  Display* display = XOpenDisplay(display_->name().c_str());
  ASSERT_NE(display, nullptr);
  XEvent event{};
  event.xclient.type = ClientMessage;
  event.xclient.window = std::stoul(id_);
  event.xclient.message_type = XInternAtom(display, "WM_PROTOCOLS", False);
  event.xclient.format = 32;
  event.xclient.data.l[0] = static_cast<long>(XInternAtom(display, "WM_DELETE_WINDOW", False));
  XSendEvent(display, event.xclient.window, False, NoEventMask, &event);
  XCloseDisplay(display);
  ASSERT_EQ(session_->Wait(20), 0) << ReadFile(folder_ / "stderr");
  EXPECT_EQ(nlohmann::json::parse(ReadFile(Out("summary.json")))["ended_by"], "user");
}

TEST_F(WindowTest, ADisplayOpensAWindowUnlessTheCommandLineSaysOtherwise) {
  const std::string run = "exec " + kHpdmProgram + " run " +
                          (kSource / "scenes" / "liver_palpation.toml").string() +
                          " --seconds 2 --fps 0 --out " + Out("").string();
  const auto opens = [&](const std::string& arguments) {
    BackgroundCommand session(run + arguments, folder_ / "stdout", folder_ / "stderr");
    const bool window = Becomes([&] {
                          return Runs("xdotool search --name '^HPDM: '") ||
                                 Count(session.err(), "hpdm: running") > 0;
                        }) &&
                        Runs("xdotool search --name '^HPDM: '");
    EXPECT_EQ(session.Wait(), 0) << session.err();
    return window;
  };
  EXPECT_TRUE(opens(""));
  EXPECT_NE(ReadFile(folder_ / "stderr").find(", Ctrl-C or Esc ends"), std::string::npos);
  fs::remove_all(Out(""));
  EXPECT_FALSE(opens(" --headless"));
  EXPECT_EQ(ReadFile(folder_ / "stderr").find("Esc"), std::string::npos);
  fs::remove_all(Out(""));

  display_.reset();
  EXPECT_FALSE(opens(""));
  EXPECT_EQ(
      Count(ReadFile(folder_ / "stderr"), "hpdm: no display: the session runs without a window\n"),
      1);
}

TEST_F(WindowTest, WithoutADisplayItExitsWithThreeAndTheRemedy) {
  display_.reset();
  Child session({"/bin/sh", "-c",
                 "exec " + kHpdmProgram + " run " +
                     (kSource / "scenes" / "liver_palpation.toml").string() + " --window --out " +
                     Out("").string() + " 2>" + (folder_ / "stderr").string()});
  EXPECT_EQ(session.Wait(20), 3);
  const std::string error = ReadFile(folder_ / "stderr");
  EXPECT_NE(error.find("--headless draws without one"), std::string::npos) << error;
  EXPECT_EQ(std::count(error.begin(), error.end(), '\n'), 1) << error;
  EXPECT_FALSE(fs::exists(Out("")));
}

}  // namespace
}  // namespace hpdm
