#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "tools/haptics/organ_trials.h"
#include "tools/haptics/shaft_trials.h"
#include "tools/shared/report_text.h"
#include "tools/shared/simple_bodies.h"
#include "tools/stress/motion_block.h"
#include "tools/stress/stress_cases.h"

namespace hpdm {
namespace {

constexpr double kWhole = 1;            // s: the organs' supports are at their whole way
constexpr double kParted = 2;           // s: and back
constexpr double kOrgansEnd = 3;        // s
constexpr int kMeasuredEvery = 5;       // steps: the whole press is one of them
constexpr double kOrgansAtRest = 1e-4;  // m
constexpr double kDeepFailed = 0.5;     // share of the way or the wall from which a case has failed
constexpr double kDeepDegraded = 0.1;   // and from which it is degraded

StressCase OrganCase(std::string name, std::string title, StressParameter parameter,
                     std::string truth) {
  StressCase stress_case;
  stress_case.name = std::move(name);
  stress_case.group = "organs";
  stress_case.title = std::move(title);
  stress_case.truth = std::move(truth);
  stress_case.parameter = std::move(parameter);
  stress_case.models = LatticeModels();
  return stress_case;
}

OrganOptions Organ(const std::string& name, StressModel model, const Region& held,
                   const std::array<int, 3>& cells) {
  OrganOptions options;
  options.name = name;
  options.lattice.cells = cells;
  options.lattice.margin = 0.001;
  options.supports.push_back({held, {}});
  Choose(model, &options);
  options.lattice.local.functions = 0;
  return options;
}

// The outcome of organs that are pressed together by their motion and parted again.
struct PressedOrgans {
  double largest = 0;     // m, depth of one drawn organ in another, at any step
  double pair_force = 0;  // N, on the last organ when pressed
  double off_rest = 0;    // m, at the end
  bool finite = true;
  bool dropped = false;
};

PressedOrgans PressAndPart(OrganBench* bench) {
  bench->Start();
  PenetrationMeter meter;
  PressedOrgans pressed;
  const int last = bench->organs() - 1;
  int step = 0;
  while (bench->seconds() < kOrgansEnd) {
    const double t = bench->seconds();
    if (t > kParted) bench->StayAt(kParted);  // the motion would go on
    bench->Step();
    bench->StayAt(t + ToSeconds(OrganBench::kPeriod));
    if (t <= kParted && step++ % kMeasuredEvery == 0) meter.Measure(bench);
    if (t <= kWhole) pressed.pair_force = bench->PairForce(last).norm();
    pressed.dropped = pressed.dropped || (bench->record().flags & kStepContactsDropped) != 0;
    for (int o = 0; o < bench->organs(); ++o) {
      pressed.finite =
          pressed.finite && bench->organ(o).vertices.allFinite() && bench->PairForce(o).allFinite();
    }
  }
  pressed.largest = meter.result().largest;
  for (int o = 0; o < bench->organs(); ++o) {
    pressed.off_rest = std::max(
        pressed.off_rest,
        (bench->organ(o).vertices - bench->model(o).rest().vertices).rowwise().norm().maxCoeff());
  }
  return pressed;
}

StressTrial JudgeOrgans(const PressedOrgans& pressed, double error) {
  StressTrial trial = Judge(pressed.finite ? error : HUGE_VAL, kDeepDegraded, kDeepFailed);
  if (trial.fate != StressFate::kSurvived) {
    trial.how = Format("%.2g mm deep", 1e3 * pressed.largest);
  }
  if (pressed.dropped) {
    trial.fate = std::max(trial.fate, StressFate::kDegraded);
    trial.how = "contacts dropped";
  }
  if (pressed.off_rest > kOrgansAtRest) {
    trial.fate = StressFate::kFailed;
    trial.how = Format("%.2g mm stay", 1e3 * pressed.off_rest);
    trial.harm = trial.how;
  }
  if (!pressed.finite) trial.how = trial.harm = "not finite";
  return trial;
}

const char* const kDepthTruth =
    "largest depth of one drawn organ in the other after every fifth step, at samples 2 mm apart: "
    "degraded "
    "from 10 %, failed from 50 %, or if 0.1 mm stay a second after the organs part; no "
    "contact dropped";

OrganMotion DownBy(double way) { return {Vector3d(0, 0, -way), 0.5 / kWhole}; }

// Two plates of 60 x 60 mm, held at two ends, are pressed together by 8 mm and bend.
StressCase ThinOnThin(bool quick) {
  StressCase stress_case =
      OrganCase("thin_on_thin", "Two thin walls of 60 mm pressed on each other by 8 mm and parted",
                {"wall", "mm", 5, 3, 0.5}, Format("over the wall: %s", kDepthTruth));
  stress_case.run = [quick](StressModel model, double wall_mm) {
    constexpr double kHalf = 0.03, kApart = 1e-4, kWay = 0.008;
    const double wall = wall_mm / 1e3;
    const int squares = quick ? 16 : 24;
    OrganBench bench;
    for (const bool upper : {false, true}) {
      OrganOptions options = Organ(upper ? "upper" : "lower", model,
                                   BoxFraction{Vector3d::Zero(), Vector3d(0.1, 1, 1)}, {6, 6, 1});
      options.supports.push_back({BoxFraction{Vector3d(0.9, 0, 0), Vector3d::Ones()}, {}});
      if (upper) options.motion = DownBy(kWay + kApart);
      // The lower plate stands on the other two sides.
      if (!upper) {
        options.supports = {{BoxFraction{Vector3d::Zero(), Vector3d(1, 0.1, 1)}, {}},
                            {BoxFraction{Vector3d(0, 0.9, 0), Vector3d::Ones()}, {}}};
      }
      const double low = upper ? kApart : -wall;
      // The held borders of the upper plate end before those of the lower one.
      const double x = upper ? kHalf : 0.6 * kHalf, y = upper ? 0.6 * kHalf : kHalf;
      bench.Add(options,
                GridBox(Vector3d(-x, -y, low), Vector3d(x, y, low + wall), {squares, squares, 2}),
                upper ? std::optional(0.1) : std::nullopt);
    }
    const PressedOrgans pressed = PressAndPart(&bench);
    return JudgeOrgans(pressed, pressed.largest / wall);
  };
  return stress_case;
}

// Blocks whose faces are z = slope |x|, one above the other.
StressCase WedgeIntoCleft(bool quick) {
  StressCase stress_case =
      OrganCase("wedge_into_cleft", "A wedge pressed 4 mm into a cleft of its shape and parted",
                {"slope", "of the flanks", 0.3, 1, 4}, Format("over the way: %s", kDepthTruth));
  stress_case.run = [quick](StressModel model, double slope) {
    constexpr double kHalf = 0.02, kHeight = 0.03, kApart = 1e-4, kWay = 0.004;
    const int squares = quick ? 12 : 16;
    OrganBench bench;
    for (const bool upper : {false, true}) {
      BoxFraction held;
      (upper ? held.min : held.max).z() = upper ? 0.85 : 0.15;
      OrganOptions options = Organ(upper ? "wedge" : "cleft", model, held, {4, 3, 6});
      if (upper) options.motion = DownBy(kWay + kApart);
      SurfaceMesh mesh =
          GridBox(Vector3d(-kHalf, -kHalf, upper ? 0 : -kHeight),
                  Vector3d(kHalf, kHalf, upper ? kHeight : 0), {squares, squares, squares});
      for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
        auto p = mesh.vertices.row(v);
        const double rise = slope * std::abs(p[0]), from = slope * kHalf + kHeight;
        p[2] = upper ? kApart + rise + p[2] / kHeight * (from - rise)
                     : -kHeight + (p[2] + kHeight) / kHeight * (kHeight + rise);
      }
      bench.Add(options, mesh, upper ? std::optional(0.1) : std::nullopt);
    }
    const PressedOrgans pressed = PressAndPart(&bench);
    return JudgeOrgans(pressed, pressed.largest / kWay);
  };
  return stress_case;
}

// Without Poisson's ratio a stack is a bar.
StressCase Stacked(bool quick) {
  StressCase stress_case = OrganCase(
      "stacked_organs", "A stack of blocks of 15 mm pressed together by a tenth and let go",
      {"organs", "", 2, 4, 10},
      "force over that of a bar of the stack's height, or the largest depth of one drawn "
      "organ in the other over the way, what is larger: degraded from 10 %, failed from "
      "50 %, or if 0.1 mm stay a second after the organs part; no contact dropped");
  stress_case.models = {StressModel::kStrainSmall, StressModel::kStrainFinite};
  stress_case.run = [quick](StressModel model, double count) {
    constexpr double kHalf = 0.02, kHeight = 0.015;
    const int organs = Whole(count), squares = quick ? 8 : 12;
    const double way = 0.1 * kHeight * organs;
    OrganBench bench;
    for (int o = 0; o < organs; ++o) {
      // Inner blocks are held so softly that it does not count.
      OrganOptions options = Organ("block " + std::to_string(o), model, BoxFraction{}, {2, 2, 2});
      options.material.poisson = 0;
      options.supports[0].stiffness = 1e3;
      BoxFraction held;
      if (o == 0) held.max.z() = 0.05;
      if (o == organs - 1) held.min.z() = 0.95;
      if (o == 0 || o == organs - 1) options.supports[0] = {held, {}};
      if (o == organs - 1) options.motion = DownBy(way);
      bench.Add(options,
                GridBox(Vector3d(-kHalf, -kHalf, o * kHeight),
                        Vector3d(kHalf, kHalf, (o + 1) * kHeight), {squares, squares, squares / 2}),
                o > 0 ? std::optional(0.3) : std::nullopt);
    }
    const double young = bench.model(0).options().material.young;
    const double free = kHeight * (organs - 0.1);  // without what is held
    const double bar = young * 4 * kHalf * kHalf * way / free;
    const PressedOrgans pressed = PressAndPart(&bench);
    return JudgeOrgans(pressed,
                       std::max(std::abs(pressed.pair_force / bar - 1), pressed.largest / way));
  };
  return stress_case;
}

StressCase BreathingAgainstRigid(bool quick) {
  StressCase stress_case = OrganCase(
      "breathing_against_rigid", "An organ that breathes 10 mm to and fro against a rigid one",
      {"frequency", "Hz", 0.1, 0.5, 5, true},
      "largest depth of one drawn organ in the other after every fifth step of ten seconds or "
      "three "
      "breaths, at samples 2 mm apart, over the way: degraded from 10 %, failed from 50 %");
  stress_case.run = [quick](StressModel model, double frequency) {
    constexpr double kWay = 0.01, kApart = 1e-4;
    OrganBench bench;
    OrganOptions organ =
        Organ("organ", model, BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.3)}, {4, 4, 4});
    organ.motion = {Vector3d(0, 0, kWay), frequency};
    const int level = quick ? 3 : 4;
    Isometry3d X_WO = Isometry3d::Identity();
    X_WO.translation().z() = 0.02 + 0.03 + kApart;
    bench.Add(organ, Ellipsoid(Vector3d(0.04, 0.04, 0.03), level));
    OrganOptions wall;
    wall.name = "wall";
    wall.model = OrganModelType::kRigid;
    bench.Add(wall, Ellipsoid(Vector3d(0.05, 0.03, 0.02), level, X_WO), 0.1);
    bench.Start();
    PenetrationMeter meter;
    PressedOrgans pressed;
    const double seconds = std::min(10.0, 3 / frequency);
    for (int step = 0; bench.seconds() < seconds; ++step) {
      bench.Step();
      if (step % kMeasuredEvery == 0) meter.Measure(&bench);
      pressed.finite = pressed.finite && bench.organ(0).vertices.allFinite();
    }
    pressed.largest = meter.result().largest;
    return JudgeOrgans(pressed, pressed.largest / kWay);
  };
  return stress_case;
}

StressCase IncompressibleOrgans(bool quick) {
  StressCase stress_case = OrganCase(
      "incompressible_organs", "Two blocks with edges that do not match pressed together by 3 mm",
      {"Poisson's ratio", "", 0.3, 0.49, 0.499}, Format("over the way: %s", kDepthTruth));
  stress_case.run = [quick](StressModel model, double poisson) {
    constexpr double kHalf = 0.025, kHeight = 0.03, kWay = 0.003;
    OrganBench bench;
    for (const bool upper : {false, true}) {
      BoxFraction held;
      (upper ? held.min : held.max).z() = upper ? 0.95 : 0.05;
      OrganOptions options = Organ(upper ? "upper" : "lower", model, held, {3, 3, 3});
      options.material.poisson = poisson;
      if (upper) options.motion = DownBy(kWay);
      const int squares = upper ? 9 : (quick ? 12 : 16);
      bench.Add(options,
                GridBox(Vector3d(-kHalf, -kHalf, upper ? 0 : -kHeight),
                        Vector3d(kHalf, kHalf, upper ? kHeight : 0), {squares, squares, squares}),
                upper ? std::optional(0.1) : std::nullopt);
    }
    const PressedOrgans pressed = PressAndPart(&bench);
    return JudgeOrgans(pressed, pressed.largest / kWay);
  };
  return stress_case;
}

// Sweeps the shaft into a lobe whose top is at `top`, against the sweep at 0.1 m/s.
StressTrial JudgeSweep(const OrganOptions& lobe, const SurfaceMesh& rest, double top, double depth,
                       double speed) {
  const auto sweep_at = [&](double way_a_second) {
    FeltBench bench(lobe, rest);
    bench.feels_shaft = true;
    return SweepShaftDown(&bench, top, depth, way_a_second);
  };
  const ShaftSweep slow = sweep_at(0.1), sweep = sweep_at(speed);
  StressTrial trial = Judge(std::abs(sweep.last / slow.last - 1), kDeepDegraded, kDeepFailed);
  if (!(slow.last > 0)) trial.error.reset();
  if (!(sweep.least_held > 0)) {
    trial.fate = StressFate::kFailed;
    trial.how = "passes through";
  } else if (sweep.late > 1) {
    trial.fate = std::max(trial.fate, StressFate::kDegraded);
    trial.how = Format("%d ticks late", sweep.late);
  }
  return trial;
}

const char* const kSweepTruth =
    "force at rest against that of a sweep at 0.1 m/s: degraded from 10 % or if the force comes "
    "two ticks late, failed from 50 % or if there is a tick without force after the first";

StressCase ShaftThroughLobe(bool quick) {
  StressCase stress_case =
      OrganCase("shaft_through_lobe", "A shaft swept sideways 6 mm into a lobe of 10 mm",
                {"speed", "m/s", 0.3, 3, 30, true}, kSweepTruth);
  stress_case.run = [quick](StressModel model, double speed) {
    OrganOptions lobe = SoftLobe();
    Choose(model, &lobe);
    return JudgeSweep(lobe, Ellipsoid(Vector3d(0.01, 0.01, 0.03), quick ? 2 : 3), 0.03, 0.006,
                      speed);
  };
  return stress_case;
}

StressCase ShaftThroughFin(bool quick) {
  StressCase stress_case =
      OrganCase("shaft_over_fin", "A shaft swept 5 mm down on the edge of an upright wall",
                {"wall", "mm", 6, 2, 0.5}, kSweepTruth);
  stress_case.run = [quick](StressModel model, double wall_mm) {
    OrganOptions fin = SoftLobe();
    Choose(model, &fin);
    fin.lattice.cells = {1, 4, 6};
    fin.lattice.margin = 0.001;
    const double half = wall_mm / 2e3;
    const int squares = quick ? 8 : 14;
    return JudgeSweep(
        fin, GridBox(Vector3d(-half, -0.02, 0), Vector3d(half, 0.02, 0.03), {2, squares, squares}),
        0.03, 0.005, 1);
  };
  return stress_case;
}

}  // namespace

std::vector<StressCase> OrganStress(bool quick) {
  return {ThinOnThin(quick),
          WedgeIntoCleft(quick),
          Stacked(quick),
          BreathingAgainstRigid(quick),
          IncompressibleOrgans(quick),
          ShaftThroughLobe(quick),
          ShaftThroughFin(quick)};
}

}  // namespace hpdm
