#include "engine/pairs/organ_overlap.h"

#include <gtest/gtest.h>

#include "tests/support/mesh_shapes.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

SurfaceMesh BallAt(const Vector3d& centre, double radius, int splits = 4) {
  Isometry3d X = Isometry3d::Identity();
  X.translation() = centre;
  return Ellipsoid(Vector3d::Constant(radius), splits, X);
}

TEST(OrganOverlap, OfTwoBallsIsThatOfTheirCentres) {
  for (const double gap : {0.02, 0.0015, -0.0008, -0.01}) {
    for (const double size : {0.03, 0.05}) {
      const Vector3d axis = Vector3d(1, 2, -0.5).normalized();
      const SurfaceMesh a = BallAt({0.1, 0, 0}, size);
      const SurfaceMesh b = BallAt(Vector3d(0.1, 0, 0) + (size + 0.04 + gap) * axis, 0.04);
      const OrganOverlap overlap = MeasureOverlap(a, b);
      constexpr double kFacets = 2.5e-4;
      EXPECT_NEAR(overlap.distance - overlap.depth, gap, kFacets);
      EXPECT_LE(std::min(overlap.distance, overlap.depth), 0);
      const Vector3d middle = Vector3d(0.1, 0, 0) + size * axis;
      EXPECT_LT((overlap.place_W - middle).norm(), 0.005 + std::abs(gap));
    }
  }
}

TEST(OrganOverlap, ABallWithinAnotherOverlapsUnlessThatIsHollow) {
  const SurfaceMesh outer = BallAt(Vector3d::Zero(), 0.06), inner = BallAt({0.01, 0, 0}, 0.02);
  EXPECT_NEAR(MeasureOverlap(outer, inner).depth, 0.05, 5e-4);
  const SurfaceMesh hollow = Joined(outer, Reversed(BallAt(Vector3d::Zero(), 0.05)));
  const OrganOverlap apart = MeasureOverlap(hollow, inner);
  EXPECT_EQ(apart.depth, 0);
  EXPECT_NEAR(apart.distance, 0.02, 5e-4);
}

}  // namespace
}  // namespace hpdm
