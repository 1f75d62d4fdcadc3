// Tests a tip that meets more than one organ: each is felt, and none changes what another gives.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/felt_bench.h"
#include "tests/support/shapes.h"
#include "tools/haptics/contact_trials.h"

namespace hpdm {
namespace {

constexpr double kTipOfSeveral = kDefaultToolRadius;

// An ellipsoid that is held at its lower end. It stands at `p_W`.
OrganModel Ball(const Vector3d& p_W, const Vector3d& axes, OrganModelType model) {
  OrganOptions options = SoftOrgan("ball", 4);
  options.model = model;
  options.supports[0].region = BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)};
  if (model == OrganModelType::kRigid) options.supports.clear();
  Isometry3d X_WO = Isometry3d::Identity();
  X_WO.translation() = p_W;
  return {options, Ellipsoid(axes, 4, X_WO)};
}

std::vector<OrganModel> Organs(std::vector<std::pair<Vector3d, OrganModelType>> places,
                               const Vector3d& axes) {
  std::vector<OrganModel> organs;
  for (const auto& [p_W, model] : places) organs.push_back(Ball(p_W, axes, model));
  return organs;
}

// A soft slab lies 2 mm above a rigid body. The tip goes 12 mm down from the slab's top in the one
// scene and ends 1.5 mm inside the rigid body, which a wall of 200 N/m answers with 0.8 N.
TEST(SeveralOrgans, ATipThatPressesThroughASoftOrganFeelsTheRigidOneBehindIt) {
  const Vector3d flat(0.06, 0.06, 0.005), deep(0.06, 0.06, 0.04);
  const auto press = [&](bool has_block) {
    std::vector<OrganModel> organs;
    organs.push_back(Ball(Vector3d(0, 0, 0.047), flat, OrganModelType::kHpdm));
    if (has_block) organs.push_back(Ball(Vector3d::Zero(), deep, OrganModelType::kRigid));
    FeltBench bench(std::move(organs));
    for (double z = 0.06; z > 0.041; z -= 1e-4) {
      bench.SessionTick(FeltBench::At(Vector3d(0, 0, z)));
    }
    for (int i = 0; i < 300; ++i) bench.SessionTick(FeltBench::At(Vector3d(0, 0, 0.041)));
    return bench.Hand().z();
  };
  const double through = press(false);
  EXPECT_NEAR(press(true) - through, 200 * (kTipOfSeveral - 0.001), 0.01);
}

// In the notch between two balls the hand feels the sum of what each gives alone.
TEST(SeveralOrgans, ForcesOfTwoOrgansAddUp) {
  const Vector3d axes(0.04, 0.04, 0.04), left(-0.041, 0, 0), right(0.041, 0, 0);
  const auto press = [&](const std::vector<std::pair<Vector3d, OrganModelType>>& places) {
    FeltBench bench(Organs(places, axes));
    for (double z = 0.02; z > 0.002; z -= 1e-4) {
      bench.SessionTick(FeltBench::At(Vector3d(0.0005, 0, z)));
    }
    for (int i = 0; i < 300; ++i) bench.SessionTick(FeltBench::At(Vector3d(0.0005, 0, 0.002)));
    return bench.Hand();
  };
  const Vector3d from_left = press({{left, OrganModelType::kHpdm}});
  const Vector3d from_right = press({{right, OrganModelType::kHpdm}});
  const Vector3d both = press({{left, OrganModelType::kHpdm}, {right, OrganModelType::kHpdm}});
  EXPECT_GT(from_left.x(), 0.01);
  EXPECT_LT(from_right.x(), -0.01);
  EXPECT_LT((both - from_left - from_right).norm(), 1e-3 * from_left.norm());
}

TEST(SeveralOrgans, ASlideFromOneOrganToTheNextHasNoGapAndNoJump) {
  for (const double speed : {0.1, 0.3}) {
    const OrganSlide slide = SlideOverOrgans(2, speed);
    EXPECT_EQ(slide.ticks_without_force, 0);
    EXPECT_GT(slide.least_force, 0.03);
    // Half of what the same motion straight into the first ball gives.
    EXPECT_LT(slide.largest_step, 0.5 * slide.stiffness * 1e-3 * speed);
  }
}

}  // namespace
}  // namespace hpdm
