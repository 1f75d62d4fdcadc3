#include "tools/haptics/contact_trials.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "tools/shared/edge_wedge.h"
#include "tools/shared/simple_bodies.h"

namespace hpdm {
namespace {

constexpr double kTrialPeriod = 0.001;  // s
constexpr double kNoForceYet = std::numeric_limits<double>::infinity();

OrganOptions HeldBelow(const std::string& name, int cells, double held) {
  OrganOptions options;
  options.name = name;
  options.energy.type = EnergyType::kStrain;
  options.lattice.cells = {cells, cells, cells};
  options.lattice.local.functions = 0;
  options.supports.push_back({BoxFraction{Vector3d::Zero(), Vector3d(1, 1, held)}, {}});
  return options;
}

double PlaneModulus(const MaterialOptions& material) {
  return material.young / (1 - material.poisson * material.poisson);
}

double DegreesApart(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::numbers::pi;
}

// Returns the distance (m) of a point above the ellipsoid, along the vertical.
double AboveEllipsoid(const Vector3d& p) {
  const double x = p.x() / kEllipsoidAxes.x(), y = p.y() / kEllipsoidAxes.y();
  return p.z() - kEllipsoidAxes.z() * std::sqrt(std::max(1 - x * x - y * y, 0.0));
}

}  // namespace

ToolOptions BallTip(double radius) {
  ToolOptions tool;
  tool.geometries[0].tip_radius = radius;
  return tool;
}

OrganOptions WideBlock::Options() const {
  OrganOptions options = HeldBelow("block", cells, 0.1);
  options.material.poisson = poisson;
  options.lattice.local.functions = local_functions;
  return options;
}

SurfaceMesh WideBlock::Rest() const {
  return GridBox(Vector3d(-0.1, -0.1, -0.2), Vector3d(0.1, 0.1, 0), {squares, squares, squares});
}

double HertzForce(double depth, double radius, const MaterialOptions& material) {
  return 4.0 / 3 * PlaneModulus(material) * std::sqrt(radius) * std::pow(depth, 1.5);
}

double SneddonForce(double depth, double radius, const MaterialOptions& material) {
  double low = 0, high = 0.9999;  // radius of the contact over the ball's
  for (int i = 0; i < 60; ++i) {
    const double b = (low + high) / 2;
    (radius * b * std::atanh(b) < depth ? low : high) = b;
  }
  return PlaneModulus(material) * radius * radius * ((low * low + 1) * std::atanh(low) - low);
}

std::vector<BallPress> PressBall(const WideBlock& block, double radius,
                                 const std::vector<double>& depths) {
  FeltBench bench(block.Options(), block.Rest(), BallTip(radius));
  const Vector3d touch(0.0113, 0.0071, radius);
  const ToolPose above = FeltBench::At(touch + Vector3d(0, 0, 1e-4));
  std::vector<BallPress> presses;
  for (const double depth : depths) {
    const ToolPose pressed = FeltBench::At(touch - Vector3d(0, 0, depth));
    BallPress press{.depth = depth};
    bench.Step(above);
    bench.Tick(above);
    bench.Tick(pressed);
    press.first_tick = bench.Hand().z();
    bench.Step(pressed);
    bench.Settle(pressed);  // the normal turns with the surface beside the block's axis
    press.step = -bench.Patch().force_on_tissue_W.z();
    press.settled_tick = bench.Hand().z();
    presses.push_back(press);
  }
  return presses;
}

OrganOptions SlabOptions() {
  OrganOptions options = HeldBelow("slab", 5, 0.15);
  options.lattice.local.functions = 27;
  return options;
}

SurfaceMesh Slab(int squares) {
  return GridBox(Vector3d(-0.1, -0.1, -0.06), Vector3d(0.1, 0.1, 0), {squares, squares, squares});
}

SlideTurn TurnOfSlide(double tip_radius, int squares) {
  constexpr int kTicksAStep = 33;
  FeltBench bench(SlabOptions(), Slab(squares), BallTip(tip_radius));
  Vector3d p(-0.03, 0.011, tip_radius + 0.003);
  int ticks = 0;
  for (; p.z() > tip_radius - 0.01; p.z() -= 1e-4, ++ticks) bench.SessionTick(FeltBench::At(p));
  SlideTurn turn{.least_force = kNoForceYet};
  Vector3d last = bench.Hand(), last_normal = bench.Felt().normal_W;
  for (int i = 0; i < 400; ++i, ++ticks) {
    const bool new_patch = ticks % kTicksAStep == 0;
    if (!new_patch) p += Vector3d(5e-5, 1.9e-5, 0);
    bench.SessionTick(FeltBench::At(p));
    const Vector3d force = bench.Hand(), normal = bench.Felt().normal_W;
    if (new_patch) {
      turn.force = std::max(turn.force, DegreesApart(last, force));
      turn.normal = std::max(turn.normal, DegreesApart(last_normal, normal));
    }
    last = force;
    last_normal = normal;
    turn.least_force = std::min(turn.least_force, last.norm());
  }
  return turn;
}

StillHandTrial SpeedOfStillHand(double tip_radius, int squares) {
  constexpr double kStiffness = 300, kDamping = 6.5, kMass = 0.15;
  constexpr int kPlaces = 8, kTicks = 1200, kJudged = 500;
  FeltBench bench(SlabOptions(), Slab(squares), BallTip(tip_radius));
  StillHandTrial hand{.least_force = kNoForceYet};
  for (int place = 0; place < kPlaces; ++place) {
    Vector3d p(-0.05 + 0.0123 * place, 0.02 - 0.0077 * place, tip_radius + 0.003);
    for (; p.z() > tip_radius - 0.02; p.z() -= 2e-4) bench.SessionTick(FeltBench::At(p));
    for (int i = 0; i < 100; ++i) bench.SessionTick(FeltBench::At(p));
    const Vector3d wanted = p - bench.Hand() / kStiffness;
    Vector3d v = Vector3d::Zero();
    double sum = 0;
    for (int i = 0; i < kTicks; ++i) {
      bench.SessionTick(FeltBench::At(p));
      v += (bench.Hand() + kStiffness * (wanted - p) - kDamping * v) / kMass * kTrialPeriod;
      p += v * kTrialPeriod;
      if (i >= kTicks - kJudged) sum += v.squaredNorm() / kJudged;
    }
    hand.rms_speed = std::max(hand.rms_speed, std::sqrt(sum));
    hand.least_force = std::min(hand.least_force, bench.Hand().norm());
    for (int i = 0; i < 100; ++i) bench.SessionTick(FeltBench::Away());
  }
  return hand;
}

OrganOptions EllipsoidOptions() { return HeldBelow("ellipsoid", 4, 0.25); }

Approach ComeDown(int splits, double speed) {
  constexpr double kInside = 0.0015;  // m
  FeltBench bench(EllipsoidOptions(), Ellipsoid(kEllipsoidAxes, splits));
  const Vector3d start(-0.04, 0.005, 0.075), way = Vector3d(1, 0, -1).normalized();
  for (int i = 0; i < 200; ++i) bench.SessionTick(FeltBench::At(start));
  Approach approach;
  for (double along = 0; along < 0.08 && !approach.felt; along += kTrialPeriod * speed) {
    ToolPose tool = FeltBench::At(start + along * way);
    tool.v_tip_W = speed * way;
    bench.SessionTick(tool);
    approach.felt = bench.Hand().norm() > 0;
    const double inside = kDefaultToolRadius - AboveEllipsoid(tool.X_WT.translation());
    if (approach.felt) break;
    approach.deepest = std::max(approach.deepest, inside);
    if (inside >= kInside) ++approach.ticks_late;
  }
  return approach;
}

OrganSlide SlideOverOrgans(int organs, double speed) {
  const Vector3d axes(0.05, 0.05, 0.02);
  std::vector<OrganModel> models;
  for (int i = 0; i < organs; ++i) {
    Isometry3d X_WO = Isometry3d::Identity();
    X_WO.translation().x() = -0.02 + 0.04 * i;
    models.emplace_back(EllipsoidOptions(), Ellipsoid(axes, 4, X_WO));
  }
  FeltBench bench(std::move(models));
  const double z = axes.z() + kDefaultToolRadius - 0.003;
  for (double up = 0.005; up > 0; up -= 1e-4) {
    bench.SessionTick(FeltBench::At(Vector3d(-0.02, 0, z + up)));
  }
  for (int i = 0; i < 200; ++i) bench.SessionTick(FeltBench::At(Vector3d(-0.02, 0, z)));
  Vector3d last = bench.Hand();
  OrganSlide slide{.least_force = kNoForceYet, .stiffness = last.z() / 0.003};
  for (double x = -0.02; x < 0.02; x += kTrialPeriod * speed) {
    bench.SessionTick(FeltBench::At(Vector3d(x, 0, z)));
    const Vector3d force = bench.Hand();
    if (force.norm() == 0) ++slide.ticks_without_force;
    slide.least_force = std::min(slide.least_force, force.z());
    slide.largest_step = std::max(slide.largest_step, (force - last).norm());
    last = force;
  }
  return slide;
}

EdgeStiffness PullEdge(double edge, int cells, int functions) {
  constexpr double kPull = 0.001;  // m
  ToolOptions grasper;
  grasper.geometries[0].can_grasp = true;
  FeltBench bench(EdgeWedge::Options(cells, functions), EdgeWedge::Surface(edge), grasper);
  bench.Step(FeltBench::Away());
  const auto pull = [&](const Vector3d& way) {
    const ToolPose tool = FeltBench::At(way, 0);
    bench.Tick(tool);
    bench.Step(tool);
    bench.Settle(tool);
    return Vector3d(-bench.Hand() / kPull);
  };
  bench.Step(FeltBench::At(Vector3d::Zero(), 0));
  bench.Settle(FeltBench::At(Vector3d::Zero(), 0));
  EdgeStiffness stiffness;
  stiffness.along = pull(kPull * Vector3d::UnitY()).y();
  stiffness.off = pull(kPull * Vector3d::UnitZ()).z();
  stiffness.across = pull(kPull * Vector3d::UnitX()).x();
  stiffness.holds = bench.Felt().kind == ContactKind::kGrasp;
  return stiffness;
}

}  // namespace hpdm
