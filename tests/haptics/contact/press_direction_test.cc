// The direction of a press: the surface's normal under the tip, averaged over the press's kernel. It
// must not turn when the contact crosses an edge of the triangulation.
#include <gtest/gtest.h>

#include "tools/haptics/contact_trials.h"

namespace hpdm {
namespace {

TEST(PressDirection, DoesNotTurnWithANewPatch) {
  for (const double radius : {0.005, 0.01}) {
    for (const int squares : {10, 32}) {
      const SlideTurn turn = TurnOfSlide(radius, squares);
      EXPECT_GT(turn.least_force, 0);
      // The force, which turns the surface, grows with the radius. The contact moves by 1.7 mm over
      // the lattice's cells between two steps, which a patch does not foresee.
      EXPECT_LT(turn.normal, 100 * radius) << radius << ' ' << squares;
    }
  }
}

TEST(PressDirection, AStillHandIsNotShaken) {
  for (const double radius : {0.005, 0.01}) {
    const StillHandTrial hand = SpeedOfStillHand(radius, 32);
    EXPECT_GT(hand.least_force, 0.5);
    EXPECT_LT(hand.rms_speed, 0.001) << radius;
  }
}

// The patch's law of the normal for a further force, against the next step's own surface.
TEST(PressDirection, TurnsWithTheForceAsThePatchSays) {
  for (const double radius : {0.0025, 0.01}) {
    FeltBench bench(SlabOptions(), Slab(32), BallTip(radius));
    const Vector3d at(0.083, 0.02, radius);  // near a side: the surface turns under the press
    bench.Step(FeltBench::At(at));
    bench.Tick(FeltBench::At(at - Vector3d(0, 0, 0.004)));
    bench.Step(FeltBench::At(at - Vector3d(0, 0, 0.004)));
    const ToolPatch before = bench.Patch();
    bench.Step(FeltBench::At(at - Vector3d(0, 0, 0.0042)));  // the tick keeps the contact's place
    const ToolPatch& after = bench.Patch();
    const Vector3d turn = after.tilt_W - before.tilt_W;
    const Vector3d further = after.force_on_tissue_W - before.force_on_tissue_W;
    EXPECT_GT(turn.norm(), 1e-4) << radius;
    EXPECT_LT((before.tilt_compliance_W * further - turn).norm(), 0.03 * turn.norm()) << radius;
  }
}

}  // namespace
}  // namespace hpdm
