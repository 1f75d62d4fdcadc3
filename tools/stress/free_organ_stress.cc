#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "tools/shared/report_text.h"
#include "tools/shared/simple_bodies.h"
#include "tools/stress/part_cases.h"

namespace hpdm {
namespace {

constexpr double kGravity = 9.81, kFreeDensity = 1060;  // m/s^2, kg/m^3
constexpr double kFreeGap = 0.0003;                     // m, between plate and block

OrganOptions HeavyPlate() {
  OrganOptions plate;
  plate.name = "plate";
  plate.model = OrganModelType::kRigid;
  plate.gravity_W = Vector3d(0, 0, -kGravity);
  return plate;
}

OrganOptions FreeBlock(double drag) {
  OrganOptions block;
  block.name = "block";
  block.material = {.young = 2e5, .poisson = 0.3};
  block.material.density = kFreeDensity;
  block.lattice.cells = {3, 3, 3};
  block.lattice.margin = 0.0005;
  block.lattice.local.functions = 0;
  block.gravity_W = Vector3d(0, 0, -kGravity);
  block.free = FreeOptions{drag};
  return block;
}

// Largest change of the distance between two vertices at the ends of a diagonal, over that at rest.
double StretchOfDiagonals(const OrganBench& bench, int organ) {
  const Points& rest = bench.model(organ).rest().vertices;
  const Points& now = bench.organ(organ).vertices;
  double worst = 0;
  for (int corner = 0; corner < 4; ++corner) {
    const Vector3d way((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1, 1);
    Eigen::Index first = 0, last = 0;
    (rest * way).minCoeff(&first);
    (rest * way).maxCoeff(&last);
    const double length = (rest.row(first) - rest.row(last)).norm();
    worst = std::max(worst, std::abs((now.row(first) - now.row(last)).norm() / length - 1));
  }
  return worst;
}

// Jaws from below at the block's lower face, turned about their shaft.
ToolPose TurnedFromBelow(double height, double jaw, double down, double angle) {
  ToolPose tool;
  tool.X_WT.translation() = Vector3d(0, 0, -0.0026 - height - down);
  tool.X_WT.linear() = (Eigen::AngleAxisd(angle, Vector3d::UnitZ()) *
                        Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX()))
                           .toRotationMatrix();
  tool.p_trocar_W = tool.X_WT.translation() - Vector3d(0, 0, 0.3);
  tool.jaw = jaw;
  return tool;
}

StressCase TornWhileTurned() {
  return PartCase(
      "free_torn_turned", "A block under a plate turned by jaws, then pulled off and held",
      {"angle", "deg", 5, 30, 120},
      "force in the jaws a second later against its weight, or the change of its diagonals, what "
      "is "
      "larger: degraded from 10 % or if a vertex jumps by 5 mm in the step that lets it go, failed "
      "from 50 %, or if it does not come off",
      [](double degrees) {
        const Vector3d sides(0.04, 0.03, 0.03);
        const double angle = degrees * std::numbers::pi / 180;
        OrganBench bench;
        bench.Add(HeavyPlate(),
                  GridBox(Vector3d(-0.06, -0.06, 0), Vector3d(0.06, 0.06, 0.01), {24, 24, 2}));
        const Vector3d low(-sides.x() / 2, -sides.y() / 2, -kFreeGap - sides.z());
        bench.Add(FreeBlock(1), GridBox(low, low + sides, {8, 6, 6}));
        bench.Attach(PartLayer("block", "plate"));
        ToolOptions grasper;
        grasper.geometries[0].can_grasp = true;
        bench.Start({grasper});
        double jump = 0;
        bool off = false;
        const auto step = [&](double jaw, double down, double turned) {
          const Points before = bench.organ(1).vertices;
          bench.Step(TurnedFromBelow(sides.z(), jaw, down, turned));
          const AttachmentLink& link = bench.loop().links()[0];
          if (off || !link.HasLetGo(ToSize(link.joint().MemberOf(1)))) return;
          off = true;
          jump = (bench.organ(1).vertices - before).rowwise().norm().maxCoeff();
        };
        for (int k = 0; k < 3; ++k) step(1, -0.0005, 0);
        for (int k = 0; k < 3; ++k) step(0.05, 0, 0);
        for (int k = 1; k <= 30; ++k) step(0.05, 0, angle * k / 30);
        for (int k = 1; k <= 50; ++k) step(0.05, 0.0005 * k, angle);
        for (int k = 0; k < 60; ++k) step(0.05, 0.025, angle);
        const double weight = kFreeDensity * sides.prod() * kGravity;
        const Vector3d weight_W(0, 0, weight);
        StressTrial trial = JudgePart(
            std::max((bench.ToolForce(1) - weight_W).norm() / weight, StretchOfDiagonals(bench, 1)),
            ShapesFinite(bench), 0, off ? "" : "not torn off");
        if (off && jump > 0.005) {
          trial.fate = std::max(trial.fate, StressFate::kDegraded);
          if (trial.how.empty()) trial.how = Format("jumps by %.2g mm", 1e3 * jump);
        }
        return trial;
      });
}

StressCase OnDucts() {
  return PartCase(
      "free_on_ducts", "A block of 19 g whose bed is burnt falls into two ducts of 30 mm",
      {"modulus of the ducts", "kPa", 300, 3000, 1e8, true},
      "tension of each duct ten seconds later against half the weight: degraded from 10 %, failed "
      "from 50 %, or if the bed does not burn",
      [](double young_kPa) {
        const Vector3d sides(0.03, 0.03, 0.02), low(kFreeGap, -0.015, -0.01);
        OrganBench bench;
        bench.Add(HeavyPlate(),
                  GridBox(Vector3d(-0.01, -0.04, -0.04), Vector3d(0, 0.04, 0.04), {2, 24, 24}));
        bench.Add(FreeBlock(3), GridBox(low, low + sides, {10, 10, 8}));
        bench.Attach(PartLayer("block", "plate"));
        for (const double y : {-0.008, 0.008}) {
          DuctOptions duct;
          duct.name = y < 0 ? "first" : "second";
          duct.a = "block";
          duct.path_W.resize(2, 3);
          duct.path_W << kFreeGap + 0.015, y, 0.01, kFreeGap + 0.015, y, 0.04;
          duct.radius = 0.002;
          duct.wall = 0.0008;
          duct.young = 1e3 * young_kPa;
          bench.Join(duct);
        }
        ToolOptions hook;
        constexpr double kThin = 1e-4;  // m: fits into the gap
        hook.geometries[0] = {
            .tip_radius = kThin, .shaft_radius = kThin, .action = ToolAction::kBurn, .power = 1e9};
        bench.Start({hook});
        const auto burn = [&](double y, double z) {
          ToolPose tool = OrganBench::Above(Vector3d(kFreeGap / 2, y, z));
          tool.pedal = true;
          bench.Step(tool);
        };
        for (double y = -0.0145; y < 0.015; y += 0.002) {
          for (double z = -0.0095; z < 0.01; z += 0.002) burn(y, z);
        }
        for (int k = 1; k <= 10; ++k) burn(0.0135, 0.0085 + 0.004 * k);
        for (int k = 0; k < 300; ++k) bench.Step();
        const AttachmentLink& link = bench.loop().links()[0];
        const double half = kFreeDensity * sides.prod() * kGravity / 2;
        double error = 0;
        for (const DuctState& duct : link.state().ducts()) {
          error = std::max(error, std::abs(duct.Outcome().tension / half - 1));
        }
        return JudgePart(error, ShapesFinite(bench), 0,
                         link.state().IsTorn(0) ? "" : "the bed is not burnt");
      });
}

StressCase Falling() {
  return PartCase(
      "free_falls", "A free block of 19 g falls flat on a rigid plate, with a drag of 1 /s",
      {"height", "mm", 10, 300, 5000, true},
      "the plate's force at rest against its weight, or the largest depth in the plate over its "
      "own "
      "height of 20 mm, what is larger: degraded from 10 %, failed from 50 %",
      [](double height_mm) {
        const double height = height_mm / 1e3;
        const Vector3d sides(0.03, 0.03, 0.02), low(-0.015, -0.015, height);
        OrganBench bench;
        bench.Add(HeavyPlate(),
                  GridBox(Vector3d(-0.06, -0.06, -0.02), Vector3d(0.06, 0.06, 0), {24, 24, 4}));
        bench.Add(FreeBlock(1), GridBox(low, low + sides, {10, 10, 8}), 0.2);
        bench.Start();
        // Without drag it takes so long.
        const int steps = 30 + static_cast<int>(60 * std::sqrt(2 * height / kGravity));
        double deepest = 0;
        for (int step = 0; step < steps; ++step) {
          bench.Step();
          if (bench.organ(1).vertices.col(2).minCoeff() > 0) continue;
          deepest = std::max(deepest, -bench.organ(1).vertices.col(2).minCoeff());
        }
        const double weight = kFreeDensity * sides.prod() * kGravity;
        const double error = std::abs(bench.PairForce(1).z() / weight - 1);
        return JudgePart(std::max(error, deepest / sides.z()), ShapesFinite(bench), 0,
                         deepest > 2 * sides.z() ? "falls through" : "");
      });
}

}  // namespace

std::vector<StressCase> FreeOrganStress() { return {TornWhileTurned(), OnDucts(), Falling()}; }

}  // namespace hpdm
