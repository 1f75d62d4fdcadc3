// The forces of layers and ducts against a dense solution with the stiffness of all samples and ducts.

#include "engine/attachment/joint_solver.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <utility>
#include <vector>

#include "engine/attachment/attachment_state.h"
#include "tests/support/bed_layer.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

OrganModel Block(const char* name, double young, const Vector3d& low, const Vector3d& high,
                 bool supported) {
  OrganOptions options;
  options.name = name;
  options.material = {.young = young, .poisson = 0.3};
  options.lattice.cells = {4, 3, 2};
  options.lattice.margin = 0;
  options.lattice.local.functions = 0;
  if (supported) {
    options.supports.push_back({hpdm::Box{Vector3d(-1, -1, -1), Vector3d(1, 1, -0.015)}, {}});
  }
  return OrganModel(options, GridBox(low, high, {8, 8, 4}));
}

// A block on two layers, and a duct from it to the one below. Nothing else holds the upper one but its
// weak spring, so it is far softer than the layers.
struct LayeredBlocks {
  LayeredBlocks() {
    std::vector<AttachmentBed> beds;
    for (const double side : {-1.0, 1.0}) {
      const hpdm::Box half{Vector3d(side < 0 ? -1 : 0.002, -1, -0.001),
                           Vector3d(side < 0 ? 0 : 1, 1, 0.001)};
      beds.emplace_back(BedLayer("lower", "upper", half, 0.002), lower, upper);
    }
    DuctOptions duct;
    duct.a = "lower";
    duct.b = "upper";
    duct.path_W.resize(2, 3);
    duct.path_W << -0.03, 0.01, -0.005, -0.02, 0.005, 0.01;
    duct.radius = 0.002;
    duct.wall = 0.001;
    duct.young = 1e5;
    const std::array organs{JoinedOrgan(0, lower, *relaxations[0], lower.control_points()),
                            JoinedOrgan(1, upper, *relaxations[1], upper.control_points())};
    joint = JoinOrgans(std::move(beds), {organs, organs, organs},
                       {std::make_shared<const DuctModel>(duct, &lower, &upper)})[0];
  }
  OrganModel lower =
      Block("lower", 5000, Vector3d(-0.03, -0.03, -0.02), Vector3d(0.03, 0.03, 0), true);
  OrganModel upper =
      Block("upper", 9000, Vector3d(-0.02, -0.025, 0.0005), Vector3d(0.025, 0.02, 0.02), false);
  std::array<std::unique_ptr<Relaxation>, 2> relaxations{lower.MakeRelaxation(0),
                                                         upper.MakeRelaxation(0)};
  std::shared_ptr<const AttachmentJoint> joint;
};

// Sums the stiffness over all samples and ducts.
Eigen::MatrixXd StiffnessOf(const AttachmentState& state) {
  const AttachmentJoint& joint = state.joint();
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(3 * joint.modes(), 3 * joint.modes());
  std::size_t at = 0;
  for (const AttachmentJoint::Layer& layer : joint.layers()) {
    for (int i = 0; i < layer.bed.size(); ++i, ++at) {
      const Vector3d normal = layer.bed.normals_W.row(i);
      const double d = state.damage()[at];
      Matrix3d k = (1 - d) * Matrix3d::Identity();
      if (state.closed()[at] != 0) k += d * normal * normal.transpose();
      k *= layer.bed.areas[i] * layer.bed.law.stiffness;
      for (Eigen::Index r = 0; r < layer.samples.rows(); ++r) {
        for (Eigen::Index c = 0; c < layer.samples.rows(); ++c) {
          R.block<3, 3>(3 * (layer.first_mode + r), 3 * (layer.first_mode + c)) +=
              layer.samples(r, i) * layer.samples(c, i) * k;
        }
      }
    }
  }
  for (std::size_t d = 0; d < joint.ducts().size(); ++d) {
    const Eigen::Index first = 3 * joint.ducts()[d].first_mode;
    const Eigen::Index count = state.ducts()[d].unknowns();
    R.block(first, first, count, count) = state.ducts()[d].stiffness();
  }
  return R;
}

TEST(JointSolver, ForcesAreThoseOfTheDenseStiffnessAtAnyDamage) {
  const LayeredBlocks blocks;
  AttachmentState state(blocks.joint);
  const Eigen::Index n = 3 * blocks.joint->modes();
  const Eigen::MatrixXd G = blocks.joint->compliance().leftCols(n);
  std::srand(3);
  double damage = 0, closed = 0;
  for (int round = 0; round < 7; ++round) {
    // Larger and larger, some samples pressed: first sound, then damaged, in the end torn.
    state.Update(Eigen::VectorXd::Random(n) * std::pow(10.0, -6 + 0.9 * round));
    if (round == 3) state.Burn(1, 5, 1);
    state.Refactor();
    damage = closed = 0;
    for (std::size_t i = 0; i < state.damage().size(); ++i) {
      damage += state.damage()[i];
      closed += state.closed()[i] != 0 && state.damage()[i] > 0 ? 1 : 0;
    }
    const Eigen::MatrixXd R = StiffnessOf(state);
    const FewColumns w_0 = FewColumns::Random(n, kFewColumns);
    const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(n, n);
    const Eigen::MatrixXd w = (one + G * R).partialPivLu().solve(Eigen::MatrixXd(w_0));
    const Eigen::MatrixXd expected = R * w;

    FewColumns q(n, kFewColumns);
    state.solver().FindForces(w_0, q);
    EXPECT_LT((q - expected).norm(), 1e-8 * expected.norm()) << round;

    Eigen::VectorXd q_alone = Eigen::VectorXd::Zero(n), w_alone = q_alone;
    state.solver().FindForces(w_0.col(2), &q_alone, &w_alone);
    EXPECT_LT((q_alone - expected.col(2)).norm(), 1e-8 * expected.col(2).norm()) << round;
    EXPECT_LT((w_alone - w.col(2)).norm(), 1e-8 * w.col(2).norm()) << round;

    Eigen::MatrixXd half(state.solver().half_size(), 11);  // more than one group
    Eigen::MatrixXd columns = Eigen::MatrixXd::Random(n, 11);
    columns.leftCols<kFewColumns>() = w_0;
    state.solver().Halve(columns, half);
    Eigen::MatrixXd forces = half;
    state.solver().TakeDuctForces(forces);
    const Eigen::MatrixXd products = (half.transpose() * forces).leftCols<kFewColumns>();
    EXPECT_LT((products - columns.transpose() * expected).norm(), 1e-8 * products.norm()) << round;
  }
  EXPECT_GT(damage, 0.8 * static_cast<double>(state.damage().size()));
  EXPECT_GT(closed, 5);
}

// A factor that keeps some rows equals a new one, to the last bit.
TEST(JointSolver, ForcesDoNotDependOnTheWayToTheirDamage) {
  const LayeredBlocks blocks;
  AttachmentState state(blocks.joint);
  const Eigen::Index n = 3 * blocks.joint->modes();
  std::srand(5);
  for (int round = 0; round < 9; ++round) {
    state.Update(Eigen::VectorXd::Random(n) * std::pow(10.0, -5 + 0.3 * round));
    state.Refactor();
    AttachmentState fresh(blocks.joint);
    fresh.TakeBack(state.solved());
    fresh.Refactor();
    const FewColumns w_0 = FewColumns::Random(n, kFewColumns);
    FewColumns q(n, kFewColumns), q_fresh(n, kFewColumns);
    state.solver().FindForces(w_0, q);
    fresh.solver().FindForces(w_0, q_fresh);
    EXPECT_EQ(q, q_fresh) << round;
  }
}

// Torn layers, and ducts without layers.
TEST(JointSolver, LayersThatAreGoneLeaveTheDucts) {
  const LayeredBlocks blocks;
  AttachmentState state(blocks.joint);
  for (std::size_t l = 0; l < 2; ++l) {
    for (int i = 0; i < blocks.joint->layers()[l].bed.size(); ++i) state.Burn(l, i, 1);
    state.TakeAway(l);
  }
  state.Refactor();
  const Eigen::Index n = 3 * blocks.joint->modes(), first = 3 * blocks.joint->ducts()[0].first_mode;
  const FewColumns w_0 = FewColumns::Random(n, kFewColumns);
  FewColumns q(n, kFewColumns);
  state.solver().FindForces(w_0, q);
  EXPECT_EQ(q.topRows(first).norm(), 0);
  const Eigen::MatrixXd G = blocks.joint->compliance().block(first, first, n - first, n - first);
  const Eigen::MatrixXd S = state.ducts()[0].stiffness();
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(n - first, n - first);
  const Eigen::MatrixXd expected =
      S * (one + G * S).partialPivLu().solve(Eigen::MatrixXd(w_0.bottomRows(n - first)));
  EXPECT_LT((q.bottomRows(n - first) - expected).norm(), 1e-8 * expected.norm());
}

}  // namespace
}  // namespace hpdm
