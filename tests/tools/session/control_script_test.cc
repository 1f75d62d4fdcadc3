#include "tools/session/control_script.h"

#include <gtest/gtest.h>

#include "engine/base/error.h"

namespace hpdm {
namespace {

std::vector<InstrumentOptions> TwoHands() {
  std::vector<InstrumentOptions> instruments(2);
  instruments[0].name = "left";
  instruments[0].exchanges.resize(1);
  instruments[0].exchanges[0].name = "hook";
  instruments[1].name = "right";
  return instruments;
}

std::string ScriptError(const std::string& argument) {
  try {
    ParseExchanges({argument}, TwoHands());
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ControlScript, ExchangesAreAskedForInTheOrderOfTheirTimes) {
  ControlScript script = ParseExchanges({"left=left@2.5", "left=hook@1"}, TwoHands());
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

}  // namespace
}  // namespace hpdm
