#include <algorithm>
#include <array>
#include <cmath>

#include "tools/shared/report_text.h"
#include "tools/shared/simple_bodies.h"
#include "tools/stress/part_cases.h"

namespace hpdm {
namespace {

constexpr double kPlateGap = 0.0003;  // m, between plate and block

// A rigid plate below z = 0 and a block on it, joined by a layer.
struct LayeredBlock {
  double young = 2e5;  // Pa
  double poisson = 0.3;
  Vector3d sides = Vector3d(0.03, 0.03, 0.01);  // m
  std::array<int, 3> cells = {3, 3, 2};
  bool held = true;                      // at its top
  Vector3d motion_W = Vector3d::Zero();  // m, of the block
  AttachmentOptions layer = PartLayer("block", "plate");

  double Area() const { return sides.x() * sides.y(); }
  double Toughness() const { return layer.toughness * Area(); }  // J
  void AddTo(OrganBench* bench) const {
    OrganOptions plate;
    plate.name = "plate";
    plate.model = OrganModelType::kRigid;
    bench->Add(plate, GridBox(Vector3d(-0.06, -0.06, -0.01), Vector3d(0.06, 0.06, 0), {24, 24, 2}));
    OrganOptions block;
    block.name = "block";
    block.material = {.young = young, .poisson = poisson};
    block.lattice.cells = cells;
    block.lattice.margin = 0.0005;
    block.lattice.local.functions = 0;
    block.motion = {motion_W, 0.5 / kPartHalf};
    if (held) {
      block.supports.push_back({Box{Vector3d(-1, -1, 0.8 * sides.z()), Vector3d(1, 1, 1)}, {}});
    }
    const Vector3d low(-sides.x() / 2, -sides.y() / 2, kPlateGap);
    bench->Add(block, GridBox(low, low + sides, {12, 12, 4}));
    bench->Attach(layer);
  }
};

const AttachmentOutcome& LayerOutcome(const OrganBench& bench) {
  return bench.loop().links()[0].outcomes()[0];
}

// The work that the block's motion does on the layer, J.
class WorkOfMotion {
 public:
  void Add(const OrganBench& bench) {
    const Vector3d now_W = bench.organ(1).offset_W, load_W = LayerOutcome(bench).load_W;
    work_ += 0.5 * (load_W_ + load_W).dot(now_W - offset_W_);
    offset_W_ = now_W;
    load_W_ = load_W;
  }
  double work() const { return work_; }

 private:
  double work_ = 0;
  Vector3d offset_W_ = Vector3d::Zero(), load_W_ = Vector3d::Zero();
};

// `block` moves by 15 mm.
StressCase TornFast(const char* name, const char* title, const LayeredBlock& block) {
  return PartCase(
      name, title, {"step", "mm", 0.05, 5, 15},
      "load of the damaged layer when held, against a pull in steps of 0.1 mm: degraded from 10 %, "
      "failed from 50 %, if a part of the layer stays whole after 15 mm, or if 0.1 mm stay after "
      "the way back",
      [block](double step_mm) {
        const auto pull = [&](double step, OrganBench* bench) {
          block.AddTo(bench);
          bench->Start();
          const int steps = std::max(1, Whole(0.005 / step));
          MovePart(0, 1. / 3, steps, bench);
          MovePart(1. / 3, 1. / 3, 10, bench);
          return LayerOutcome(*bench).load_W;
        };
        OrganBench slow, fast;
        const Vector3d expected_W = pull(1e-4, &slow), load_W = pull(step_mm / 1e3, &fast);
        MovePart(1. / 3, 1, std::max(1, Whole(10 / step_mm)), &fast);
        MovePart(1, 1, 10, &fast);
        const double area = fast.loop().links()[0].joint().layers()[0].bed.areas.sum();
        const bool whole = LayerOutcome(fast).freed_area < 0.99 * area;
        MovePart(1, 0, 10, &fast);
        return JudgePart((load_W - expected_W).norm() / expected_W.norm(), ShapesFinite(fast),
                         OffRest(fast, 1), whole ? "not torn" : "");
      });
}

// A block whose side hangs on a leaf that comes up from the plate.
LayeredBlock BlockOnLeaf() {
  LayeredBlock block{.motion_W = Vector3d(0.009, 0, 0.012)};
  block.layer.young = 1e5;
  block.layer.thickness = 0.0003;
  block.layer.strength = 3e4;
  block.layer.toughness = 150;
  block.layer.paths_W = {std::vector<Vector3d>{{-0.012, -0.015, 0.006}, {0.012, -0.015, 0.006}},
                         std::vector<Vector3d>{{-0.012, -0.017, 0}, {0.012, -0.017, 0}}};
  return block;
}

// A layer on soft tissue tears at once: what the tissue stores is more than its toughness.
StressCase SnapsOff() {
  return PartCase(
      "attachment_snaps", "A layer of 1 kPa, 0.2 J/m2 under a soft block that is pulled off",
      {"modulus of the block", "kPa", 100, 5, 0.5, true},
      "by how much the support's work is less than the layer's toughness times its area (more goes "
      "into the snap): degraded from 10 %, failed from 50 %, if a part stays whole, or if 0.1 mm "
      "stay after the way back",
      [](double young_kPa) {
        LayeredBlock block{.young = 1e3 * young_kPa};
        block.layer.strength = 1000;
        block.layer.toughness = 0.2;
        block.motion_W.z() =
            0.001 + 1.5 * block.layer.strength * block.sides.z() / block.young;  // m
        OrganBench bench;
        block.AddTo(&bench);
        bench.Start();
        WorkOfMotion work;
        for (int step = 1; step <= 100; ++step) {
          MovePart(0, step / 100., 1, &bench);
          work.Add(bench);
        }
        MovePart(1, 1, 10, &bench);
        const bool whole = LayerOutcome(bench).freed_area < 0.99 * block.Area();
        MovePart(1, 0, 10, &bench);
        return JudgePart(std::max(0.0, 1 - work.work() / block.Toughness()), ShapesFinite(bench),
                         OffRest(bench, 1), whole ? "not torn" : "");
      });
}

// Four hooks side by side in the gap, at three places along it.
StressCase BurntUnderLoad() {
  return PartCase(
      "attachment_burnt", "A loaded layer of 12 x 12 mm burnt by four hooks within 0.3 s",
      {"power of each", "W", 1e3, 1e5, 1e9, true},
      "area that is not free in the end, over the layer's: degraded from 10 %, failed from 50 %, "
      "if "
      "the layer still bears a load, or if 0.1 mm stay after the way back",
      [](double power) {
        LayeredBlock block{.sides = Vector3d(0.012, 0.012, 0.01),
                           .cells = {2, 2, 2},
                           .motion_W = Vector3d(0, 0, 0.0006)};  // near the layer's strength
        OrganBench bench;
        block.AddTo(&bench);
        constexpr double kThin = 1e-4;  // m: fits into the gap
        ToolOptions hook;
        hook.geometries[0] = {.tip_radius = kThin,
                              .shaft_radius = kThin,
                              .action = ToolAction::kBurn,
                              .power = power};
        bench.Start({hook, hook, hook, hook});
        MovePart(0, 1, 10, &bench);
        for (const double x : {-0.004, 0., 0.004}) {
          std::array<ToolPose, 4> hooks;
          for (std::size_t h = 0; h < hooks.size(); ++h) {
            const double y = -0.0045 + 0.003 * static_cast<double>(h);
            hooks[h].X_WT.translation() = Vector3d(x, y, kPlateGap / 2);
            hooks[h].p_trocar_W = Vector3d(x, y + 0.3, kPlateGap / 2);
            hooks[h].pedal = true;
          }
          for (int step = 0; step < 3; ++step) bench.Step(hooks);
        }
        MovePart(1, 1, 10, &bench);
        const AttachmentOutcome& layer = LayerOutcome(bench);
        const double left = std::max(0.0, 1 - layer.freed_area / block.Area());
        const bool bears = left < 0.01 && layer.load_W.norm() > 1e-9;
        MovePart(1, 0, 10, &bench);
        return JudgePart(left, ShapesFinite(bench), OffRest(bench, 1), bears ? "still bears" : "");
      });
}

// Pulls a block without Poisson's ratio by a third of the layer's strength. Returns way over load,
// m/N.
double PulledCompliance(double thickness, bool* finite, double* stays) {
  LayeredBlock block{.poisson = 0};
  block.layer.thickness = thickness;
  block.motion_W.z() = block.layer.strength / 3 *
                       (thickness / block.layer.young + 0.8 * block.sides.z() / block.young);
  OrganBench bench;
  block.AddTo(&bench);
  bench.Start();
  MovePart(0, 1, 4, &bench);
  const double compliance = block.motion_W.z() / std::abs(LayerOutcome(bench).load_W.z());
  *finite = ShapesFinite(bench);
  MovePart(1, 0, 4, &bench);
  *stays = OffRest(bench, 1);
  return compliance;
}

StressCase ThinLayer() {
  return PartCase(
      "attachment_thin", "A thin layer of 20 kPa under a block of 200 kPa, pulled",
      {"thickness", "um", 1000, 1, 1e-6, true},
      "compliance against that of layer and block in series, the block's from a layer of 1 mm: "
      "degraded from 10 %, failed from 50 %, or if 0.1 mm stay",
      [](double thickness_um) {
        const LayeredBlock block;
        const auto of_layer = [&](double thickness) {
          return thickness / (block.layer.young * block.Area());
        };
        bool finite = true;
        double stays = 0;
        const double alone = PulledCompliance(0.001, &finite, &stays) - of_layer(0.001);
        const double thickness = thickness_um / 1e6;
        const double compliance = PulledCompliance(thickness, &finite, &stays);
        const double expected = alone + of_layer(thickness);
        return JudgePart(std::abs(compliance / expected - 1), finite, stays);
      });
}

StressCase WeakLayer() {
  return PartCase(
      "attachment_weak", "A weak layer that opens by 2 mm, pulled off by 4 mm",
      {"strength", "Pa", 1e4, 1, 1e-4, true},
      "the support's work against the toughness times the area: degraded from 10 %, failed from 50 "
      "%, or if 0.1 mm stay after the way back",
      [](double strength) {
        LayeredBlock block{.motion_W = Vector3d(0.002, 0, 0.0035)};
        block.layer.strength = strength;
        block.layer.toughness = 0.001 * strength;
        OrganBench bench;
        block.AddTo(&bench);
        bench.Start();
        WorkOfMotion work;
        for (int step = 1; step <= 120; ++step) {
          MovePart(0, step / 120., 1, &bench);
          work.Add(bench);
        }
        const bool whole = LayerOutcome(bench).freed_area < 0.99 * block.Area();
        MovePart(1, 0, 10, &bench);
        return JudgePart(std::abs(work.work() / block.Toughness() - 1), ShapesFinite(bench),
                         OffRest(bench, 1), whole ? "not torn" : "");
      });
}

// A plate peeled by jaws at its end.
StressCase CoarseLattice(bool quick) {
  return PartCase(
      "attachment_coarse", "A plate of 60 x 20 x 4 mm peeled off by its end, cells along it",
      {"cells", "", 10, 4, 1},
      "the jaws' work, without what the plate stores, when the layer is free, against the "
      "toughness "
      "times the area: degraded from 10 %, failed from 50 %, or if a part of the layer stays whole",
      [quick](double cells) {
        LayeredBlock plate{.young = 6e5,
                           .sides = Vector3d(0.06, 0.02, 0.004),
                           .cells = {Whole(cells), 2, 2},
                           .held = false};
        OrganBench bench;
        plate.AddTo(&bench);
        ToolOptions grasper;
        grasper.geometries[0].can_grasp = true;
        bench.Start({grasper});
        const Vector3d start(-0.025, 0, kPlateGap + plate.sides.z() + 0.0023);
        const int steps = quick ? 300 : 600;
        double work = 0, last = 0, height = 0;
        const auto is_whole = [&] { return LayerOutcome(bench).freed_area < 0.999 * plate.Area(); };
        for (int step = 0; step <= steps && is_whole(); ++step) {
          const double lift = 0.15 * std::max(0, step - 2) / steps;
          ToolPose tool = OrganBench::Above(start + Vector3d(0, 0, lift));
          tool.jaw = step < 2 ? 1 : 0.05;
          bench.Step(tool);
          const double force = bench.ToolForce(1).z();
          if (step >= 2) work += 0.5 * (force + last) * (lift - height);
          last = force;
          height = lift;
        }
        const Points& U = bench.organ(1).control_displacements;
        const Eigen::Map<const Eigen::VectorXd> u(U.data(), U.size());
        const double stored = 0.5 * u.dot(std::get<FullStiffness>(bench.model(1).stiffness()) * u);
        return JudgePart(std::abs((work - stored) / plate.Toughness() - 1), ShapesFinite(bench), 0,
                         is_whole() ? "not torn" : "");
      });
}

}  // namespace

std::vector<StressCase> AttachmentStress(bool quick) {
  const Vector3d aslant_W(0.009, 0, 0.012);  // 15 mm
  return {TornFast("attachment_torn_fast",
                   "A layer pulled aslant by 5 mm in steps, held, then torn off",
                   LayeredBlock{.motion_W = aslant_W}),
          TornFast("leaf_torn_fast", "A leaf pulled aslant by 5 mm in steps, held, then torn off",
                   BlockOnLeaf()),
          SnapsOff(),
          BurntUnderLoad(),
          ThinLayer(),
          WeakLayer(),
          CoarseLattice(quick)};
}

}  // namespace hpdm
