#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <random>
#include <utility>

#include "haptics/device/sim_device.h"
#include "tools/shared/report_text.h"
#include "tools/stress/motion_block.h"
#include "tools/stress/stress_cases.h"
#include "tools/stress/stress_touch_fixture.h"

namespace hpdm {
namespace {

constexpr double kEnergyShare = 0.01;             // of the work, unexplained
constexpr double kLeastWork = 1e-6;               // J: contacts with less put in do not count
constexpr double kStillSpeed = 1e-3;              // m/s, RMS
constexpr double kStillTurn = 0.5;                // degrees
constexpr double kTouchDepth = 0.005;             // m
constexpr double kHoldDepth = 0.015;              // m
const std::vector<StressModel> kEnergyModels = {  // those with a stiffness
    StressModel::kStrainSmall, StressModel::kStrainFinite, StressModel::kMetricSmall,
    StressModel::kMetricFinite, StressModel::kContinuum};
const std::vector<StressModel> kViscousModels = {StressModel::kStrainSmall,
                                                 StressModel::kMetricSmall};

StressCase TouchCase(std::string name, std::string title, std::string truth,
                     StressParameter parameter) {
  StressCase stress_case;
  stress_case.name = std::move(name);
  stress_case.group = "touch";
  stress_case.title = std::move(title);
  stress_case.truth = std::move(truth);
  stress_case.parameter = std::move(parameter);
  stress_case.models = kEnergyModels;
  return stress_case;
}

std::string EnergyTruth() {
  return Format(
      "the hand's work against the force before the guard: the largest part, over each contact, "
      "that is neither in the organ nor dissipated by friction; degraded from %.1f %%, failed "
      "from %.0f %% of the work put in, where that is 1 uJ or more",
      50 * kEnergyShare, 100 * kEnergyShare);
}

std::string ViscousTruth() {
  return EnergyTruth() +
         "; dissipated also by the dashpots of three terms of equal shares, 20 ms, 0.5 s and 5 s";
}

StressTrial JudgeEnergy(const ContactRecord& record, double tip_radius, ContactKind kind) {
  const ContactBalance* worst = nullptr;
  const std::vector<ContactBalance> balances = BalancesOf(record.ticks, record.stored, tip_radius);
  for (const ContactBalance& balance : balances) {
    if (balance.kind != kind || balance.judged < 3 || balance.put_in < kLeastWork) continue;
    if (worst == nullptr || balance.Error() > worst->Error()) worst = &balance;
  }
  if (worst == nullptr) {
    StressTrial trial;
    Fail("no contact", &trial);
    return trial;
  }
  StressTrial trial = Judge(worst->Error(), 0.5 * kEnergyShare, kEnergyShare);
  trial.how = Format("%.2g of %.2g mJ", 1e3 * worst->unexplained, 1e3 * worst->put_in);
  if (worst->dissipated != 0) trial.how += Format(", %.2g relaxed", 1e3 * worst->dissipated);
  if (worst->friction != 0) trial.how += Format(", %.2g rubbed", 1e3 * worst->friction);
  return trial;
}

// Adds the harm that the run did to hand or tissue. The tool need not have left.
StressTrial WithHarm(StressTrial trial, const StressOutcome& outcome) {
  AddFaults(outcome, std::numeric_limits<double>::infinity(), &trial);
  if (!trial.harm.empty()) Fail(trial.harm, &trial);
  return trial;
}

StressTool WithTip(double radius_mm, double friction = 0) {
  StressTool tool;
  tool.tool.geometries[0].tip_radius = 1e-3 * radius_mm;
  tool.tool.geometries[0].friction = friction;
  return tool;
}

// Terms with these shares in all: fast, about as fast as a motion, and slow.
PronySeries Relaxing(double share) {
  return {.count = 3, .terms = {{{share / 3, 0.02}, {share / 3, 0.5}, {share / 3, 5}}}};
}

// Presses, slides forth and back and withdraws.
StressTrial SlideEnergy(StressModel model, const StressTool& held, double length, double speed,
                        bool quick, const PronySeries& prony = {}) {
  StressTouchFixture fixture = SoftOrgan(model, quick);
  fixture.organ.material.prony = prony;
  PressAndSlide way{.depth = kTouchDepth, .length = length, .speed = speed};
  const StressTool tool = way.Tool(fixture.Top(0, 0.004), held);
  StressSessionFixture body(fixture.organ, fixture.rest, {tool}, fixture.timing);
  ContactRecord record;
  body.RunUntil(way.out + ToRest(model), nullptr, &record);
  return WithHarm(JudgeEnergy(record, held.tool.geometries[0].tip_radius, ContactKind::kPress),
                  body.outcome());
}

StressTrial GraspEnergy(StressModel model, double lift_mm, bool quick,
                        const PronySeries& prony = {}) {
  constexpr double kLiftTime = 0.5;  // s
  const double released = kBlockStart + kLiftTime + 0.2;
  const StressPose far = AtBlock(0, kDefaultToolRadius + 1e-3 * lift_mm, 0);
  OrganOptions organ = BlockOrgan(model, quick);
  organ.material.prony = prony;
  StressSessionFixture body(organ, BlockSurface(quick), {BlockGrasp(0, far, kLiftTime, released)});
  ContactRecord record;
  body.RunUntil(released, nullptr, &record);
  return WithHarm(JudgeEnergy(record, kDefaultToolRadius, ContactKind::kGrasp), body.outcome());
}

// Straight ways at 5 to 50 mm/s between places over the organ and up to 6 mm deep in it, with pauses.
StressTool WanderingTool(const StressTouchFixture& fixture, const StressTool& held,
                         double seconds) {
  constexpr double kWide = 0.02, kHigh = 0.004, kDeep = 0.006;  // m
  std::mt19937 random(20);
  std::uniform_real_distribution<double> share(0, 1);
  const SurfaceTree surface(fixture.rest.vertices, fixture.rest.triangles);
  std::vector<std::pair<double, StressPose>> way = {
      {kRampedIn, Below(fixture.Top(surface, 0, 0.004), -kHigh, held)}};
  while (way.back().first < seconds) {
    const double x = kWide * (2 * share(random) - 1), y = kWide * (2 * share(random) - 1);
    const double depth = kDeep - (kDeep + kHigh) * share(random);
    const StressPose next = Below(fixture.Top(surface, x, y), depth, held);
    const double length = (next.p_tip_W - way.back().second.p_tip_W).norm();
    way.emplace_back(way.back().first + length / (0.005 + 0.045 * share(random)), next);
    if (share(random) < 0.3) way.emplace_back(way.back().first + share(random), next);
  }
  StressTool tool = OverOrgan(way);
  tool.tool = held.tool;
  return tool;
}

StressTrial WanderEnergy(StressModel model, const PronySeries& prony, double seconds, bool quick) {
  StressTouchFixture fixture = SoftOrgan(model, quick);
  fixture.organ.material.prony = prony;
  const StressTool held = WithTip(2.5, 0.3);
  StressSessionFixture body(fixture.organ, fixture.rest, {WanderingTool(fixture, held, seconds)},
                            fixture.timing);
  ContactRecord record;
  body.RunUntil(seconds, nullptr, &record);
  return WithHarm(JudgeEnergy(record, held.tool.geometries[0].tip_radius, ContactKind::kPress),
                  body.outcome());
}

// A ball of 40 mm radius: each edge of its mesh turns the surface by about 11 degrees, as on the
// shipped organs.
StressTouchFixture FacetedOrgan(StressModel model, bool quick) {
  StressTouchFixture fixture = SoftOrgan(model, quick);
  fixture.rest = GeodesicEllipsoid(Vector3d::Constant(0.04), 6);
  return fixture;
}

// Dry friction would hide that a force shakes.
DeviceProfile WithoutFriction() {
  DeviceProfile profile;
  profile.friction = 0;
  profile.rotational_friction = 0;
  return profile;
}

// A simulated hand whose true position, before the encoders, is recorded.
class WatchedHand final : public SimDevice {
 public:
  WatchedHand(const ImpulseEngineKinematics& kinematics, std::unique_ptr<Hand> hand,
              std::vector<Vector3d>* points)
      : SimDevice(WithoutFriction(), kinematics, std::move(hand)),
        kinematics_(kinematics),
        points_(points) {}
  DeviceSample Read(Nanoseconds now) noexcept override {
    const DeviceSample sample = SimDevice::Read(now);
    points_->push_back(kinematics_.Forward(joints()).translation());
    return sample;
  }

 private:
  ImpulseEngineKinematics kinematics_;
  std::vector<Vector3d>* points_;
};

// A hand without tremor.
class CalmHand final : public Hand {
 public:
  explicit CalmHand(std::function<StressPose(double)> motion)
      : Hand(300, 6), motion_(std::move(motion)) {}
  HandIntent At(Nanoseconds t_ns) noexcept override {
    constexpr double kBack = 5e-4;  // s
    const double t = ToSeconds(t_ns);
    const Vector3d p_W = motion_(t).p_tip_W;
    return {.p_W = p_W, .v_W = (p_W - motion_(t - kBack).p_tip_W) / kBack};
  }

 private:
  std::function<StressPose(double)> motion_;
};

// Places along the top, kHoldDepth deep, where the tool stops in turn.
class Stops {
 public:
  static constexpr double kHold = 0.35;    // s at each place
  static constexpr double kTravel = 0.1;   // s from one to the next
  static constexpr double kJudged = 0.15;  // s, at the end of each hold

  // `apart`: m between two places.
  Stops(const StressTouchFixture& fixture, const StressTool& held, int places, double apart) {
    const SurfaceTree surface(fixture.rest.vertices, fixture.rest.triangles);
    std::vector<StressPose> poses;
    for (int i = 0; i < places; ++i) {
      const double x = apart * (i - 0.5 * (places - 1));
      poses.push_back(Below(fixture.Top(surface, x, 0.0043), kHoldDepth, held));
    }
    StressPose over = poses[0];
    over.p_tip_W.z() += 0.015;
    way_ = {{kRampedIn, over}};
    const auto visit = [&](int place) {
      const double arrives = way_.back().first + (places_.empty() ? 0.5 : kTravel);
      way_.emplace_back(arrives, poses[ToSize(place)]);
      way_.emplace_back(arrives + kHold, poses[ToSize(place)]);
      places_.push_back(place);
    };
    for (int i = 0; i < places; ++i) visit(i);
    for (int i = places - 2; i >= 0; --i) visit(i);
  }

  StressTool Tool(const StressTool& held) const {
    StressTool tool = OverOrgan(way_);
    tool.tool = held.tool;
    return tool;
  }
  double End() const { return way_.back().first; }
  int visits() const { return static_cast<int>(places_.size()); }
  int place(int visit) const { return places_[ToSize(visit)]; }
  // Returns the tick after the hold of a visit.
  std::size_t EndOf(int visit) const {
    return static_cast<std::size_t>(std::floor(1e3 * way_[ToSize(2 * visit + 2)].first));
  }

 private:
  std::vector<std::pair<double, StressPose>> way_;
  std::vector<int> places_;
};

constexpr auto kJudgedTicks = static_cast<std::ptrdiff_t>(1e3 * Stops::kJudged);

StressTrial StillHand(StressModel model, double radius_mm, bool quick) {
  const StressTouchFixture fixture = FacetedOrgan(model, quick);
  const StressTool held = WithTip(radius_mm);
  const Stops stops(fixture, held, quick ? 3 : 9, 0.002);
  StressTool tool = stops.Tool(held);
  std::vector<Vector3d> points;
  tool.device = [&](const ImpulseEngineKinematics& kinematics) {
    return std::make_unique<WatchedHand>(kinematics, std::make_unique<CalmHand>(tool.motion),
                                         &points);
  };
  StressSessionFixture body(fixture.organ, fixture.rest, {tool}, fixture.timing);
  FeltTimeSeries series;
  body.RunUntil(stops.End(), &series);
  double speed = 0, force = 1e300;
  for (int visit = 0; visit < stops.visits(); ++visit) {
    const auto end = static_cast<std::ptrdiff_t>(stops.EndOf(visit));
    speed = std::max(speed,
                     RmsSpeed({points.begin() + end - kJudgedTicks, points.begin() + end}, 1e-3));
    force = std::min(force, series[ToSize(end - 1)].reaction_W.norm());
  }
  StressTrial trial = Judge(speed / kStillSpeed, 0.5, 1);
  trial.how = Format("%.2g mm/s", 1e3 * speed);
  if (force < 0.01) Fail("no contact", &trial);
  return WithHarm(trial, body.outcome());
}

StressTrial StillPose(StressModel model, double radius_mm, bool quick) {
  const StressTouchFixture fixture = FacetedOrgan(model, quick);
  const StressTool held = WithTip(radius_mm);
  const Stops stops(fixture, held, quick ? 7 : 25, 0.001);
  const FeltTouch felt = Feel(fixture, stops.Tool(held), stops.End());
  std::vector<std::vector<Vector3d>> forces;
  double turn = 0;
  for (int visit = 0; visit < stops.visits(); ++visit) {
    const auto place = ToSize(stops.place(visit));
    if (place == forces.size()) forces.emplace_back();
    const std::size_t end = stops.EndOf(visit);
    for (std::size_t i = end - static_cast<std::size_t>(kJudgedTicks); i < end; i += 3) {
      forces[place].push_back(felt.series[i].reaction_W);
    }
    turn = std::max(turn, LargestTurn(forces[place], 0.01) * 180 / std::numbers::pi);
  }
  StressTrial trial = Judge(turn / kStillTurn, 0.5, 1);
  trial.how = Format("%.2g deg", turn);
  if (felt.series[stops.EndOf(0) - 1].reaction_W.norm() < 0.01) Fail("no contact", &trial);
  return WithHarm(trial, felt.outcome);
}

// The cases of energy on viscoelastic tissue.
void AddViscousCases(bool quick, double random_seconds, std::vector<StressCase>* cases) {
  const StressParameter share = {"share", "of E_0", 0.3, 0.75, 0.9};
  const auto add = [&](const char* name, const std::string& title,
                       const std::function<StressTrial(StressModel, const PronySeries&)>& run) {
    cases->push_back(TouchCase(name, title, ViscousTruth(), share));
    cases->back().models = kViscousModels;
    cases->back().run = [run](StressModel model, double all) { return run(model, Relaxing(all)); };
  };
  for (const double radius_mm : {2.5, 15.0}) {
    add(radius_mm > 10 ? "viscous_press_wide" : "viscous_press",
        Format("Viscoelastic: tip of %.1f mm pressed 5 mm deep at 20 mm/s and withdrawn",
               radius_mm),
        [=](StressModel model, const PronySeries& prony) {
          return SlideEnergy(model, WithTip(radius_mm), 0, 0.02, quick, prony);
        });
    add(radius_mm > 10 ? "viscous_slide_wide" : "viscous_slide",
        Format("Viscoelastic: tip of %.1f mm slides 30 mm forth and back at 20 mm/s", radius_mm),
        [=](StressModel model, const PronySeries& prony) {
          return SlideEnergy(model, WithTip(radius_mm), 0.03, 0.02, quick, prony);
        });
  }
  add("viscous_rub",
      "Viscoelastic: the same with a tip of 2.5 mm and a friction coefficient of 0.3",
      [=](StressModel model, const PronySeries& prony) {
        return SlideEnergy(model, WithTip(2.5, 0.3), 0.03, 0.02, quick, prony);
      });
  add("viscous_grasp", "Viscoelastic: grasped at the top and lifted by 5 mm in 0.5 s",
      [=](StressModel model, const PronySeries& prony) {
        return GraspEnergy(model, 5, quick, prony);
      });
  add("viscous_random",
      Format("Viscoelastic: random ways with friction, %.0f s; every contact", random_seconds),
      [=](StressModel model, const PronySeries& prony) {
        return WanderEnergy(model, prony, random_seconds, quick);
      });
}

}  // namespace

std::vector<StressCase> TouchStress(bool quick, double random_seconds) {
  const StressParameter radius = {"tip radius", "mm", 2.5, 10, 15};
  std::vector<StressCase> cases;
  cases.push_back(TouchCase("press_energy", "Tip pressed 5 mm deep at 20 mm/s and withdrawn",
                            EnergyTruth(), radius));
  cases.back().run = [quick](StressModel model, double radius_mm) {
    return SlideEnergy(model, WithTip(radius_mm), 0, 0.02, quick);
  };
  cases.push_back(TouchCase("slide_energy",
                            "Tip slides 30 mm forth and back at 20 mm/s, 5 mm deep at first",
                            EnergyTruth(), radius));
  cases.back().run = [quick](StressModel model, double radius_mm) {
    return SlideEnergy(model, WithTip(radius_mm), 0.03, 0.02, quick);
  };
  cases.push_back(TouchCase("rub_energy",
                            "The same with a tip of 2.5 mm and a friction coefficient of 0.3",
                            EnergyTruth(), {"speed", "m/s", 0.01, 0.05, 1, true}));
  cases.back().run = [quick](StressModel model, double speed) {
    return SlideEnergy(model, WithTip(2.5, 0.3), 0.03, speed, quick);
  };
  cases.push_back(TouchCase("grasp_energy", "Grasped at the top and lifted in 0.5 s", EnergyTruth(),
                            {"lift", "mm", 5, 15, 60}));
  cases.back().run = [quick](StressModel model, double lift_mm) {
    return GraspEnergy(model, lift_mm, quick);
  };
  AddViscousCases(quick, random_seconds, &cases);
  cases.push_back(TouchCase(
      "still_hand",
      "A hand without tremor, a device without friction: tip held still, 15 mm deep, 2 mm apart",
      "the tip's RMS speed over 1 mm/s, at the worst place; degraded from 50 %, failed from 100 %",
      radius));
  cases.back().run = [quick](StressModel model, double radius_mm) {
    return StillHand(model, radius_mm, quick);
  };
  cases.push_back(TouchCase(
      "still_pose", "Tip held 15 mm deep at places 1 mm apart, each reached from both sides",
      "the largest angle between the forces of two ticks of one pose, before the guard, over 0.5 "
      "degrees; degraded from 50 %, failed from 100 %",
      radius));
  cases.back().run = [quick](StressModel model, double radius_mm) {
    return StillPose(model, radius_mm, quick);
  };
  return cases;
}

}  // namespace hpdm
