#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/shared/report_text.h"
#include "tools/shared/simple_bodies.h"
#include "tools/stress/part_cases.h"

namespace hpdm {
namespace {

// A block that a duct along z holds to the world below it. The block moves.
struct HungDuct {
  double young = 3e4;  // Pa, of the block
  bool rigid = false;
  Vector3d motion_W = Vector3d::Zero();  // m, of the block's support
  double wall_young = 5e5;               // Pa
  double radius = 0.002;                 // m
  double length = 0.03;                  // m
  double bow = 0;                        // m, of the duct at rest, in its middle

  DuctOptions Duct() const {
    DuctOptions duct;
    duct.name = "duct";
    duct.b = "block";
    duct.path_W.resize(3, 3);
    duct.path_W << 0, 0, 0, bow, 0, length / 2, 0, 0, length;
    duct.radius = radius;
    duct.wall = 0.4 * radius;
    duct.young = wall_young;
    return duct;
  }
  TubeSection Section() const { return {wall_young, radius, 0.4 * radius, kDuctPoisson}; }
  // N/m, for small pulls of a clamped duct: across and along.
  double Across() const {
    const TubeSection s = Section();
    return 1 / (std::pow(length, 3) / (12 * s.bending) + length / s.across);
  }
  double Along() const { return Section().axial / length; }

  void Start(OrganBench* bench, const std::vector<ToolOptions>& tools = {}) const {
    OrganOptions block;
    block.name = "block";
    block.material = {.young = young, .poisson = 0.3};
    block.lattice.cells = {3, 3, 2};
    block.lattice.margin = 0.0005;
    block.lattice.local.functions = 0;
    block.motion = {motion_W, 0.5 / kPartHalf};
    if (rigid) {
      block.model = OrganModelType::kRigid;
    } else {
      block.supports.push_back({BoxFraction{Vector3d(0, 0, 0.5), Vector3d::Ones()}, {}});
    }
    bench->Add(block, GridBox(Vector3d(-0.015, -0.015, length),
                              Vector3d(0.015, 0.015, length + 0.015), {6, 6, 4}));
    bench->Join(Duct());
    bench->Start(tools);
  }
};

const DuctState& DuctIn(const OrganBench& bench) {
  return bench.loop().links()[0].state().ducts()[0];
}

bool DuctIsFinite(const OrganBench& bench) {
  const Rod& rod = DuctIn(bench).rod();
  for (int i = 0; i < rod.nodes(); ++i) {
    if (!rod.node(i).allFinite()) return false;
  }
  return ShapesFinite(bench) && DuctIn(bench).Outcome().load_W.allFinite();
}

double DuctOffRest(const OrganBench& bench) {
  const Rod& rod = DuctIn(bench).rod();
  const Rod& rest = DuctIn(bench).model().rod;
  double off = 0;
  for (int i = 0; i < rest.nodes(); ++i) off = std::max(off, (rod.node(i) - rest.node(i)).norm());
  return off;
}

// Jaws of a grasper or scissors across the duct at a height, `aside` (m) of where it is at rest.
ToolPose JawsAcross(double height, double jaw, double aside = 0) {
  ToolPose tool;
  tool.X_WT.linear() << 0, 0, 1, 1, 0, 0, 0, 1, 0;  // x_T = y, y_T = z, z_T = x
  tool.X_WT.translation() = Vector3d(-0.005 + aside, 0, height);
  tool.p_trocar_W = tool.X_WT * Vector3d(0, 0, 0.3);
  tool.jaw = jaw;
  return tool;
}

const char* const kDuctRest = ", failed from 50 %, or if 0.1 mm stay after the way back";

StressCase Pulled() {
  return PartCase("duct_pulled", "A duct of 30 mm pulled by an organ of 30 kPa that holds its end",
                  {"stretch", "", 0.1, 1, 5},
                  Format("load over the way, against that of a stretch of 0.1 %%, since duct and "
                         "tissue are linear: degraded from 10 %%%s",
                         kDuctRest),
                  [](double stretch) {
                    const auto stiffness = [](double share, OrganBench* bench) {
                      HungDuct duct;
                      duct.motion_W.z() = share * duct.length;
                      duct.Start(bench);
                      MovePart(0, 1, 10, bench);
                      MovePart(1, 1, 4, bench);
                      return DuctIn(*bench).Outcome().load_W.z() / duct.motion_W.z();
                    };
                    OrganBench little, much;
                    const double expected = stiffness(0.001, &little);
                    const double pulled = stiffness(stretch, &much);
                    const bool finite = DuctIsFinite(much);
                    MovePart(1, 0, 10, &much);
                    MovePart(0, 0, 10, &much);
                    return JudgePart(std::abs(pulled / expected - 1), finite, OffRest(much, 0));
                  });
}

// Returns the modulus k of the elastica whose ends are nearer by a share of its length, by
// bisection: the share is 2 (1 - E(k) / K(k)).
double ElasticaModulus(double share) {
  double low = 0, high = 1;
  for (int halving = 0; halving < 60; ++halving) {
    const double k = (low + high) / 2;
    const double at = 2 * (1 - std::comp_ellint_2(k) / std::comp_ellint_1(k));
    (at < share ? low : high) = k;
  }
  return low;
}

StressCase Buckled() {
  return PartCase(
      "duct_buckled", "A clamped duct of 60 mm with a bow of 0.3 mm pushed together",
      {"share of its length", "", 0.05, 0.4, 0.9},
      Format("force against the clamped elastica: degraded from 10 %%%s", kDuctRest),
      [](double share) {
        HungDuct duct{.rigid = true, .length = 0.06, .bow = 0.0003};
        duct.motion_W.z() = -share * duct.length;
        OrganBench bench;
        duct.Start(&bench);
        MovePart(0, 1, 60, &bench);
        MovePart(1, 1, 10, &bench);
        const double force = DuctIn(bench).Outcome().load_W.z();
        const double k = 2 * std::comp_ellint_1(ElasticaModulus(share)) / std::numbers::pi;
        const double euler =
            std::pow(2 * std::numbers::pi / duct.length, 2) * duct.Section().bending;
        const bool finite = DuctIsFinite(bench);
        MovePart(1, 0, 60, &bench);
        MovePart(0, 0, 10, &bench);
        return JudgePart(std::abs(force / (k * k * euler) - 1), finite, DuctOffRest(bench));
      });
}

StressCase CutUnderTension() {
  return PartCase(
      "duct_cut_tense", "A stretched duct cut in its middle", {"stretch", "", 0.1, 1, 5},
      "load that is left after the cut, over that before it: degraded from 10 %, failed from 50 %, "
      "if scissors do not cut it, or if 0.1 mm stay of the organ",
      [](double stretch) {
        HungDuct duct;
        duct.motion_W.z() = stretch * duct.length;
        ToolOptions scissors;
        scissors.geometries[0].action = ToolAction::kCut;
        OrganBench bench;
        duct.Start(&bench, {scissors});
        MovePart(0, 1, 10, &bench);
        const double before = DuctIn(bench).Outcome().load_W.norm();
        const Rod& rod = DuctIn(bench).rod();
        const double middle = rod.node(rod.nodes() / 2).z();
        bench.Step(JawsAcross(middle, 1));
        bench.Step(JawsAcross(middle, 0.05));
        MovePart(1, 1, 10, &bench);
        return JudgePart(DuctIn(bench).Outcome().load_W.norm() / before, DuctIsFinite(bench),
                         OffRest(bench, 0), DuctIn(bench).Outcome().cuts == 1 ? "" : "not cut");
      });
}

// Jaws take the duct in its middle, move aside by `way` (m) in some steps and wait. Returns the
// force on the node.
Vector3d Yank(double way, int steps, OrganBench* bench) {
  HungDuct duct;
  ToolOptions grasper;
  grasper.geometries[0].can_grasp = true;
  duct.Start(bench, {grasper});
  const double middle = duct.length / 2;
  bench->Step(JawsAcross(middle, 1));
  bench->Step(JawsAcross(middle, 0.05));
  for (int step = 1; step <= steps; ++step) {
    bench->Step(JawsAcross(middle, 0.05, way * step / steps));
  }
  for (int step = 0; step < 10; ++step) bench->Step(JawsAcross(middle, 0.05, way));
  const Rod& rod = DuctIn(*bench).rod();
  for (int i = 0; i < rod.nodes(); ++i) {
    if (rod.IsHeld(i)) return rod.HoldingForce(i);
  }
  return Vector3d::Zero();
}

StressCase Yanked() {
  return PartCase(
      "duct_yanked", "A duct of 30 mm held by jaws, yanked aside within a step, let go",
      {"way", "mm", 5, 40, 400},
      Format("force in the jaws against a way in 40 steps: degraded from 10 %%%s", kDuctRest),
      [](double way_mm) {
        OrganBench slow, fast;
        const Vector3d expected_W = Yank(way_mm / 1e3, 40, &slow);
        const Vector3d force_W = Yank(way_mm / 1e3, 1, &fast);
        const bool finite = DuctIsFinite(fast), held = expected_W.norm() > 0;
        fast.Step(JawsAcross(0.015, 1, way_mm / 1e3));
        for (int step = 0; step < 20; ++step) fast.Step();
        return JudgePart((force_W - expected_W).norm() / expected_W.norm(), finite,
                         std::max(DuctOffRest(fast), OffRest(fast, 0)), held ? "" : "not held");
      });
}

StressCase ShortDuct() {
  return PartCase(
      "duct_short", "A short clamped duct, bent and pulled by a micrometre",
      {"length over radius", "", 15, 5, 4.05},
      Format("load across and along it against Timoshenko's beam: degraded from 10 %%%s",
             kDuctRest),
      [](double slenderness) {
        HungDuct duct{.rigid = true};
        duct.length = slenderness * duct.radius;
        duct.motion_W = Vector3d(1e-6, 0, 1e-6);
        OrganBench bench;
        duct.Start(&bench);
        MovePart(0, 1, 2, &bench);
        const Vector3d load_W = DuctIn(bench).Outcome().load_W;
        const Vector3d expected_W = -1e-6 * Vector3d(duct.Across(), 0, duct.Along());
        const bool finite = DuctIsFinite(bench);
        MovePart(1, 0, 4, &bench);
        return JudgePart(std::max(std::abs(load_W.x() / expected_W.x() - 1),
                                  std::abs(load_W.z() / expected_W.z() - 1)),
                         finite, DuctOffRest(bench));
      });
}

StressCase PushedIntoTissue() {
  return PartCase("duct_in_soft_organ", "A stiff duct pushed into an organ of 3 kPa within a step",
                  {"way", "mm", 2, 8, 40},
                  Format("load against a push in 40 steps: degraded from 10 %%%s", kDuctRest),
                  [](double way_mm) {
                    const auto push = [&](int steps, OrganBench* bench) {
                      HungDuct duct{.young = 3e3, .wall_young = 5e6};
                      duct.motion_W = -way_mm / 1e3 * Vector3d(0.3, 0, 1);
                      duct.Start(bench);
                      MovePart(0, 1, steps, bench);
                      MovePart(1, 1, 10, bench);
                      return DuctIn(*bench).Outcome().load_W;
                    };
                    OrganBench slow, fast;
                    const Vector3d expected_W = push(40, &slow), load_W = push(1, &fast);
                    const bool finite = DuctIsFinite(fast);
                    MovePart(1, 0, 10, &fast);
                    MovePart(0, 0, 10, &fast);
                    return JudgePart((load_W - expected_W).norm() / expected_W.norm(), finite,
                                     std::max(DuctOffRest(fast), OffRest(fast, 0)));
                  });
}

}  // namespace

std::vector<StressCase> DuctStress(bool /*quick*/) {
  return {Pulled(), Buckled(), CutUnderTension(), Yanked(), ShortDuct(), PushedIntoTissue()};
}

}  // namespace hpdm
