#include "engine/contact/half_space.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace hpdm {
namespace {

constexpr MaterialOptions kTissue{.young = 5000, .poisson = 0.45};

// Hankel's transform of the kernel cos(pi r / 2) at r = 0 gives its potential at the centre:
// (1/pi) int cos(pi r / 2) / r dA / (4 - 8 / pi) = 2 (2 / pi) / (4 - 8 / pi).
TEST(HalfSpace, SinksAtTheCentreAsTheClosedFormSays) {
  const double exact = 4 / std::numbers::pi / (4 - 8 / std::numbers::pi);
  EXPECT_NEAR(KernelSinking(0), exact, 1e-4 * exact);  // 48 midpoints along each chord
}

TEST(HalfSpace, FarAwayThePatchActsAsAPoint) {
  for (const double s : {10.0, 100.0}) {
    const double point = 1 / (std::numbers::pi * s);
    EXPECT_NEAR(KernelSinking(s) / point, 1, 0.1 / (s * s)) << s;  // second moment 0.32 / 4
  }
}

TEST(HalfSpace, TableJoinsTheMultipoleSeries) {
  EXPECT_NEAR(KernelSinking(3 - 1e-9), KernelSinking(3), 1e-3 * KernelSinking(3));
}

// The mean over the kernel lies between its values at the rim and at the centre; 0.67 is what an
// integration over pairs of points gives.
TEST(HalfSpace, MeanSinkingIsTwoThirds) { EXPECT_NEAR(MeanKernelSinking(), 0.673, 5e-4); }

TEST(LocalIndentation, EqualRadiiLeaveNoIndentation) {
  const LocalIndentation indentation(kTissue, Vector3d::UnitZ(), 0.005, 0.005);
  EXPECT_EQ(indentation.Compliance().norm(), 0);
  EXPECT_EQ(indentation.At(0).norm(), 0);
}

TEST(LocalIndentation, ComplianceGrowsAsTheInverseRadius) {
  const LocalIndentation coarse(kTissue, Vector3d::UnitZ(), 0.005, 1e3),
      fine(kTissue, Vector3d::UnitZ(), 0.0025, 1e3);
  EXPECT_NEAR(fine.Compliance()(2, 2) / coarse.Compliance()(2, 2), 2, 1e-4);  // radius / 1 km
}

TEST(LocalIndentation, ComplianceIsTheMeanOfTheProfile) {
  const double R = 0.0025, resolved = 0.02;
  const LocalIndentation indentation(kTissue, Vector3d::UnitZ(), R, resolved);
  double sum = 0, weights = 0;
  for (int i = 0; i < 1000; ++i) {
    const double d = (i + 0.5) / 1000 * R;
    const double weight = d * std::cos(std::numbers::pi * d / (2 * R));
    sum += weight * indentation.At(d)(2, 2);
    weights += weight;
  }
  // The patch sees the wider kernel's own indentation near its centre, not averaged over its own
  // patch.
  const double wide_at_centre = KernelSinking(0) / resolved,
               wide_mean = MeanKernelSinking() / resolved;
  const double H = (1 - 0.45 * 0.45) / 5000;
  EXPECT_NEAR(sum / weights, indentation.Compliance()(2, 2) - H * (wide_at_centre - wide_mean),
              0.005 * indentation.Compliance()(2, 2));
}

TEST(LocalIndentation, FadesContinuouslyAwayFromThePatch) {
  const LocalIndentation indentation(kTissue, Vector3d::UnitZ(), 0.0025, 0.02);
  EXPECT_LT(indentation.At(0.999 * IndentationReach(0.0025, 0.02))(2, 2),
            1e-3 * indentation.At(0)(2, 2));
  EXPECT_EQ(indentation.At(1.001 * IndentationReach(0.0025, 0.02)).norm(), 0);
}

TEST(LocalIndentation, IsSoftestAcrossTheNormalAndSymmetric) {
  const Vector3d n = Vector3d(1, 2, 2) / 3;
  const Matrix3d C = LocalIndentation(kTissue, n, 0.0025, 0.02).Compliance();
  EXPECT_LT((C - C.transpose()).norm(), 1e-15);
  // (1 + nu)(1 - nu / 2) against 1 - nu^2.
  const Vector3d t = n.unitOrthogonal();
  EXPECT_NEAR(t.dot(C * t) / n.dot(C * n), 1.45 * 0.775 / (1 - 0.45 * 0.45), 1e-12);
}

// A rigid ball on a half-space whose lattice part is exact.
class BallOnHalfSpace : public testing::Test {
 protected:
  static constexpr double kRadius = 0.005, kResolved = 0.03;  // m
  // N, for a depth in m.
  double Force(double depth) const {
    return ball_.PressingForce(depth, MeanKernelSinking() / (E_star_ * kResolved), 1 / E_star_);
  }
  // The depth (m) at the contact radius `a` by Abel's integral of the ball's slope,
  // a int_0^1 h'(a s) / sqrt(1 - s^2) ds with s = sin t.
  static double Depth(double a) {
    constexpr int kSteps = 400;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double r = a * std::sin((i + 0.5) / kSteps * std::numbers::pi / 2);
      sum += r / std::sqrt(kRadius * kRadius - r * r) * std::numbers::pi / 2 / kSteps;
    }
    return a * sum;
  }
  // The force (N) at that depth: each ring x adds 2 E* (depth - Depth(x)) dx.
  double ForceAt(double a) const {
    constexpr int kSteps = 400;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) sum += Depth(a) - Depth((i + 0.5) / kSteps * a);
    return 2 * E_star_ * sum * a / kSteps;
  }
  const double E_star_ = kTissue.young / (1 - kTissue.poisson * kTissue.poisson);
  const LocalIndentation ball_{kTissue, Vector3d::UnitZ(), kRadius, kResolved};
};

TEST_F(BallOnHalfSpace, IsHertzsInALightTouch) {
  for (const double share : {0.001, 0.01, 0.05}) {
    const double d = share * kRadius;
    const double hertz = 4.0 / 3 * E_star_ * std::sqrt(kRadius * d * d * d);
    // Hertz's paraboloid is wider than the ball by terms of d / R.
    EXPECT_NEAR(Force(d) / hertz, 1, 0.2 * share + 1e-4) << share;
  }
}

TEST_F(BallOnHalfSpace, IsSneddonsUntilItIsAsStiffAsTheKernel) {
  for (const double a_over_R : {0.02, 0.1, 0.3, 0.5, 0.74}) {
    const double a = a_over_R * kRadius;
    EXPECT_NEAR(Force(Depth(a)) / ForceAt(a), 1, 1e-4) << a_over_R;
  }
}

TEST_F(BallOnHalfSpace, StaysWithinThreePerCentOfSneddonsToTheDepthOfItsRadius) {
  EXPECT_NEAR(Depth(0.8336 * kRadius), kRadius, 1e-3 * kRadius);
  const double share = Force(Depth(0.8336 * kRadius)) / ForceAt(0.8336 * kRadius);
  EXPECT_LT(share, 1);
  EXPECT_GT(share, 0.97);
}

TEST_F(BallOnHalfSpace, HasOneLawForDepthYieldAndRadius) {
  double last = 0;
  for (double depth = 1e-8; depth < 0.02; depth *= 1.3) {
    const double f = Force(depth), yield = ball_.BallYield(f);
    EXPECT_GT(f, last) << "the force grows with the depth";
    last = f;
    // Depth = resolved part + q f / E*.
    EXPECT_NEAR(f / E_star_ * (MeanKernelSinking() / kResolved + yield), depth, 1e-9 * depth);
    const LocalIndentation drawn = ball_.UnderBall(f);
    EXPECT_NEAR(drawn.Compliance()(2, 2), yield / E_star_, 1e-9 * yield / E_star_);
    EXPECT_LE(drawn.radius(), kRadius);
    const double step = 1e-4 * f;
    const double rate =
        ((f + step) * ball_.BallYield(f + step) - (f - step) * ball_.BallYield(f - step)) /
        (2 * step);
    // One-sided where the law is only once differentiable.
    EXPECT_NEAR(ball_.BallYieldRate(f), rate, 1e-3 * rate) << depth;
  }
}

TEST(LocalIndentation, TissueWithoutAModulusDoesNotIndentUnderABall) {
  const LocalIndentation none(0.005);
  EXPECT_FALSE(none.indents());
  EXPECT_EQ(none.UnderBall(1).Compliance().norm(), 0);
  EXPECT_EQ(none.PressingForce(0.01, 0.005, 0), 2);
}

}  // namespace
}  // namespace hpdm
