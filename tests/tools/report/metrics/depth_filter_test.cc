#include "tools/report/metrics/depth_filter.h"

#include <gtest/gtest.h>

#include "tests/support/made_session.h"
#include "tools/report/metrics/verdicts.h"

namespace hpdm {
namespace {

// Ticks with this depth, m, of a tip that moves with it or stands 4 mm deep.
void PressTo(MadeSession* session, int ticks, double from, double to, bool tip_moves) {
  for (int i = 1; i <= ticks; ++i) {
    session->Tick([&](HapticSample* sample) {
      ToolSample& tool = sample->tools[0];
      tool.depth = from + (to - from) * i / ticks;
      tool.kind = tool.depth > 0 ? ContactKind::kPress : ContactKind::kNone;
      tool.organ = tool.depth > 0 ? 1 : -1;
      tool.p_tip_W.z() = tip_moves ? -tool.depth : -0.004;
    });
  }
}

// A tip that was led 30 mm deep counts, also within 10 ms. Tissue that jumps over a tip at rest by 30 mm,
// once or in every other tick, does not.
TEST(DepthFilter, CountsIfTheTipWasLedThereAndNotIfTheTissueJumpedOverIt) {
  MadeSession led;
  PressTo(&led, 10, 0, 0.03, true);
  PressTo(&led, 90, 0.03, 0.03, true);
  const HandReport hand = led.Finish().report.hands[0];
  EXPECT_NEAR(hand.contact.deepest_press, 0.03, 1e-9);
  EXPECT_NEAR(hand.contact.over_depth, 0.094, 1e-9);
  EXPECT_EQ(hand.contact.over_depth_count, 1u);
  EXPECT_EQ(hand.depth_unknown, 0);

  MadeSession jumps;
  PressTo(&jumps, 100, 0, 0.004, true);
  PressTo(&jumps, 1, 0.03, 0.03, false);
  PressTo(&jumps, 99, 0.03, 0.02, false);
  for (int i = 0; i < 50; ++i) {
    PressTo(&jumps, 1, 0, 0, false);
    PressTo(&jumps, 1, 0.4, 0.4, false);
  }
  PressTo(&jumps, 1, 0, 0, false);
  PressTo(&jumps, 100, 0, 0.006, true);
  const SessionReport report = jumps.Finish().report;
  EXPECT_NEAR(report.hands[0].contact.deepest_press, 0.006, 1e-9);
  EXPECT_EQ(report.hands[0].contact.over_depth_count, 0u);
  EXPECT_NEAR(report.hands[0].depth_unknown, 0.15, 0.006);
  EXPECT_EQ(Verdicts(report)[1].kind, Verdict::kOpen) << Verdicts(report)[1].text;
}

}  // namespace
}  // namespace hpdm
