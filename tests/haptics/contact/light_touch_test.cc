// A rigid ball on a block that is wide beside the contact feels the force of a half-space (Sneddon),
// in the step and in the tick, from the first touch to the depth of its radius.
#include <gtest/gtest.h>

#include <string>

#include "tools/haptics/contact_trials.h"

namespace hpdm {
namespace {

class LightTouch : public testing::TestWithParam<WideBlock> {};

TEST_P(LightTouch, HasTheForceOfABallOnAHalfSpace) {
  const MaterialOptions material = GetParam().Options().material;
  for (const double r : {0.0025, 0.005, 0.01}) {
    for (const BallPress& press :
         PressBall(GetParam(), r, {0.02 * r, 0.1 * r, 0.2 * r, 0.5 * r, r})) {
      const double force = SneddonForce(press.depth, r, material);
      // The finite block: up to 3 % at a contact of 1/24 of its width.
      EXPECT_NEAR(press.first_tick / force, 1, 0.035) << r << ' ' << press.depth;
      EXPECT_NEAR(press.step / force, 1, 0.035) << r << ' ' << press.depth;
      EXPECT_NEAR(press.settled_tick, press.step, 0.005 * force);
    }
  }
}

std::string NameOf(const testing::TestParamInfo<WideBlock>& block) {
  return std::to_string(block.param.cells) + "Cells" + std::to_string(block.param.local_functions) +
         "Local" + std::to_string(block.param.squares) + "Squares";
}

INSTANTIATE_TEST_SUITE_P(Blocks, LightTouch,
                         testing::Values(WideBlock{0.45, 4, 0, 8}, WideBlock{0.3, 4, 0, 32},
                                         WideBlock{0.45, 4, 27, 16}, WideBlock{0.3, 5, 8, 8}),
                         NameOf);

}  // namespace
}  // namespace hpdm
