#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/statics/static_loads.h"
#include "engine/tissue/lumen.h"
#include "tools/shared/report_text.h"
#include "tools/shared/simple_bodies.h"
#include "tools/stress/part_cases.h"

namespace hpdm {
namespace {

constexpr double kBarYoung = 5000, kBarTo = 0.2, kBarHalf = 0.01;  // Pa, m

// A bar of 20 x 20 mm along x whose part below x = 0 is held, in a layer of `stiffness` (N/m; 0:
// none). Returns the strain of its middle under 0.02 N.
double StretchOfBar(double stiffness, double* residual) {
  OrganOptions options;
  options.name = "bar";
  options.material = {.young = kBarYoung, .poisson = 0.3};
  options.lattice.cells = {24, 2, 2};
  options.lattice.margin = 0.001;
  options.lattice.local.functions = 0;
  options.supports = {{Box{Vector3d(-1, -1, -1), Vector3d(0, 1, 1)}, {}}};
  if (stiffness > 0) {
    options.layers = {{.region = Box{Vector3d(-1, -1, -1), Vector3d(kBarTo - 1e-4, 1, 1)},
                       .stiffness = stiffness,
                       .poisson = 0.3,
                       .strength = {}}};
  }
  const OrganModel bar(options, GridBox(Vector3d(-0.04, -kBarHalf, -kBarHalf),
                                        Vector3d(kBarTo, kBarHalf, kBarHalf), {48, 6, 6}));
  LoadOptions load;
  load.organ = options.name;
  load.p_centre_W = Vector3d(kBarTo, 0, 0);
  load.radius = 0.012;
  load.force_W = Vector3d(0.02, 0, 0);
  const StaticLoads statics(bar, {load});
  const StaticSolution solution = statics.Solve();
  *residual = statics.Residual(solution);
  const auto mean_at = [&](double x) {
    double sum = 0, count = 0;
    for (Eigen::Index v = 0; v < bar.rest().vertices.rows(); ++v) {
      if (std::abs(bar.rest().vertices(v, 0) - x) > 1e-9) continue;
      sum += solution.vertex_displacements(v, 0);
      count += 1;
    }
    return sum / count;
  };
  return (mean_at(0.125) - mean_at(0.035)) / 0.09;
}

StressCase StiffLayer() {
  return PartCase(
      "layer_stiff", "A bar of 5 kPa in a stiff layer, pulled",
      {"layer's stiffness over the bar's", "", 1, 1e3, 1e9, true},
      "stretch against bar and layer side by side: degraded from 10 %, failed from 50 %, "
      "or if the residual exceeds 0.1 % of the load",
      [](double ratio) {
        const double bar = kBarYoung * std::pow(2 * kBarHalf, 2);
        const double layer = ratio * bar / (8 * kBarHalf);
        double residual = 0;
        const double stretch = StretchOfBar(layer, &residual);
        const double expected = 0.02 / (bar * (1 + ratio));
        StressTrial trial = JudgePart(std::abs(stretch / expected - 1), std::isfinite(stretch), 0);
        if (!(residual < 1e-3)) {
          trial.fate = StressFate::kFailed;
          trial.how = Format("residual %.2g", residual);
        }
        return trial;
      });
}

// A hollow ball with fluid and a layer, held below. A probe presses its top.
struct FilledBall {
  double bulk_modulus = 2.2e9;  // Pa
  double strength = 1;          // N/m, of the layer
  bool quick = false;
  static constexpr double kOuter = 0.03, kWall = 0.004;  // m

  void Start(OrganBench* bench, double tip_radius, bool can_grasp) const {
    OrganOptions ball;
    ball.name = "ball";
    ball.material = {.young = 2e4, .poisson = 0.45};
    ball.lattice.cells = {8, 8, 8};
    if (quick) ball.lattice.cells = {6, 6, 6};
    ball.lattice.margin = 0.0005;
    ball.lattice.local.functions = 0;
    ball.supports.push_back({BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.15)}, {}});
    ball.lumens.emplace_back().bulk_modulus = bulk_modulus;
    ball.layers = {{.region = {}, .stiffness = 30, .poisson = 0.45, .strength = strength}};
    const SurfaceMesh outer = Ellipsoid(Vector3d::Constant(kOuter), 3);
    const SurfaceMesh inner = Ellipsoid(Vector3d::Constant(kOuter - kWall), 3);
    SurfaceMesh both = outer;
    both.vertices.conservativeResize(2 * outer.vertices.rows(), 3);
    both.vertices.bottomRows(outer.vertices.rows()) = inner.vertices;
    Triangles turned = inner.triangles.array() + static_cast<int>(outer.vertices.rows());
    turned.col(1).swap(turned.col(2));
    both.triangles.conservativeResize(2 * outer.triangles.rows(), 3);
    both.triangles.bottomRows(outer.triangles.rows()) = turned;
    bench->Add(ball, both);
    ToolOptions tool;
    tool.geometries[0].tip_radius = tip_radius;
    tool.geometries[0].can_grasp = can_grasp;
    bench->Start({tool});
  }
};

// m^3: of the ball's cavity as it is now.
double CavityVolume(const OrganBench& bench) {
  const SurfaceMesh& rest = bench.model(0).rest();
  const Points& now = bench.organ(0).vertices;
  double volume = 0;
  for (Eigen::Index t = rest.triangles.rows() / 2; t < rest.triangles.rows(); ++t) {
    const Vector3d a = now.row(rest.triangles(t, 0)), b = now.row(rest.triangles(t, 1)),
                   c = now.row(rest.triangles(t, 2));
    volume -= a.dot(b.cross(c)) / 6;
  }
  return volume;
}

constexpr double kPressingTip = 0.008;  // m

// Presses the ball's top by a depth (m) in `steps` steps.
void PressFilledBall(double depth, int steps, OrganBench* bench) {
  const double top = FilledBall::kOuter + kPressingTip;
  for (int step = 0; step <= steps; ++step) {
    bench->Step(OrganBench::Above(Vector3d(0, 0, top - depth * step / steps)));
  }
}

StressCase PressedLumen(bool quick) {
  return PartCase(
      "lumen_pressed", "A filled ball of 60 mm with walls of 4 mm pressed by a tip of 8 mm",
      {"depth", "mm", 2, 10, 40},
      "change of the drawn cavity's volume over that at rest, since the filling keeps it "
      "to first order: degraded from 10 %, failed from 50 %, or if 0.1 mm stay",
      [quick](double depth_mm) {
        OrganBench bench;
        FilledBall{.quick = quick}.Start(&bench, kPressingTip, false);
        const double rest = CavityVolume(bench);
        PressFilledBall(depth_mm / 1e3, 20, &bench);
        const double pressed = CavityVolume(bench);
        const bool finite = ShapesFinite(bench);
        for (int step = 0; step < 30; ++step) bench.Step();
        return JudgePart(std::abs(pressed / rest - 1), finite, OffRest(bench, 0));
      });
}

StressCase StiffFilling(bool quick) {
  return PartCase("lumen_stiff", "The same ball pressed by 3 mm, fluids that hardly yield",
                  {"bulk modulus", "Pa", 1e7, 2.2e9, 1e12, true},
                  "force on the tip against that with 1e7 Pa, which hardly yields either: degraded "
                  "from 10 %, failed from 50 %, or if 0.1 mm stay",
                  [quick](double bulk_modulus) {
                    const auto force = [&](double modulus, OrganBench* bench) {
                      FilledBall{.bulk_modulus = modulus, .quick = quick}.Start(bench, kPressingTip,
                                                                                false);
                      PressFilledBall(0.003, 5, bench);
                      return bench->ToolForce(0).z();
                    };
                    OrganBench soft, stiff;
                    const double expected = force(1e7, &soft), felt = force(bulk_modulus, &stiff);
                    const bool finite = ShapesFinite(stiff);
                    for (int step = 0; step < 30; ++step) stiff.Step();
                    return JudgePart(std::abs(felt / expected - 1), finite, OffRest(stiff, 0));
                  });
}

// A layer cannot be damaged. Beyond its strength it stays as stiff, and only its tension shows that.
StressCase OverloadedLayer(bool quick) {
  return PartCase("layer_overloaded",
                  "The layer of a filled ball pulled by jaws beyond its strength of 1 N/m",
                  {"way", "mm", 1, 10, 60},
                  "tension over the way, against that of 0.5 mm, since the layer is linear: "
                  "degraded from 10 %, "
                  "failed from 50 %, or if 0.1 mm stay",
                  [quick](double way_mm) {
                    const auto tension = [&](double way, OrganBench* bench) {
                      FilledBall{.quick = quick}.Start(bench, kDefaultToolRadius, true);
                      const Vector3d start(0, 0, FilledBall::kOuter + 0.0023);
                      ToolPose tool = OrganBench::Above(start);
                      bench->Step(tool);
                      tool.jaw = 0.05;
                      bench->Step(tool);
                      tool = OrganBench::Above(start + Vector3d(0, 0, way));
                      tool.jaw = 0.05;
                      for (int step = 0; step < 5; ++step) bench->Step(tool);
                      return bench->loop().sample().layer_tensions[0];
                    };
                    OrganBench little, much;
                    const double expected = tension(0.0005, &little) / 0.0005;
                    const double pulled = tension(way_mm / 1e3, &much) / (way_mm / 1e3);
                    const bool finite = ShapesFinite(much) && std::isfinite(pulled);
                    for (int step = 0; step < 30; ++step) much.Step();
                    return JudgePart(std::abs(pulled / expected - 1), finite, OffRest(much, 0));
                  });
}

}  // namespace

std::vector<StressCase> LayerAndLumenStress(bool quick) {
  return {StiffLayer(), OverloadedLayer(quick), PressedLumen(quick), StiffFilling(quick)};
}

}  // namespace hpdm
