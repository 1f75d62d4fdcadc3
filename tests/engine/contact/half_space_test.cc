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

}  // namespace
}  // namespace hpdm
