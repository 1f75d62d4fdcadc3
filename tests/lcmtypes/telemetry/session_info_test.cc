#include "lcmtypes/telemetry/session_info.h"

#include <gtest/gtest.h>

namespace hpdm {
namespace {

using Names = std::vector<std::string>;

TEST(SessionInfo, TheStartsTextGivesItsInstrumentsBack) {
  for (const Names& names : {Names{}, Names{"probe"}, Names{"left", "right"}}) {
    EXPECT_EQ(InstrumentsIn(SessionStartText(names), names.size()), names);
    EXPECT_EQ(InstrumentsIn(SessionStartText(names), 2), names);
  }
  EXPECT_EQ(InstrumentsIn("the session began", 2), Names{});
}

TEST(SessionInfo, TheLastInstrumentTakesTheRest) {
  EXPECT_EQ(InstrumentsIn("instruments: hook, bent", 1), Names{"hook, bent"});
  EXPECT_EQ(InstrumentsIn("instruments: a, b, c", 2), (Names{"a", "b, c"}));
}

}  // namespace
}  // namespace hpdm
