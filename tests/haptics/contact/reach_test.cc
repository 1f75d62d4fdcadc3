// Tests that a contact is found at once wherever a fast tip goes, on meshes of any size.
#include <gtest/gtest.h>

#include "tools/haptics/contact_trials.h"
#include "tools/shared/simple_bodies.h"

namespace hpdm {
namespace {

constexpr double kReachRadius = kDefaultToolRadius;

// Edges of about 5, 2.5 and 1.25 mm. The patch alone is 6 mm wide on the finest.
TEST(Reach, AFastObliqueTipIsFeltAsSoonAsItTouchesOnMeshesOfAnySize) {
  for (const int splits : {4, 5, 6}) {
    for (const double speed : {0.3, 1.0}) {
      const Approach approach = ComeDown(splits, speed);
      EXPECT_TRUE(approach.felt);
      EXPECT_LE(approach.ticks_late, 1)
          << splits << " splits, " << speed << " m/s, " << 1e3 * approach.deepest << " mm deep";
    }
  }
}

// Returns how deep (m) a tip presses the ellipsoid at rest, to first order.
double PressedDepth(const Vector3d& p_tip) {
  const Vector3d scaled = p_tip.cwiseQuotient(kEllipsoidAxes);
  const double slope = 2 * scaled.cwiseQuotient(kEllipsoidAxes).norm();
  return kReachRadius - (scaled.squaredNorm() - 1) / slope;
}

// A tip that slides at 1 m/s leaves the finest mesh's patch within 6 ms and then presses the coarse
// surface.
TEST(Reach, AFastSlideKeepsItsDepthOnMeshesOfAnySize) {
  const double z = kEllipsoidAxes.z() - 0.003 + kReachRadius;
  for (const int splits : {4, 5, 6}) {
    FeltBench bench(EllipsoidOptions(), Ellipsoid(kEllipsoidAxes, splits));
    for (double down = 0.005; down > 0; down -= 1e-4) {
      bench.SessionTick(FeltBench::At(Vector3d(-0.02, 0, z + down)));
    }
    for (int i = 0; i < 200; ++i) bench.SessionTick(FeltBench::At(Vector3d(-0.02, 0, z)));
    double last = bench.Hand().z();
    for (double x = -0.02; x < 0.02; x += 1e-3) {
      ToolPose tool = FeltBench::At(Vector3d(x, 0, z));
      tool.v_tip_W = Vector3d::UnitX();
      bench.SessionTick(tool);
      EXPECT_NEAR(bench.Felt().depth, PressedDepth(tool.X_WT.translation()),
                  CoarseSurface::kMaxError)
          << splits << " splits, x " << x;
      EXPECT_NEAR(bench.Hand().z(), last, 0.1 * last);
      last = bench.Hand().z();
    }
  }
}

}  // namespace
}  // namespace hpdm
