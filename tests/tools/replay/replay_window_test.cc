// A replay in a window, on a virtual display, with synthetic keys.

#include <gtest/gtest.h>

#include <filesystem>
#include <optional>
#include <string>

#include "render/image/image_file.h"
#include "tests/support/flow_fixture.h"
#include "tests/support/virtual_display.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

TEST_F(Flow, AWindowShowsTheSessionAndStaysUntilEscape) {
  if (Shell("command -v Xvfb xdotool >/dev/null") != 0) {
    GTEST_SKIP() << "no window can be tried here: install the packages xvfb and xdotool";
  }
  const VirtualDisplay display;
  ASSERT_FALSE(display.name().empty()) << "Xvfb does not start";
  const Outcome run = Hpdm("run " + kScene + " --clock lockstep --seconds 1 --no-pictures --out " +
                           Folder("session"));
  ASSERT_EQ(run.exit_code, 0) << run.err;

  Child replay({"/bin/sh", "-c",
                "cd " + folder_.string() + " && exec " + kHpdmProgram +
                    " replay session --window --size 320x240 >out 2>err"});
  ASSERT_TRUE(Becomes([&] {
    return Shell("xdotool search --name '^HPDM replay: ' >" + Folder("id")) == 0;
  })) << ReadFile(folder_ / "err");
  const fs::path first = folder_ / "replay_screenshots/screenshot_0001.png";
  const std::string focus = "xdotool windowfocus --sync $(cat " + Folder("id") + ") key ";
  ASSERT_TRUE(Becomes([&] {
    Shell(focus + "s");
    return fs::exists(first);
  })) << ReadFile(folder_ / "err");
  EXPECT_EQ(ReadPng(first).width, 320);
  EXPECT_EQ(replay.Wait(2), -1) << "the last step stays";
  ASSERT_EQ(Shell(focus + "Escape"), 0);
  EXPECT_EQ(replay.Wait(20), 0) << ReadFile(folder_ / "err");
  EXPECT_NE(ReadFile(folder_ / "out").find("the same bit for bit"), std::string::npos);
}

}  // namespace
}  // namespace hpdm
