#include <algorithm>
#include <cmath>

#include "tools/shared/report_text.h"
#include "tools/stress/haptic_parts.h"
#include "tools/stress/stress_touch_fixture.h"

namespace hpdm {
namespace {

// N: a force of this size is felt; below it, a contact counts as over.
constexpr double kFelt = 0.02;

// True if the force points downwards by more than a small share of the true force.
bool PullsIn(const FeltTimeSeries& series, const Vector3d& truth) {
  const double least = -std::max(kFelt, 0.05 * truth.norm());
  return std::any_of(series.begin(), series.end(),
                     [&](const ToolSample& tick) { return tick.reaction_W.z() < least; });
}

// True if no force is felt from `from` s.
bool FeelsNothing(const FeltTimeSeries& series, double from) {
  return std::all_of(series.begin() + std::lround(1e3 * from), series.end(),
                     [](const ToolSample& tick) { return tick.reaction_W.norm() < kFelt; });
}

StressTrial InsideAtStart(StressModel model, double depth_mm, bool quick) {
  constexpr double kLeaves = 0.8, kSpeed = 0.1, kAway = 0.02;  // s, m/s, m
  const StressTouchFixture fixture = SoftOrgan(model, quick);
  const Vector3d top = fixture.Top(0.02, 0.01);
  const double depth = 1e-3 * depth_mm;
  const StressPose deep = Below(top, depth), away = Below(top, -kAway);
  const double out = kLeaves + (depth + kAway) / kSpeed;
  const StressTool tool = OverOrgan({{kLeaves, deep}, {out, away}});
  const FeltTouch felt = Feel(fixture, tool, out + ToRest(model));
  const Vector3d truth = ForceGoneToSlowly(fixture, tool, away, deep);
  const Vector3d force = MeanForce(felt.series, kLeaves - 0.05, kLeaves);
  StressTrial trial = JudgeTouch(model, RelativeError(force, truth), 0.1, 0.5, felt.outcome,
                                 kLeaves + depth / kSpeed);
  if (PullsIn(felt.series, truth)) Fail("pulls inwards", &trial);
  if (!FeelsNothing(felt.series, out)) Fail("holds on to the tool", &trial);
  ReportForces(force.norm(), truth.norm(), &trial);
  return trial;
}

StressTrial ThroughWall(StressModel model, double speed, bool quick) {
  constexpr double kDepth = 0.015, kAway = 0.012, kLeaves = 1, kBack = 0.3;  // m, m, s, m/s
  const StressTouchFixture fixture = HollowOrgan(model, quick);
  const Vector3d top = fixture.Top(0.006, 0.004);
  const StressPose deep = Below(top, kDepth), away = Below(top, -kAway);
  const double out = kLeaves + (kDepth + kAway) / kBack;
  const StressTool tool = OverOrgan({{kRampedIn, away},
                                     {kRampedIn + (kDepth + kAway) / speed, deep},
                                     {kLeaves, deep},
                                     {out, away}});
  const FeltTouch felt = Feel(fixture, tool, out + ToRest(model));
  const Vector3d truth = ForceGoneToSlowly(fixture, tool, away, deep);
  const Vector3d force = MeanForce(felt.series, kLeaves - 0.05, kLeaves);
  StressTrial trial = JudgeTouch(model, RelativeError(force, truth), 0.1, 0.5, felt.outcome,
                                 kLeaves + kDepth / kBack);
  if (force.norm() < kFelt) Fail("tunnels: no force behind the wall", &trial);
  if (PullsIn(felt.series, truth)) Fail("pulls inwards", &trial);
  if (!FeelsNothing(felt.series, out)) Fail("holds on to the tool", &trial);
  ReportForces(force.norm(), truth.norm(), &trial);
  return trial;
}

// The device starts beyond the reach of any patch.
StressTrial FastTouch(StressModel model, double speed, bool quick) {
  constexpr double kDepth = 0.01, kAway = 0.08, kJudged = 0.2;  // m, m, s
  const StressTouchFixture fixture = SoftOrgan(model, quick);
  const Vector3d top = fixture.Top(0.02, 0.01);
  const StressPose deep = Below(top, kDepth), away = Below(top, -kAway);
  const double arrives = kRampedIn + (kAway + kDepth) / speed, leaves = arrives + kJudged;
  const double out = leaves + (kAway + kDepth) / speed;
  const StressTool tool =
      OverOrgan({{kRampedIn, away}, {arrives, deep}, {leaves, deep}, {out, away}});
  const FeltTouch felt = Feel(fixture, tool, out + ToRest(model));
  const Vector3d truth = ForceGoneToSlowly(fixture, tool, Below(top, -0.02), deep);
  const auto first = static_cast<std::size_t>(1e3 * arrives);
  double error = 0;
  int blind = 0;
  for (std::size_t i = first; i < first + 200; ++i) {
    error += RelativeError(felt.series[i].reaction_W, truth) / 200;
    blind += felt.series[i].reaction_W.norm() < kFelt;
  }
  StressTrial trial = JudgeTouch(model, error, 0.1, 0.5, felt.outcome, leaves + kDepth / speed);
  if (blind > 0 && trial.how.empty()) trial.how = Format("%d ms without force", blind);
  if (PullsIn(felt.series, truth)) Fail("pulls inwards", &trial);
  if (!FeelsNothing(felt.series, out + 0.3)) Fail("holds on to the tool", &trial);
  return trial;
}

// Another instrument is asked for while the tip presses. It must come when the tip is free, with
// its own force.
StressTrial Exchange(StressModel model, double depth_mm, bool quick) {
  constexpr double kSpeed = 0.1, kAway = 0.01;  // m/s, m
  const StressTouchFixture fixture = SoftOrgan(model, quick);
  const Vector3d top = fixture.Top(0.02, 0.01);
  const double depth = 1e-3 * depth_mm, way = (depth + kAway) / kSpeed;
  const StressPose deep = Below(top, depth), away = Below(top, -kAway);
  const double there = kRampedIn + way, asks = there + 0.2, leaves = asks + 0.2, out = leaves + way;
  const double again = out + 0.6 + way, end = again + 0.2, gone = end + way;
  StressTool tool = OverOrgan({{kRampedIn, away},
                               {there, deep},
                               {leaves, deep},
                               {out, away},
                               {out + 0.6, away},
                               {again, deep},
                               {end, deep},
                               {gone, away}});
  StressTool fine = tool;
  fine.tool.geometries[0].tip_radius = 0.001;
  tool.tool.geometries.push_back(fine.tool.geometries[0]);
  StressSessionFixture body(fixture.organ, fixture.rest, {tool}, fixture.timing);
  FeltTimeSeries series;
  body.RunUntil(asks, &series);
  SessionControl control;
  control.instrument_index[0] = 1;
  body.Ask(control);
  body.RunUntil(gone + ToRest(model), &series);

  const Vector3d before = MeanForce(series, asks - 0.05, asks);
  const Vector3d after = MeanForce(series, asks, leaves);
  const Vector3d truth = ForceGoneToSlowly(fixture, fine, away, deep);
  const Vector3d other = MeanForce(series, end - 0.05, end);
  const double kept = RelativeError(after, before), taken = RelativeError(other, truth);
  StressTrial trial =
      JudgeTouch(model, std::max(kept, taken), 0.1, 0.5, body.outcome(), end + depth / kSpeed);
  if (series[std::lround(1e3 * leaves)].instrument_index != 0)
    Fail("exchanged inside the tissue", &trial);
  if (series[std::lround(1e3 * (out + 0.5))].instrument_index != 1) Fail("never exchanged", &trial);
  if (kept > taken) ReportForces(after.norm(), before.norm(), &trial);
  ReportForces(other.norm(), truth.norm(), &trial);
  return trial;
}

}  // namespace

std::vector<StressCase> TipEntryStress(bool quick) {
  const std::string place = "the force of the same place reached slowly";
  std::vector<StressCase> cases;
  cases.push_back({.name = "tool_inside_at_start",
                   .group = {},
                   .title = "Session begins with the tool inside the organ",
                   .truth = place +
                            " from outside; degraded from 10 %, failed from 50 %, or pulled "
                            "in, or held after it is out",
                   .parameter = {"depth", "mm", 2, 15, 45},
                   .models = kTouchModels,
                   .run = [quick](StressModel model, double value) {
                     return InsideAtStart(model, value, quick);
                   }});
  cases.push_back({.name = "through_thin_wall",
                   .group = {},
                   .title = "Tool 15 mm through the 3 mm wall of a hollow organ",
                   .truth = place + "; degraded from 10 %, failed from 50 %, or tunnelled, pulled "
                                    "in, or held after it is out",
                   .parameter = {"speed", "m/s", 0.1, 10, 100, true},
                   .models = kTouchModels,
                   .run = [quick](StressModel model, double value) {
                     return ThroughWall(model, value, quick);
                   }});
  cases.push_back(
      {.name = "fast_device",
       .group = {},
       .title = "Device comes from 80 mm away, 10 mm deep",
       .truth = place + ", over the first 0.2 s; degraded from 10 %, failed from 50 %, "
                        "or pulled in, or held after it is out",
       .parameter = {"speed", "m/s", 0.1, 1, 10, true},
       .models = kTouchModels,
       .run = [quick](StressModel model, double value) { return FastTouch(model, value, quick); }});
  cases.push_back(
      {.name = "exchange_while_deep",
       .group = {},
       .title = "Another instrument asked for while the tip presses",
       .truth = "the force before, as long as it presses, and then " + place +
                " with the other one; degraded from 10 %, failed from 50 %, or if it "
                "is exchanged inside the tissue or never",
       .parameter = {"depth", "mm", 2, 15, 40},
       .models = {},
       .run = [quick](StressModel model, double value) { return Exchange(model, value, quick); }});
  return cases;
}

}  // namespace hpdm
