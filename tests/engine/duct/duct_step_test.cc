// Ducts in the deformation loop: against closed forms of clamped tubes and of tubes between two
// lattices, the third law, what the hand feels, sleep and copies.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/bed_layer.h"
#include "tests/support/counted_allocations.h"
#include "tests/support/shapes.h"
#include "tools/shared/organ_bench.h"

namespace hpdm {
namespace {

constexpr double kHalfMotion = 1;  // s: then an organ's offset is its whole displacement

// Two blocks, one above the other, and a duct of 30 mm between their facing sides.
struct DuctBetweenBlocks {
  double young = 3e4;  // Pa, of the blocks
  bool rigid = false;
  Vector3d motion_W = Vector3d::Zero();  // m, of the upper block's support
  double wall_young = 5e5;               // Pa
  double radius = 0.002;                 // m
  double scale = 1;                      // of all lengths
  Matrix3d turn = Matrix3d::Identity();
  double length = 0.03;

  DuctOptions Duct() const {
    DuctOptions duct;
    duct.name = "duct";
    duct.a = "below";
    duct.b = "above";
    duct.path_W.resize(2, 3);
    duct.path_W.row(0) = scale * (turn * Vector3d(0, 0, 0)).transpose();
    duct.path_W.row(1) = scale * (turn * Vector3d(0, 0, length)).transpose();
    duct.radius = scale * radius;
    duct.wall = 0.4 * duct.radius;
    duct.young = wall_young;
    return duct;
  }
  TubeSection Section() const {
    const DuctOptions duct = Duct();
    return {duct.young, duct.radius, duct.wall, kDuctPoisson};
  }
  void AddBlock(OrganBench* bench, const std::string& name, double from, double to,
                const Vector3d& motion) const {
    OrganOptions block;
    block.name = name;
    block.material = {.young = young, .poisson = 0.3};
    block.lattice.cells = {3, 3, 2};
    block.lattice.margin = 0.0005 * scale;
    block.lattice.local.functions = 0;
    block.motion = {scale * (turn * motion), 0.5 / kHalfMotion};
    SurfaceMesh mesh = GridBox(Vector3d(-0.015, -0.015, from) * scale,
                               Vector3d(0.015, 0.015, to) * scale, {6, 6, 4});
    mesh.vertices = (mesh.vertices * turn.transpose()).eval();
    if (rigid) {
      block.model = OrganModelType::kRigid;
    } else {
      // The half that is away from the duct.
      const double middle = (from + to) / 2, reach = 0.011 + std::abs(from - to) / 2;
      const Vector3d centre(0, 0, from < 0 ? middle - reach : middle + reach);
      block.supports.push_back(
          {hpdm::Sphere{scale * (turn * (5.0 * centre)), scale * (4 * centre.norm() + 0.012)}, {}});
    }
    bench->Add(block, std::move(mesh));
  }
  void AddTo(OrganBench* bench) const {
    AddBlock(bench, "below", -0.015, 0, Vector3d::Zero());
    AddBlock(bench, "above", length, length + 0.015, motion_W);
    bench->Join(Duct());
  }
};

const DuctState& StateOf(const OrganBench& bench) {
  return bench.loop().links()[0].state().ducts()[0];
}

// Moves the upper block and waits.
void MoveAndSettle(OrganBench* bench, double share = 1, int steps = 6) {
  for (int step = 0; step < steps; ++step) {
    bench->StayAt(kHalfMotion * share);
    bench->Step();
  }
}

struct EndsCase {
  std::string name;
  double scale;
  Vector3d turn;
};
class DuctEnds : public testing::TestWithParam<EndsCase> {};
INSTANTIATE_TEST_SUITE_P(Cases, DuctEnds,
                         testing::Values(EndsCase{"upright", 1, Vector3d::Zero()},
                                         EndsCase{"turned", 1, Vector3d(0.5, -1.1, 0.8)},
                                         EndsCase{"larger", 10, Vector3d(0, 0.3, 0)}),
                         [](const auto& param_info) { return param_info.param.name; });

TEST_P(DuctEnds, OfRigidOrgansAreClamped) {
  const EndsCase& c = GetParam();
  // Small: across, the tube also stretches by 0.6 d^2 / L.
  for (const Vector3d& way : {Vector3d(0, 0, 1e-4), Vector3d(3e-6, 0, 0), Vector3d(0, -3e-6, 0)}) {
    DuctBetweenBlocks blocks{
        .rigid = true, .motion_W = way, .scale = c.scale, .turn = RotationOf(c.turn)};
    OrganBench bench;
    blocks.AddTo(&bench);
    bench.Start();
    MoveAndSettle(&bench);
    const TubeSection s = blocks.Section();
    const double length = c.scale * blocks.length;
    const double along = s.axial / length;
    const double across = 1 / (std::pow(length, 3) / (12 * s.bending) + length / s.across);
    const Vector3d expected = -c.scale * Vector3d(across, across, along).cwiseProduct(way);
    const Vector3d load = blocks.turn.transpose() * StateOf(bench).Outcome().load_W;
    EXPECT_LT((load - expected).norm(), 0.02 * expected.norm()) << way.transpose();
  }
}

// Displacement and rotation (6 x 3n) of a block's material at a point, by the lattice's weights.
Eigen::MatrixXd RowsAt(const OrganModel& model, const Vector3d& p_W) {
  const Lattice& lattice = model.lattice_organ()->lattice();
  const Points point = p_W.transpose();
  const WeightMatrix values = lattice.Weights(point);
  const std::array<WeightMatrix, 3> slopes = lattice.GradientWeights(point);
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(6, 3 * model.control_points());
  for (int a = 0; a < model.control_points(); ++a) {
    for (int d = 0; d < 3; ++d) {
      rows(d, 3 * a + d) = values.coeff(0, a);
      // Half the curl.
      const int e = (d + 1) % 3, f = (d + 2) % 3;
      rows(3 + d, 3 * a + f) += 0.5 * slopes[ToSize(e)].coeff(0, a);
      rows(3 + d, 3 * a + e) -= 0.5 * slopes[ToSize(f)].coeff(0, a);
    }
  }
  return rows;
}

// Timoshenko's beam along z, ends (u, rotation).
Eigen::MatrixXd BeamStiffness(const TubeSection& s, double length) {
  // Flexibility of the last end with the first one clamped.
  Eigen::Matrix<double, 6, 6> flexibility = Eigen::Matrix<double, 6, 6>::Zero();
  const double bend = std::pow(length, 3) / (3 * s.bending) + length / s.across;
  const double turn = length * length / (2 * s.bending), slope = length / s.bending;
  flexibility.diagonal() << bend, bend, length / s.axial, slope, slope, length / s.torsion;
  flexibility(0, 4) = flexibility(4, 0) = turn;
  flexibility(1, 3) = flexibility(3, 1) = -turn;
  const Eigen::Matrix<double, 6, 6> K = flexibility.inverse();
  // Rigid motion of the last end with the first.
  Eigen::Matrix<double, 6, 6> with = Eigen::Matrix<double, 6, 6>::Identity();
  with(0, 4) = length;
  with(1, 3) = -length;
  Eigen::MatrixXd S(12, 12);
  S << with.transpose() * K * with, -with.transpose() * K, -K * with, K;
  return S;
}

// The organs' compliance at the ends, from their whole stiffness, and a beam between them.
TEST(Ducts, BetweenTwoLatticesAreBeamsBetweenSprings) {
  for (const double young : {1e4, 1e5}) {
    for (const double radius : {0.0012, 0.003}) {
      for (const Vector3d& way : {Vector3d(2e-6, 0, 0), Vector3d(0.8e-6, 2e-6, 1e-6)}) {
        DuctBetweenBlocks blocks{.young = young, .motion_W = way, .radius = radius};
        OrganBench bench;
        blocks.AddTo(&bench);
        bench.Start();
        MoveAndSettle(&bench);
        Eigen::MatrixXd G = Eigen::MatrixXd::Zero(12, 12);
        for (int o = 0; o < 2; ++o) {
          // Just inside the surface, where the tissue is.
          const Vector3d p_W(0, 0, o == 0 ? -1e-9 : blocks.length + 1e-9);
          const Eigen::MatrixXd rows = RowsAt(bench.model(o), p_W);
          const auto& K = std::get<FullStiffness>(bench.model(o).stiffness());
          G.block<6, 6>(6 * o, 6 * o) =
              rows * Eigen::MatrixXd(K).partialPivLu().solve(rows.transpose());
        }
        const Eigen::MatrixXd S = BeamStiffness(blocks.Section(), blocks.length);
        Eigen::VectorXd moved = Eigen::VectorXd::Zero(12);
        moved.segment<3>(6) = way;
        const Eigen::VectorXd q =
            (Eigen::MatrixXd::Identity(12, 12) + S * G).partialPivLu().solve(S * moved);
        const Vector3d load_W = StateOf(bench).Outcome().load_W;
        EXPECT_LT((load_W + q.segment<3>(6)).norm(), 0.02 * load_W.norm())
            << young << " " << radius << " " << way.transpose() << ": " << load_W.transpose()
            << " for " << -q.segment<3>(6).transpose();
      }
    }
  }
}

// The forces K U on an organ's control points, as a force and a moment about the origin.
Eigen::Matrix<double, 6, 1> LoadOn(const OrganBench& bench, int o) {
  const Points& U = bench.organ(o).control_displacements;
  const Eigen::Map<const Eigen::VectorXd> u(U.data(), U.size());
  const Eigen::VectorXd f = std::get<FullStiffness>(bench.model(o).stiffness()) * u;
  const Points points = bench.model(o).lattice_organ()->lattice().ControlPoints();
  Eigen::Matrix<double, 6, 1> load = Eigen::Matrix<double, 6, 1>::Zero();
  for (Eigen::Index a = 0; a < points.rows(); ++a) {
    const Vector3d force = f.segment<3>(3 * a), arm = points.row(a);
    load.head<3>() += force;
    load.tail<3>() += arm.cross(force);
  }
  return load;
}

TEST(Ducts, PushAndTurnBothOrgansAlike) {
  for (const Vector3d& way : {Vector3d(0.003, 0.002, 0.001), Vector3d(-0.006, 0.001, -0.004)}) {
    DuctBetweenBlocks blocks{.young = 2e4, .motion_W = way};
    OrganBench bench;
    blocks.AddTo(&bench);
    bench.Start();
    MoveAndSettle(&bench, 1, 12);
    const Vector3d load_W = StateOf(bench).Outcome().load_W;
    EXPECT_GT(load_W.norm(), 1e-3);
    const auto below = LoadOn(bench, 0), above = LoadOn(bench, 1);
    EXPECT_LT((above.head<3>() - load_W).norm(), 0.01 * load_W.norm()) << way.transpose();
    EXPECT_LT((below.head<3>() + load_W).norm(), 0.01 * load_W.norm()) << way.transpose();
  }
}

TEST(Ducts, TheStepIsInEquilibriumWhenTheyBendFar) {
  DuctBetweenBlocks blocks{.young = 2e4, .motion_W = Vector3d(0.012, 0, -0.008)};
  OrganBench bench;
  blocks.AddTo(&bench);
  bench.Start();
  for (int step = 0; step < 20; ++step) {
    bench.StayAt(kHalfMotion * std::min(1.0, step / 12.0));
    bench.Step();
  }
  const Vector3d load_W = StateOf(bench).Outcome().load_W;
  const Points before = bench.organ(1).control_displacements;
  bench.StayAt(kHalfMotion);
  bench.Step();
  EXPECT_LT((StateOf(bench).Outcome().load_W - load_W).norm(), 1e-3 * load_W.norm());
  EXPECT_LT((bench.organ(1).control_displacements - before).norm(), 1e-3 * before.norm());
}

// An organ that a layer and a duct hold: both forces together balance its own.
TEST(Ducts, JoinWithAttachments) {
  DuctBetweenBlocks blocks{.young = 2e4, .motion_W = Vector3d(0.001, 0, 0.002)};
  OrganBench bench;
  blocks.AddTo(&bench);
  OrganOptions plate;
  plate.name = "plate";
  plate.model = OrganModelType::kRigid;
  bench.Add(plate,
            GridBox(Vector3d(-0.04, -0.0253, -0.01), Vector3d(0.04, -0.0153, 0.03), {12, 12, 12}));
  AttachmentOptions layer =
      BedLayer("below", "plate", hpdm::Box{Vector3d(-1, -1, -1), Vector3d(1, 1, 1)}, 0.001);
  layer.strength = 1e6;
  layer.toughness = 1e5;
  bench.Attach(layer);
  bench.Start();
  MoveAndSettle(&bench, 1, 12);
  ASSERT_EQ(bench.loop().links().size(), 1);
  const Vector3d of_duct_W = -StateOf(bench).Outcome().load_W;
  const Vector3d of_layer_W = -bench.loop().links()[0].outcomes()[0].load_W;
  EXPECT_GT(of_layer_W.norm(), 0.05 * of_duct_W.norm());
  EXPECT_LT((LoadOn(bench, 0).head<3>() - of_duct_W - of_layer_W).norm(), 0.01 * of_duct_W.norm());
}

// Jaws on the upper block, whose support is far: the patch's compliance is that of two solved steps.
TEST(Ducts, TheHandFeelsThemThroughTheirOrgan) {
  Matrix3d with_W = Matrix3d::Zero();
  for (const bool joined : {true, false}) {
    DuctBetweenBlocks blocks{.young = 1e4, .wall_young = 1e7};
    OrganBench bench;
    blocks.AddBlock(&bench, "below", -0.015, 0, Vector3d::Zero());
    OrganOptions block;
    block.name = "above";
    block.material = {.young = 1e4, .poisson = 0.3};
    block.lattice.cells = {3, 3, 2};
    block.lattice.margin = 0.0005;
    block.lattice.local.functions = 0;
    block.supports.push_back({hpdm::Box{Vector3d(-1, -1, -1), Vector3d(-0.01, 1, 1)}, {}});
    bench.Add(block,
              GridBox(Vector3d(-0.015, -0.015, 0.03), Vector3d(0.015, 0.015, 0.034), {12, 12, 4}));
    if (joined) bench.Join(blocks.Duct());
    ToolOptions grasper;
    grasper.geometries[0].can_grasp = true;
    bench.Start({grasper});
    ToolPose tool = OrganBench::Above(Vector3d(0.01, 0, 0.034 + 0.0023));
    bench.Step(tool);
    tool.jaw = 0.05;
    for (int step = 0; step < 20; ++step) {
      tool.X_WT.translation().z() += 0.0001;
      bench.Step(tool);
    }
    for (int step = 0; step < 4; ++step) bench.Step(tool);
    const Matrix3d compliance_W = bench.patch.Front().tools[0].main().compliance_W;
    const Vector3d force_W = bench.ToolForce(1), back_W = 2e-6 * Vector3d(0.3, 0.2, -1);
    tool.X_WT.translation() += back_W;
    for (int step = 0; step < 3; ++step) bench.Step(tool);
    const Vector3d change_W = bench.ToolForce(1) - force_W;
    EXPECT_LT((compliance_W * change_W - back_W).norm(), 0.03 * back_W.norm()) << joined;
    if (joined) with_W = compliance_W;
    if (!joined) {
      EXPECT_GT(compliance_W(2, 2), 1.1 * with_W(2, 2));
    }
  }
}

TEST(Ducts, SleepAtRestAndComeBackToIt) {
  DuctBetweenBlocks blocks{.motion_W = Vector3d(0.004, 0.001, 0.002)};
  OrganBench bench;
  blocks.AddTo(&bench);
  bench.Start();
  bench.StayAt(0);
  bench.Step();
  EXPECT_FALSE(bench.organ(0).awake);
  MoveAndSettle(&bench);
  EXPECT_GT(bench.organ(0).control_displacements.norm(), 1e-4);
  EXPECT_TRUE(bench.organ(0).awake);
  MoveAndSettle(&bench, 0, 12);
  EXPECT_TRUE(bench.organ(0).control_displacements.isZero(0));
  EXPECT_FALSE(bench.organ(0).awake);
  EXPECT_EQ(StateOf(bench).Outcome().load_W, Vector3d::Zero());
}

TEST(Ducts, TheWorldHoldsAnEnd) {
  DuctBetweenBlocks blocks{.rigid = true, .motion_W = Vector3d(0, 0, 1e-4)};
  DuctOptions duct = blocks.Duct();
  duct.a = "";
  OrganBench bench;
  blocks.AddBlock(&bench, "above", blocks.length, blocks.length + 0.015, blocks.motion_W);
  bench.Join(duct);
  bench.Start();
  MoveAndSettle(&bench);
  const double expected = blocks.Section().axial / blocks.length * 1e-4;
  EXPECT_NEAR(StateOf(bench).Outcome().tension, expected, 0.02 * expected);
}

TEST(Ducts, ACopyMovesToTheLastBitAndNothingIsAllocated) {
  DuctBetweenBlocks blocks{.young = 2e4, .motion_W = Vector3d(0.01, 0.002, -0.006)};
  OrganBench bench;
  blocks.AddTo(&bench);
  bench.Start();
  TripleBuffer<ToolState> edge;
  TripleBuffer<ContactPatch> patch;
  TripleBuffer<SceneSnapshot> render, telemetry;
  std::optional<DeformationLoop> copy;
  ToolState tools;
  tools.tool_count = 1;
  tools.tools[0] = OrganBench::Away();
  bench.StayAt(0);
  bench.Step();
  const long before = AllocationsOfThisThread();
  for (int step = 0; step < 20; ++step) {
    bench.StayAt(kHalfMotion * step / 20.0);
    bench.Step();
  }
  if (kCountsAllocations) {
    EXPECT_EQ(AllocationsOfThisThread(), before);
  }
  copy.emplace(bench.loop());
  copy->Attach({edge, patch, render, telemetry});
  for (int step = 20; step < 40; ++step) {
    bench.StayAt(kHalfMotion * step / 20.0);
    const auto now =
        static_cast<Nanoseconds>(std::llround(bench.seconds() * kNanosecondsPerSecond));
    bench.Step();
    tools.tick = static_cast<std::uint64_t>(step) + 2;
    tools.time_ns = now;
    copy->Step(tools, now);
    ASSERT_EQ(copy->organ(1).control_displacements, bench.organ(1).control_displacements) << step;
    const Rod& theirs = copy->links()[0].state().ducts()[0].rod();
    for (int i = 0; i < theirs.nodes(); ++i) {
      ASSERT_EQ(theirs.node(i), StateOf(bench).rod().node(i)) << step << " " << i;
    }
  }
}

}  // namespace
}  // namespace hpdm
