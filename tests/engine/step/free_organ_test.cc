#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "engine/energy/finite_strain_energy.h"
#include "engine/tissue/interior.h"
#include "tools/shared/edge_wedge.h"
#include "tools/shared/organ_bench.h"
#include "tools/shared/simple_bodies.h"

namespace hpdm {
namespace {

constexpr double kG = 9.81;
const Vector3d kSides(0.08, 0.06, 0.04);  // m

OrganOptions FreeOptionsOf(double drag, const Vector3d& gravity_W) {
  OrganOptions options;
  options.name = "free";
  options.lattice.cells = {3, 3, 3};
  options.lattice.margin = 0.001;
  options.lattice.local.functions = 0;
  options.material.young = 5000;
  options.free = FreeOptions{drag};
  options.gravity_W = gravity_W;
  return options;
}

SurfaceMesh Block(double bottom) {
  const Vector3d low(-kSides.x() / 2, -kSides.y() / 2, bottom);
  return GridBox(low, low + kSides, {8, 6, 4});
}

void AddFloor(OrganBench* bench) {
  OrganOptions floor;
  floor.name = "floor";
  floor.model = OrganModelType::kRigid;
  bench->Add(floor, GridBox(Vector3d(-0.2, -0.2, -0.05), Vector3d(0.2, 0.2, 0), {16, 16, 4}));
}

Vector3d Centre(const OrganBench& bench, int o) {
  return bench.organ(o).vertices.colwise().mean().transpose();
}

Vector3d MassCentre(const OrganBench& bench, int o) {
  const FreeBody& body = *bench.model(o).free_body();
  const Points U = bench.organ(o).control_displacements.topRows(body.masses.size());
  return body.p_centre_W + U.transpose() * body.masses / body.mass;
}

// Starts with a stiff block without weight, and a tip 1 mm above its top, `x` beside its centre. Returns the
// tip's height (m) where it touches.
double StartUnderATip(double x, OrganBench* bench) {
  OrganOptions options = FreeOptionsOf(0, Vector3d::Zero());
  options.material.young = 1e9;
  bench->Add(options, Block(0));
  bench->Start();
  const double touching = kSides.z() + ToolGeometry{}.tip_radius;
  bench->Step(OrganBench::Above(Vector3d(x, 0, touching + 0.001)));
  return touching;
}

double ClosedFormFall(double drag, double t) {
  return drag > 0 ? kG / drag * (t + std::expm1(-drag * t) / drag) : kG * t * t / 2;
}

TEST(FreeOrgan, FallsAsABodyWithDrag) {
  for (const double drag : {0.0, 0.5, 4.0}) {
    OrganBench bench;
    bench.Add(FreeOptionsOf(drag, Vector3d(0, 0, -kG)), Block(0));
    bench.Start();
    for (int k = 1; k <= 30; ++k) {
      bench.Step();
      const double fallen = ClosedFormFall(drag, k / 30.0);
      EXPECT_NEAR((kSides.z() / 2 - Centre(bench, 0).z()) / fallen, 1, 1e-6) << drag << ' ' << k;
    }
  }
}

double BodyEnergy(const OrganBench& bench, int o) {
  return bench.organ(o).relaxation->BodyEnergy(bench.organ(o).control_displacements);
}

// The mass is that of the mesh's volume; the model's differs by 3e-5. Speed and height are closed forms.
TEST(FreeOrgan, ItsEnergyIsThatOfItsMotionAndWeight) {
  for (const double drag : {0.0, 0.5, 4.0}) {
    OrganBench bench;
    bench.Add(FreeOptionsOf(drag, Vector3d(0, 0, -kG)), Block(0));
    bench.Start();
    const double mass = 1060 * kSides.prod();
    for (int k = 1; k <= 30; ++k) {
      bench.Step();
      const double t = k / 30.0, fallen = ClosedFormFall(drag, t);
      const double v = drag > 0 ? -kG / drag * std::expm1(-drag * t) : kG * t;
      EXPECT_NEAR(BodyEnergy(bench, 0), mass * (v * v / 2 - kG * fallen), 1e-4 * mass * kG * fallen)
          << drag << ' ' << k;
    }
  }
}

// A blow beside its centre turns a stiff block about y. The speed of its vertices gives its energy.
TEST(FreeOrgan, ItsEnergyHasThatOfItsTurning) {
  OrganBench bench;
  const double touching = StartUnderATip(0.03, &bench);
  bench.Step(OrganBench::Above(Vector3d(0.03, 0, touching - 0.001)));
  bench.Step();
  const Matrix3d R = bench.organ(0).relaxation->Rotation();
  const double energy = BodyEnergy(bench, 0), z = MassCentre(bench, 0).z();
  bench.Step();
  const Eigen::AngleAxisd turn(bench.organ(0).relaxation->Rotation() * R.transpose());
  const double rate = 30 * turn.angle(), v = 30 * (MassCentre(bench, 0).z() - z);
  const double mass = 1060 * kSides.prod();
  const double inertia = mass / 12 * (kSides.x() * kSides.x() + kSides.z() * kSides.z());
  const double turning = inertia * rate * rate / 2;
  EXPECT_GT(turning, 0.2 * energy);
  EXPECT_NEAR((turning + mass * v * v / 2) / energy, 1, 0.01);
}

// Weight by the mesh's volume, not by the model's mass. The block comes down by 36 mm a step.
TEST(FreeOrgan, AFloorStopsItWithoutABounceAndHoldsItByItsWeight) {
  for (const double friction : {0.0, 0.1}) {
    OrganBench bench;
    AddFloor(&bench);
    bench.Add(FreeOptionsOf(1, Vector3d(0, 0, -kG)), Block(0.1), friction);
    bench.Start();
    double lowest = 1, highest = 0;
    for (int k = 0; k < 40; ++k) {
      bench.Step();
      lowest = std::min(lowest, bench.organ(1).vertices.col(2).minCoeff());
      if (lowest < 1e-3) highest = std::max(highest, bench.organ(1).vertices.col(2).minCoeff());
    }
    const double weight = 1060 * kSides.prod() * kG;
    EXPECT_NEAR(bench.PairForce(1).z() / weight, 1, 0.005) << friction;
    EXPECT_LT(bench.PairForce(1).head<2>().norm(), 0.005 * weight);
    EXPECT_GT(lowest, -1e-4);
    EXPECT_LT(highest, 1e-4);
    const Vector3d before = MassCentre(bench, 1);
    for (int k = 0; k < 15; ++k) bench.Step();
    EXPECT_LT((MassCentre(bench, 1) - before).norm(), 2e-5);  // m in half a second
  }
}

// Newton's second law: the tool's impulse is the organ's momentum.
TEST(FreeOrgan, ATipGivesItItsImpulse) {
  for (const double x : {0.0, 0.02}) {
    OrganBench bench;
    bench.Add(FreeOptionsOf(0, Vector3d::Zero()), Block(0));
    bench.Start();
    const auto at = [&](double z) { return OrganBench::Above(Vector3d(x, 0.005, z)); };
    const double touching = kSides.z() + ToolGeometry{}.tip_radius;
    bench.Step(at(touching + 0.001));
    Vector3d impulse = Vector3d::Zero();
    for (const double depth : {0.001, 0.004, 0.008}) {
      bench.Step(at(touching - depth));
      impulse += bench.ToolForce(0) / 30;
    }
    EXPECT_LT(impulse.z(), -1e-3);
    bench.Step();
    const Vector3d first = Centre(bench, 0);
    bench.Step();
    const Vector3d momentum = 1060 * kSides.prod() * 30 * (Centre(bench, 0) - first);
    EXPECT_NEAR(momentum.z() / impulse.z(), 1, 0.03) << x;  // the vertices' mean turns, too
  }
}

// Each step moves the whole rigid part of the displacements to the frame.
TEST(FreeOrgan, AStiffBlockUnderATipMovesAsItsFrame) {
  OrganBench bench;
  const double touching = StartUnderATip(0.03, &bench);
  for (const double depth : {0.001, 0.004}) {
    bench.Step(OrganBench::Above(Vector3d(0.03, 0, touching - depth)));
    ASSERT_LT(bench.ToolForce(0).z(), 0);
    const Matrix3d R = bench.organ(0).relaxation->Rotation();
    EXPECT_GT(Eigen::AngleAxisd(R).angle(), 0.01);
    const Points arms = bench.model(0).rest().vertices.rowwise() -
                        bench.model(0).free_body()->p_centre_W.transpose();
    const Points placed = (arms * R.transpose()).rowwise() + MassCentre(bench, 0).transpose();
    EXPECT_LT((bench.organ(0).vertices - placed).rowwise().norm().maxCoeff(), 1e-5);  // m
  }
}

// An eccentric blow turns the block. When it has turned by 90 degrees the gradient of an energy that
// is blind to rotations, and no part of the model, finds no force in its displacements.
TEST(FreeOrgan, TurnedBy90DegreesItHasNoForces) {
  OrganBench bench;
  OrganOptions options = FreeOptionsOf(0, Vector3d::Zero());
  bench.Add(options, Block(0));
  bench.Start();
  const double touching = kSides.z() + ToolGeometry{}.tip_radius;
  bench.Step(OrganBench::Above(Vector3d(0.03, 0, touching + 0.001)));
  for (const double depth : {0.001, 0.006, 0.012}) {
    bench.Step(OrganBench::Above(Vector3d(0.03, 0, touching - depth)));
  }
  double angle = 0;
  for (int k = 0; k < 300 && angle < std::numbers::pi / 2; ++k) {
    bench.Step();
    angle = Eigen::AngleAxisd(bench.organ(0).relaxation->Rotation()).angle();
  }
  ASSERT_GT(angle, std::numbers::pi / 2);
  const Lattice& lattice = bench.model(0).lattice_organ()->lattice();
  const TissueQuadrature tissue = SampleTissue(bench.model(0).rest(), lattice.box(), {3, 3, 3});
  FiniteStrainEnergy energy(lattice, {tissue.points, tissue.weights}, MaterialLaw::kNeoHookean,
                            ToLame(options.material), Dilatation::kPointwise,
                            ScalarStiffness(lattice.size(), lattice.size()), nullptr);
  Points force;
  energy.Gradient(bench.organ(0).control_displacements, &force);
  EXPECT_LT(force.norm(), 1e-9 * options.material.young * kSides.squaredNorm());
}

// The jaws close on the edge of a wedge that lies on a floor, lift it, and let it fall.
TEST(FreeOrgan, AGraspLiftsItAndLetsItFall) {
  OrganBench bench;
  OrganOptions options = EdgeWedge::Options(4, 0);
  options.supports.clear();
  options.material.young = 20000;  // at 5 kPa the wedge sags by 40 mm
  options.free = FreeOptions{1};
  options.gravity_W = Vector3d(0, 0, -kG);
  const SurfaceMesh wedge = EdgeWedge::Surface(0.005);
  const double bottom = wedge.vertices.col(2).minCoeff();
  OrganOptions floor;
  floor.name = "floor";
  floor.model = OrganModelType::kRigid;
  bench.Add(floor,
            GridBox(Vector3d(-0.3, -0.3, bottom - 0.05), Vector3d(0.3, 0.3, bottom), {24, 24, 4}));
  bench.Add(options, wedge, 0.1);
  ToolOptions grasper;
  grasper.geometries[0].can_grasp = true;
  bench.Start({grasper});
  const auto jaws = [](const Vector3d& p, double jaw) {
    ToolPose tool;
    tool.X_WT.translation() = p;
    tool.p_trocar_W = p + Vector3d(0, 0, 0.3);
    tool.jaw = jaw;
    return tool;
  };
  bench.Step(jaws(Vector3d(1, 1, 1), 1));
  bench.Step(jaws(Vector3d::Zero(), 0));
  ASSERT_GT(bench.organ(1).contacts.tool_rows(), 1);
  const double start = Centre(bench, 1).z();
  for (int k = 1; k <= 90; ++k) bench.Step(jaws(Vector3d(0, 0, 0.003 * std::min(k, 30)), 0));
  const double weight = bench.model(1).free_body()->mass * kG;
  EXPECT_NEAR(bench.ToolForce(1).z() / weight, 1, 0.02);
  EXPECT_GT(Centre(bench, 1).z() - start, 0.07);
  // The released organ falls from rest: the grasp has left it no velocity.
  const double released = MassCentre(bench, 1).z();
  for (int k = 0; k < 60; ++k) {
    bench.Step(jaws(Vector3d(0, 0, 0.2), 1));
    if (k == 2) {
      EXPECT_NEAR((released - MassCentre(bench, 1).z()) / ClosedFormFall(1, 0.1), 1, 0.01);
    }
  }
  EXPECT_EQ(bench.organ(1).contacts.tool_rows(), 0);
  EXPECT_NEAR(bench.PairForce(1).z() / weight, 1, 0.05);
}

TEST(FreeOrgan, ACopyContinuesBitForBit) {
  OrganBench bench;
  AddFloor(&bench);
  bench.Add(FreeOptionsOf(1, Vector3d(0, 0, -kG)), Block(0.03), 0.3);
  bench.Start();
  for (int k = 0; k < 4; ++k) bench.Step();
  const std::unique_ptr<Relaxation> copy = bench.organ(1).relaxation->Clone();
  ContactConstraints none(bench.model(1).control_points());
  Points U = bench.organ(1).control_displacements, V = U;
  const std::unique_ptr<Relaxation> other = copy->Clone();
  for (int k = 0; k < 10; ++k) copy->Relax(&none, &U);
  for (int k = 0; k < 10; ++k) other->Relax(&none, &V);
  EXPECT_EQ(U, V);
  EXPECT_LT(U.col(2).mean(), bench.organ(1).control_displacements.col(2).mean());
}

}  // namespace
}  // namespace hpdm
