#include "haptics/contact/reaction_force.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "haptics/device/hand_script.h"
#include "tests/support/random_vector.h"

namespace hpdm {
namespace {

// Twelve neighbours 5-30 mm away, springs at rest.
ReactionNode RandomNode(HandRandom* random) {
  ReactionNode node;
  node.k1 = random->Uniform(50, 200);
  node.neighbour_count = ReactionNode::kMaxNeighbours;
  for (auto& neighbour : node.neighbours) {
    neighbour.edge = random->Uniform(0.005, 0.03) * RandomVector(random, 1).normalized();
    neighbour.rest_length = neighbour.edge.norm();
    neighbour.k2 = random->Uniform(1, 20);
  }
  return node;
}

TEST(ReactionForce, MatchesAWorkedExample) {
  // delta = (0.01, 0.04, 0);                       k1 delta              = (1.0, 4.0,  0.0)
  // l_1 = (0.03, 0.04, 0), |l_1| = 0.05:  50 (0.05 - 0.02) / 0.05 l_1    = (0.9, 1.2,  0.0)
  // l_2 = (-0.03, 0, 0.04), |l_2| = 0.05: 20 (0.05 - 0.10) / 0.05 l_2    = (0.6, 0.0, -0.8)
  ReactionNode node;
  node.k1 = 100;
  node.neighbour_count = 2;
  node.neighbours[0] = {.edge = {0.02, 0, 0}, .rest_length = 0.02, .k2 = 50};
  node.neighbours[1] = {.edge = {-0.04, -0.04, 0.04}, .rest_length = 0.1, .k2 = 20};
  // Beyond neighbour_count: N terms, not N + 1.
  node.neighbours[2] = {.edge = {1, 1, 1}, .rest_length = 0, .k2 = 1000};
  const Vector3d delta(0.01, 0.04, 0);
  // A few roundings of numbers of size 5.
  EXPECT_LT((ForceOnTissue(node, delta) - Vector3d(2.5, 5.2, -0.8)).norm(), 1e-14);
  EXPECT_EQ(ForceOnHand(node, delta), -ForceOnTissue(node, delta));
}

TEST(ReactionForce, IsZeroAtRest) {
  HandRandom random(1);
  for (int i = 0; i < 20; ++i) {
    // d_i is the edge's own length to the last bit, so every term vanishes exactly.
    EXPECT_EQ(ForceOnTissue(RandomNode(&random), Vector3d::Zero()), Vector3d::Zero());
  }
}

TEST(ReactionForce, PushesTheHandBackOutOfTheTissue) {
  ReactionNode node;
  node.k1 = 120;
  // Pressed down by 1 cm: the tissue is pushed down, the hand up.
  EXPECT_LT(ForceOnTissue(node, {0, 0, -0.01}).z(), 0);
  EXPECT_NEAR(ForceOnHand(node, {0, 0, -0.01}).z(), 1.2, 1e-15);
}

TEST(ReactionForce, StiffnessIsTheDerivativeOfTheForce) {
  HandRandom random(2);
  for (int i = 0; i < 50; ++i) {
    const ReactionNode node = RandomNode(&random);
    const Vector3d delta = RandomVector(&random, 0.004);
    const Matrix3d K = TissueStiffness(node, delta);
    const double h = 1e-6;
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d difference = (ForceOnTissue(node, delta + h * Vector3d::Unit(axis)) -
                                   ForceOnTissue(node, delta - h * Vector3d::Unit(axis))) /
                                  (2 * h);
      // Truncation (h / |l|)^2 sum k2 with |l| down to about 0.1 mm: 1e-4 * 240 N/m.
      EXPECT_LT((K.col(axis) - difference).norm(), 2e-2);
    }
    EXPECT_LT((K - K.transpose()).norm(), 1e-10);
  }
}

TEST(ReactionForce, TurnsWithTheNode) {
  HandRandom random(3);
  const Matrix3d R = Eigen::AngleAxisd(1.1, Vector3d(1, 2, -3).normalized()).toRotationMatrix();
  ReactionNode node = RandomNode(&random);
  const Vector3d delta(0.003, -0.002, 0.004);
  const Vector3d force = ForceOnTissue(node, delta);
  const Matrix3d K = TissueStiffness(node, delta);
  for (auto& neighbour : node.neighbours) neighbour.edge = R * neighbour.edge;
  // Round-off of a rotation relative to forces of 1 N and stiffnesses of 300 N/m.
  EXPECT_LT((ForceOnTissue(node, R * delta) - R * force).norm(), 1e-13);
  EXPECT_LT((TissueStiffness(node, R * delta) - R * K * R.transpose()).norm(), 1e-10);
}

TEST(ReactionForce, StaysFiniteAndContinuousWhereASpringsEndsMeet) {
  ReactionNode node;
  node.neighbour_count = 1;
  node.neighbours[0] = {.edge = {0.01, 0, 0}, .rest_length = 0.01, .k2 = 10};
  EXPECT_EQ(ForceOnTissue(node, {-0.01, 0, 0}), Vector3d::Zero());
  EXPECT_TRUE(TissueStiffness(node, {-0.01, 0, 0}).allFinite());
  Vector3d last = ForceOnTissue(node, {-0.0102, 0, 0});
  for (double x = -0.0102; x < -0.0098; x += 1e-7) {
    const Vector3d force = ForceOnTissue(node, {x, 0, 0});
    // The steepest slope is k2 * 100 = 1,000 N/m: 1e-4 N in a step of 0.1 um.
    EXPECT_LT((force - last).norm(), 1.01e-4);
    last = force;
  }
  // A spring without rest length has no singular point.
  node.neighbours[0].rest_length = 0;
  EXPECT_EQ(ForceOnTissue(node, {-0.01, 0, 0}), Vector3d::Zero());
}

// Neighbours so far away that each is a constant-direction spring: the form in which a general
// 3 x 3 stiffness is expressed.
TEST(ReactionForce, DistantNeighboursGiveAStiffnessAlongTheirDirections) {
  ReactionNode node;
  node.k1 = 100;
  node.neighbour_count = 1;
  node.neighbours[0] = {.edge = {1000, 0, 0}, .rest_length = 1000, .k2 = 50};
  const Vector3d delta(0.01, 0.02, 0);
  // |l| is known to 1e-13 m, so the spring's force to 5e-12 N; its turning costs k2 y^2 / 2 L.
  EXPECT_LT((ForceOnTissue(node, delta) - Vector3d(1.5, 2, 0)).norm(), 2e-5);
}

TEST(ReactionForce, IgnoresANeighbourCountOutOfRange) {
  HandRandom random(4);
  ReactionNode node = RandomNode(&random);
  const Vector3d delta(0.001, 0, 0);
  const Vector3d force = ForceOnTissue(node, delta);
  node.neighbour_count = std::numeric_limits<int>::max();
  EXPECT_EQ(ForceOnTissue(node, delta), force);
  node.neighbour_count = -1;
  EXPECT_EQ(ForceOnTissue(node, delta), node.k1 * delta);
}

}  // namespace
}  // namespace hpdm
