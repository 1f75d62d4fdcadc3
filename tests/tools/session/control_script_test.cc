#include "tools/session/control_script.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/base/error.h"

namespace hpdm {
namespace {

Scene TwoHands() {
  Scene scene;
  std::vector<InstrumentOptions>& instruments = scene.instruments;
  instruments.resize(2);
  instruments[0].name = "left";
  instruments[0].exchanges.resize(1);
  instruments[0].exchanges[0].name = "hook";
  instruments[1].name = "right";
  scene.exercise.emplace().steps.resize(3);
  return scene;
}

std::string ScriptError(const std::string& argument) {
  try {
    ParseControls({.exchanges = {argument}}, TwoHands());
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ControlScript, ExchangesAreAskedForInTheOrderOfTheirTimes) {
  ControlScript script = ParseControls({.exchanges = {"left=left@2.5", "left=hook@1"}}, TwoHands());
  TripleBuffer<SessionControl> edge;
  script.Advance(999'999'999, &edge);
  EXPECT_FALSE(edge.Update()) << "nothing is asked before its time";
  script.Advance(1'000'000'000, &edge);
  EXPECT_TRUE(edge.Update());
  EXPECT_EQ(edge.Front().instrument_index[0], 1);
  EXPECT_EQ(script.Left(), std::vector<std::string>{"exchange of left to left at 2.5 s"});
  script.Advance(2'000'000'000, &edge);
  EXPECT_FALSE(edge.Update());
  script.Advance(9'000'000'000, &edge);
  EXPECT_TRUE(edge.Update());
  EXPECT_EQ(edge.Front().instrument_index[0], 0);
  EXPECT_TRUE(script.Left().empty());
}

TEST(ControlScript, AnInvalidExchangeIsNamedWithTheRemedy) {
  for (const char* text : {"left=hook", "left=hook@", "left=hook@x", "left=hook@-1", "@"}) {
    EXPECT_NE(ScriptError(text).find("give NAME=OTHER@SECONDS"), std::string::npos) << text;
  }
  EXPECT_NE(ScriptError("right=hook@1").find("the scene has left=left, left=hook, right=right"),
            std::string::npos);
}

TEST(ControlScript, APedalIsPressedBetweenItsTimesAndKeepsTheExchanges) {
  ControlScript script = ParseControls(
      {.exchanges = {"left=hook@1"}, .pedals = {"left@2-3.5", "right@3-4"}}, TwoHands());
  TripleBuffer<SessionControl> edge;
  const auto at = [&](double seconds) {
    script.Advance(std::llround(seconds * 1e9), &edge);
    edge.Update();
    return edge.Front();
  };
  EXPECT_EQ(at(1.999).pedal, (std::array<bool, kMaxInstruments>{false, false}));
  EXPECT_EQ(at(2).pedal, (std::array<bool, kMaxInstruments>{true, false}));
  EXPECT_EQ(at(3.2).pedal, (std::array<bool, kMaxInstruments>{true, true}));
  EXPECT_EQ(at(3.5).pedal, (std::array<bool, kMaxInstruments>{false, true}));
  EXPECT_EQ(at(9).pedal, (std::array<bool, kMaxInstruments>{false, false}));
  EXPECT_EQ(at(9).instrument_index[0], 1);
}

TEST(ControlScript, AnInvalidPressOfAPedalIsNamedWithTheRemedy) {
  const auto error_of = [](const std::string& argument) -> std::string {
    try {
      ParseControls({.pedals = {argument}}, TwoHands());
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  for (const char* text : {"left", "left@3", "left@3-3", "left@4-3", "left@-3-4", "left@x-4"}) {
    EXPECT_NE(error_of(text).find("give NAME@FROM-TO"), std::string::npos) << text;
  }
  EXPECT_EQ(error_of("hook@1-2"),
            "--pedal hook@1-2: unknown instrument; the scene has left, right");
}

TEST(ControlScript, APauseKeepsTheControlsAndStaysWithLaterOnes) {
  ControlScript script = ParseControls({.exchanges = {"left=hook@1", "left=left@2"}}, TwoHands());
  TripleBuffer<SessionControl> edge;
  script.SetPaused(true, &edge);
  ASSERT_TRUE(edge.Update());
  EXPECT_TRUE(edge.Front().paused);
  EXPECT_EQ(edge.Front().instrument_index[0], 0);
  script.Advance(1'000'000'000, &edge);
  ASSERT_TRUE(edge.Update());
  EXPECT_TRUE(edge.Front().paused);
  EXPECT_EQ(edge.Front().instrument_index[0], 1);
  script.SetPaused(false, &edge);
  ASSERT_TRUE(edge.Update());
  EXPECT_FALSE(edge.Front().paused);
  EXPECT_EQ(edge.Front().instrument_index[0], 1);
  script.Advance(2'000'000'000, &edge);
  ASSERT_TRUE(edge.Update());
  EXPECT_FALSE(edge.Front().paused);
}

TEST(ControlScript, RestartsOfTheCommandLineAndOfTheTeacherAreCountedTogether) {
  ControlScript script =
      ParseControls({.exchanges = {"left=hook@1"}, .restarts = {"2@2", "3@5"}}, TwoHands());
  TripleBuffer<SessionControl> edge;
  const auto at = [&](double seconds) {
    script.Advance(std::llround(seconds * 1e9), &edge);
    edge.Update();
    return edge.Front().restart;
  };
  EXPECT_EQ(at(1.5).count, 0);
  EXPECT_EQ(at(2).count, 1);
  EXPECT_EQ(at(2.5).step, 1);
  script.Restart(RestartRequest::kPresent, &edge);
  EXPECT_EQ(at(3).count, 2);
  EXPECT_EQ(at(3).step, RestartRequest::kPresent);
  EXPECT_EQ(edge.Front().instrument_index[0], 1);
  EXPECT_EQ(at(5).count, 3);
  EXPECT_EQ(at(5).step, 2);
}

TEST(ControlScript, AnInvalidRestartIsNamedWithTheRemedy) {
  const auto error_of = [](const std::string& argument, const Scene& scene) -> std::string {
    try {
      ParseControls({.restarts = {argument}}, scene);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  for (const char* text : {"2", "@3", "x@3", "2x@3", "2@", "2@-1"}) {
    EXPECT_NE(error_of(text, TwoHands()).find("give STEP@SECONDS"), std::string::npos) << text;
  }
  for (const char* text : {"0@3", "4@3"}) {
    EXPECT_NE(error_of(text, TwoHands()).find("give 1 to 3"), std::string::npos) << text;
  }
  EXPECT_EQ(error_of("1@2", Scene()), "--restart 1@2: the scene has no exercise; leave it out");
}

}  // namespace
}  // namespace hpdm
