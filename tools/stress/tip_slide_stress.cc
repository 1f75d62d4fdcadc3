#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/shared/report_text.h"
#include "tools/stress/haptic_parts.h"
#include "tools/stress/stress_touch_fixture.h"

namespace hpdm {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kNoForce = 1e-3;  // N: smaller counts as no force
constexpr double kClearly = 2e-4;  // m: deeper than this there must be force

// Returns the mean force while the tool slides, N.
double SlidingForce(const FeltTimeSeries& series, const PressAndSlide& way) {
  double sum = 0;
  const auto first = std::lround(1e3 * way.slides), last = std::lround(1e3 * way.ends);
  for (auto i = first; i < last; ++i) sum += series[i].reaction_W.norm();
  return sum / static_cast<double>(last - first);
}

// Returns the frequency of GeodesicEllipsoid() for about as many triangles.
int Frequency(double triangles) {
  return std::max(1, static_cast<int>(std::lround(std::sqrt(triangles / 20))));
}

StressTrial PointTool(StressModel model, double thousands, bool quick, const KeptTimeSeries& kept) {
  StressTool point;
  point.tool.geometries[0].tip_radius = 0;
  PressAndSlide way;
  const auto on = [&](double triangles) {
    StressTouchFixture fixture = SoftOrgan(model, quick);
    fixture.rest = GeodesicEllipsoid(Vector3d(0.1, 0.07, 0.05), Frequency(triangles));
    const StressTool tool = way.Tool(fixture.Top(0, 0.004), point);
    return Feel(fixture, tool, way.out + ToRest(model));
  };
  const FeltTouch felt = on(1e3 * thousands);
  const FeltTimeSeries& coarse = Kept(kept, model, [&] { return on(1e3).series; });
  int lost = 0;
  for (auto i = std::lround(1e3 * (way.slides - 0.1)); i < std::lround(1e3 * way.ends); ++i) {
    lost += felt.series[i].reaction_W.norm() < kNoForce;
  }
  const double meant = SlidingForce(coarse, way), force = SlidingForce(felt.series, way);
  StressTrial trial =
      JudgeTouch(model, std::abs(force / meant - 1), 0.1, 0.5, felt.outcome, way.leaves);
  if (lost > 0) Fail(Format("%d ticks without force", lost), &trial);
  ReportForces(force, meant, &trial);
  return trial;
}

StressTrial Breathing(StressModel model, double hertz, bool quick) {
  StressTouchFixture fixture = SoftOrgan(model, quick);
  fixture.organ.motion = {Vector3d(0.003, 0, 0.004), hertz};
  const Vector3d top = fixture.Top(0.02, 0.01);
  const double seconds = kRampedIn + std::max(1.0, 2 / hertz);
  const FeltTouch felt = Feel(fixture, OverOrgan({{0, Below(top, 0)}}), seconds);
  const SurfaceTree surface(fixture.rest.vertices, fixture.rest.triangles);
  int deep = 0, blind = 0;
  for (std::size_t i = 0; i < felt.series.size(); ++i) {
    const auto t_ns = static_cast<Nanoseconds>(i) * 1'000'000;
    if (t_ns < static_cast<Nanoseconds>(1e9 * kRampedIn)) continue;
    const Vector3d p_W = felt.series[i].p_tip_W - fixture.organ.motion.Offset(t_ns);
    if (Depth(surface, p_W, kDefaultToolRadius) < kClearly) continue;
    ++deep;
    blind += felt.series[i].reaction_W.norm() < kNoForce;
  }
  StressTrial trial = JudgeTouch(model, static_cast<double>(blind) / std::max(deep, 1), 0.01, 0.1,
                                 felt.outcome, kNever);
  if (deep == 0) Fail("never touched", &trial);
  return trial;
}

// Slides back and forth along the surface, 4 mm deep, 40 mm to either side of its top.
class SlideAlong {
 public:
  static constexpr double kReach = 0.04;              // m
  static constexpr double kBegins = kRampedIn + 0.3;  // s, after the entry

  explicit SlideAlong(const StressTouchFixture& fixture) {
    constexpr int kPlaces = 161;
    const SurfaceTree surface(fixture.rest.vertices, fixture.rest.triangles);
    for (int i = 0; i < kPlaces; ++i) {
      const double x = kReach * (2. * i / (kPlaces - 1) - 1);
      places_.push_back(Below(fixture.Top(surface, x, 0.004), 0.004));
    }
  }

  // Returns the position (0..1) between the two ends at time t (s).
  static double Along(double t, double speed) {
    const double phase = std::fmod((t - kBegins) * speed / (4 * kReach), 1.);
    return phase < 0.5 ? 2 * phase : 2 - 2 * phase;
  }

  StressTool Tool(double speed) const {
    StressTool tool = OverOrgan({{0, places_[0]}});
    tool.motion = [*this, speed](double t) {
      if (t >= kBegins) return At(Along(t, speed));
      StressPose pose = places_[0];
      pose.p_tip_W.z() += 0.02 * std::clamp(1 - (t - kRampedIn) / 0.2, 0., 1.);
      return pose;
    };
    return tool;
  }

 private:
  StressPose At(double along) const {
    const double at = along * static_cast<double>(places_.size() - 1);
    const auto i = std::min(static_cast<std::size_t>(at), places_.size() - 2);
    const double share = at - static_cast<double>(i);
    return {.p_tip_W = (1 - share) * places_[i].p_tip_W + share * places_[i + 1].p_tip_W};
  }

  std::vector<StressPose> places_;
};

StressTrial FastSlide(StressModel model, double speed, bool quick, const KeptTimeSeries& kept) {
  constexpr double kSlideSpeed = 0.04;  // m/s
  const StressTouchFixture fixture = SoftOrgan(model, quick);
  const SlideAlong way(fixture);
  const FeltTimeSeries& slow = Kept(kept, model, [&] {
    StressTouchFixture closely = fixture;
    closely.timing.deformation_hz = 60;
    closely.timing.patch_delay_ticks = 17;
    closely.organ.time_step = 1. / 60;
    return Feel(closely, way.Tool(kSlideSpeed),
                SlideAlong::kBegins + 2 * SlideAlong::kReach / kSlideSpeed)
        .series;
  });
  const double seconds = std::max(0.5, 4 * SlideAlong::kReach / speed);
  const FeltTouch felt = Feel(fixture, way.Tool(speed), SlideAlong::kBegins + seconds);
  FeltTimeSeries truth = felt.series;
  for (auto i = static_cast<std::size_t>(1e3 * SlideAlong::kBegins); i < truth.size(); ++i) {
    const double along = SlideAlong::Along(1e-3 * static_cast<double>(i), speed);
    const double t = SlideAlong::kBegins + along * 2 * SlideAlong::kReach / kSlideSpeed;
    truth[i] = slow[std::min(static_cast<std::size_t>(1e3 * t), slow.size() - 1)];
  }
  const double error = FeltError(felt.series, truth, SlideAlong::kBegins);
  return JudgeTouch(model, error, 0.1, 0.5, felt.outcome, kNever);
}

StressTrial StalePatches(StressModel model, double period_ms, bool quick,
                         const KeptTimeSeries& kept) {
  PressAndSlide way;
  StressTouchFixture fixture = SoftOrgan(model, quick);
  const StressTool tool = way.Tool(fixture.Top(0, 0.004));
  const auto at = [&](double hertz) {
    fixture.timing.deformation_hz = std::max(1, static_cast<int>(std::lround(hertz)));
    fixture.timing.patch_delay_ticks =
        (fixture.timing.haptic_hz + fixture.timing.deformation_hz - 1) /
        fixture.timing.deformation_hz;
    fixture.organ.time_step = 1. / fixture.timing.deformation_hz;
    return Feel(fixture, tool, way.out + ToRest(model) + 2 / hertz);
  };
  const FeltTouch felt = at(1e3 / period_ms);
  FeltTimeSeries truth = Kept(kept, model, [&] { return at(quick ? 100 : 200).series; });
  truth.resize(felt.series.size());
  const double error = FeltError(felt.series, truth, kRampedIn);
  return JudgeTouch(model, error, 0.1, 0.5, felt.outcome, way.leaves + 2e-3 * period_ms);
}

}  // namespace

std::vector<StressCase> TipSlideStress(bool quick) {
  std::vector<StressCase> cases;
  cases.push_back(
      {.name = "point_tool_on_fine_mesh",
       .group = {},
       .title = "Tool without a radius presses and slides 20 mm on a fine mesh",
       .truth = "the same model's force on 1,000 triangles; degraded from 10 %, failed "
                "from 50 %, or a tick in contact without force",
       .parameter = {"triangles", "thousand", 1, quick ? 5. : 30., quick ? 10. : 100., true},
       .models = kTouchModels,
       .run = [quick, kept = Keep()](StressModel model, double value) {
         return PointTool(model, value, quick, kept);
       }});
  cases.push_back(
      {.name = "breathing_under_still_tool",
       .group = {},
       .title = "Surface moves 5 mm past a still tool",
       .truth = "share of the ticks deeper than 0.2 mm in which there is no force; "
                "degraded from 1 %, failed from 10 %",
       .parameter = {"frequency", "Hz", 0.5, 2, 50, true},
       .models = kTouchModels,
       .run = [quick](StressModel model, double value) { return Breathing(model, value, quick); }});
  cases.push_back({.name = "fast_slide",
                   .group = {},
                   .title = "Tip slides back and forth over 80 mm, 4 mm deep",
                   .truth = "the force of the same places passed at 40 mm/s; degraded from 10 %, "
                            "failed from 50 % of the peak",
                   .parameter = {"speed", "m/s", 0.05, 1, 10, true},
                   .models = {},
                   .run = [quick, kept = Keep()](StressModel model, double value) {
                     return FastSlide(model, value, quick, kept);
                   }});
  cases.push_back(
      {.name = "stale_patches",
       .group = {},
       .title = "Longer deformation steps under a press that slides",
       .truth = "the force with a step every 5 to 10 ms; degraded from 10 %, failed from 50 % "
                "of the peak",
       .parameter = {"step", "ms", 10, 33, 500, true},
       .models = {},
       .run = [quick, kept = Keep()](StressModel model, double value) {
         return StalePatches(model, value, quick, kept);
       }});
  return cases;
}

}  // namespace hpdm
