#include "haptics/contact/lattice_reaction.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "haptics/contact/reaction_force.h"
#include "haptics/device/hand_script.h"
#include "tests/support/random_vector.h"

namespace hpdm {
namespace {

// A 6 x 6 compliance of two tips, m/N: about 1 / (300 N/m), well coupled.
Eigen::Matrix<double, 6, 6> RandomCompliance(HandRandom* random) {
  Eigen::Matrix<double, 6, 6> A;
  for (double& value : A.reshaped()) value = random->Uniform(-1, 1);
  const Eigen::Matrix<double, 6, 6> C = A * A.transpose();
  return 1e-3 * (C + 0.3 * Eigen::Matrix<double, 6, 6>::Identity());
}

TEST(LatticeReaction, Equation29WithItsNeighboursIsTheCompliancesInverse) {
  HandRandom random(1);
  for (int i = 0; i < 200; ++i) {
    const Matrix3d C = RandomCompliance(&random).topLeftCorner<3, 3>();
    const ReactionNode node = NodeOfCompliance(C);
    EXPECT_EQ(node.neighbour_count, 2);
    for (const double size : {1e-7, 1e-4, 0.03}) {  // m
      const Vector3d delta = size * RandomVector(&random);
      const Vector3d force = C.ldlt().solve(delta);
      // The neighbours' directions turn by delta / 1e10 m; the rest is round-off.
      EXPECT_LT((ForceOnTissue(node, delta) - force).norm(), 1e-9 * force.norm());
    }
  }
}

TEST(LatticeReaction, TwoPressesSolveTheirComplementarityProblem) {
  HandRandom random(2);
  int both = 0, one = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto C = RandomCompliance(&random);
    const Matrix3d C_ac = C.topRightCorner<3, 3>();
    CondensedTip a, c;
    a.compliance_W = C.topLeftCorner<3, 3>();
    c.compliance_W = C.bottomRightCorner<3, 3>();
    a.normal_W = RandomVector(&random).normalized();
    c.normal_W = RandomVector(&random).normalized();
    a.depth = random.Uniform(-0.002, 0.01);
    c.depth = random.Uniform(-0.002, 0.01);
    Vector3d f_a, f_c;
    TipForces(a, c, C_ac, &f_a, &f_c);
    const double n_a = -a.normal_W.dot(f_a), n_c = -c.normal_W.dot(f_c);
    EXPECT_GE(n_a, 0);
    EXPECT_GE(n_c, 0);
    // Gaps of the tips from the tissue under both forces; 1e-8 of 1 cm for the pad of 1e-9.
    const double gap_a = -a.depth - a.normal_W.dot(a.compliance_W * f_a + C_ac * f_c);
    const double gap_c = -c.depth - c.normal_W.dot(c.compliance_W * f_c + C_ac.transpose() * f_a);
    EXPECT_GT(gap_a, -1e-9);
    EXPECT_GT(gap_c, -1e-9);
    EXPECT_LT(std::abs(gap_a * n_a), 1e-7);
    EXPECT_LT(std::abs(gap_c * n_c), 1e-7);
    both += n_a > 0 && n_c > 0;
    one += (n_a > 0) != (n_c > 0);
  }
  EXPECT_GT(both, 100);
  EXPECT_GT(one, 100);
}

// Two balls with friction on tissue whose half-space's normal is not the presses' own.
TEST(LatticeReaction, TwoBallsKeepTheirConditionsUnderTheirOwnLaws) {
  HandRandom random(5);
  int both = 0, one = 0;
  for (int i = 0; i < 500; ++i) {
    const auto C = RandomCompliance(&random);
    const Matrix3d C_ac = C.topRightCorner<3, 3>();
    CondensedTip tips[2];
    for (int t = 0; t < 2; ++t) {
      CondensedTip& tip = tips[t];
      tip.compliance_W = C.block<3, 3>(3 * t, 3 * t);
      tip.normal_W = RandomVector(&random).normalized();
      tip.friction_W = 0.2 * tip.normal_W.cross(RandomVector(&random).normalized());
      const Vector3d rest_normal = (tip.normal_W + 0.2 * RandomVector(&random)).normalized();
      tip.indentation = {{.young = 5000, .poisson = 0.45}, rest_normal, 0.005, 0.02};
      tip.depth = std::pow(10, random.Uniform(-6, -2)) * (random.Uniform(0, 1) < 0.2 ? -1 : 1);
    }
    Vector3d f[2];
    TipForces(tips[0], tips[1], C_ac, &f[0], &f[1]);
    int pressing = 0;
    for (int t = 0; t < 2; ++t) {
      const CondensedTip& tip = tips[t];
      const double f_n = -tip.normal_W.dot(f[t]);
      // The law's own statement of the local compliance.
      const Matrix3d own = tip.compliance_W + tip.indentation.UnderBall(f_n).Compliance();
      const Matrix3d cross = t == 0 ? C_ac : Matrix3d(C_ac.transpose());
      const double gap = -tip.depth - tip.normal_W.dot(own * f[t] + cross * f[1 - t]);
      EXPECT_GE(f_n, 0);
      EXPECT_GT(gap, -1e-9);
      EXPECT_LE(std::abs(gap * f_n), 1e-8 * f_n);
      EXPECT_LT((ComplianceAt(tip, f[t]) - own).norm(), 1e-9 * own.norm());
      pressing += f_n > 0;
      // The force that moves the pressed point there is the force itself.
      if (!(f_n > 0)) continue;
      EXPECT_LT((HoldingForce(tip, own * f[t]) - f[t]).norm(), 1e-6 * f[t].norm());
    }
    both += pressing == 2;
    one += pressing == 1;
  }
  EXPECT_GT(both, 50);
  EXPECT_GT(one, 50);
}

// The energy is summed along the press here.
TEST(LatticeReaction, TipEnergyIsTheWorkOfAPress) {
  HandRandom random(6);
  for (const double young : {500.0, 5000.0, 1e9}) {
    for (int i = 0; i < 20; ++i) {
      CondensedTip tip;
      tip.compliance_W = RandomCompliance(&random).topLeftCorner<3, 3>();
      tip.normal_W = RandomVector(&random).normalized();
      tip.indentation = {{.young = young, .poisson = 0.45}, tip.normal_W, 0.005, 0.02};
      double work = 0, last = 0;
      const double depth = random.Uniform(1e-3, 1e-2);
      constexpr int kParts = 4000;
      for (int k = 1; k <= kParts; ++k) {
        tip.depth = depth * k / kParts;
        const double f_n = -tip.normal_W.dot(TipForce(tip));
        work += 0.5 * (last + f_n) * depth / kParts;
        last = f_n;
      }
      const double stored = TipEnergy(tip, TipForce(tip));
      EXPECT_NEAR(stored, work, 0.01 * work) << young;
    }
  }
}

TEST(LatticeReaction, HeldTipsMoveAsTheirJawsDo) {
  HandRandom random(3);
  for (int i = 0; i < 200; ++i) {
    const auto C = RandomCompliance(&random);
    CondensedTip a, c;
    a.holds = c.holds = true;
    a.compliance_W = C.topLeftCorner<3, 3>();
    c.compliance_W = C.bottomRightCorner<3, 3>();
    a.p_current_W = 0.01 * RandomVector(&random);
    c.p_current_W = 0.01 * RandomVector(&random);
    Vector3d f_a, f_c;
    TipForces(a, c, C.topRightCorner<3, 3>(), &f_a, &f_c);
    Eigen::Matrix<double, 6, 1> moved, force;
    moved << a.p_current_W, c.p_current_W;
    force << f_a, f_c;
    // The condition number is about 100; the tips' own compliance is padded by 1e-9.
    EXPECT_LT((C * force - moved).norm(), 1e-6 * moved.norm());

    // A press beside it feels the held tissue.
    a.holds = false;
    a.normal_W = RandomVector(&random).normalized();
    a.depth = 0.01;
    TipForces(a, c, C.topRightCorner<3, 3>(), &f_a, &f_c);
    const Vector3d x_c = c.compliance_W * f_c + C.bottomLeftCorner<3, 3>() * f_a;
    EXPECT_LT((x_c - c.p_current_W).norm(), 1e-6 * c.p_current_W.norm());
    if (f_a.norm() > 0) {
      const Vector3d x_a = a.compliance_W * f_a + C.topRightCorner<3, 3>() * f_c;
      EXPECT_NEAR(a.normal_W.dot(x_a), -a.depth, 1e-8);
    }
  }
}

// Tests jaws on tissue points that cannot move apart, as within one cell of the lattice. Without
// slip the force is 5e8 N.
TEST(LatticeReaction, TipsThatTheTissueCannotTellApartSlip) {
  HandRandom random(4);
  for (int i = 0; i < 200; ++i) {
    CondensedTip a, c;
    a.compliance_W = c.compliance_W = RandomCompliance(&random).topLeftCorner<3, 3>();
    const Matrix3d coupling = a.compliance_W;
    const Vector3d way = 0.05 * RandomVector(&random).normalized();
    a.normal_W = way.normalized();
    c.normal_W = -a.normal_W;
    a.p_current_W = way;
    c.p_current_W = -way;
    a.depth = c.depth = way.norm();
    for (const bool a_holds : {true, false}) {
      for (const bool c_holds : {true, false}) {
        a.holds = a_holds;
        c.holds = c_holds;
        Vector3d f_a, f_c;
        TipForces(a, c, coupling, &f_a, &f_c);
        const double alone = std::max(TipForce(a).norm(), TipForce(c).norm());
        EXPECT_LE(std::max(f_a.norm(), f_c.norm()), 10 * alone) << "as in the step";
      }
    }
    // Moved alike, they share their force and do not slip.
    a.holds = c.holds = true;
    c.p_current_W = a.p_current_W;
    Vector3d f_a, f_c;
    TipForces(a, c, coupling, &f_a, &f_c);
    EXPECT_LT((f_a + f_c - TipForce(a)).norm(), 1e-6 * TipForce(a).norm()) << "the pad of 1e-9";
  }
}

TEST(LatticeReaction, ASeparatedPressHasNoForce) {
  CondensedTip tip;
  tip.compliance_W = 1e-3 * Matrix3d::Identity();
  tip.normal_W = Vector3d::UnitZ();
  tip.depth = -1e-9;
  EXPECT_EQ(TipForce(tip), Vector3d::Zero());
  tip.depth = 1e-3;
  EXPECT_LT((TipForce(tip) + Vector3d::UnitZ()).norm(), 1e-15);
}

}  // namespace
}  // namespace hpdm
