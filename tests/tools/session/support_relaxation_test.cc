#include "tools/session/support_relaxation.h"

#include <gtest/gtest.h>

#include "tests/support/shapes.h"

namespace hpdm {
namespace {

const InstrumentOptions kProbe;

// A block of 5 kPa, `share` of whose instantaneous modulus relaxes, on its lower quarter.
OrganModel Block(double share, std::optional<double> stiffness) {
  OrganOptions options;
  options.name = "block";
  options.energy.type = EnergyType::kStrain;
  options.lattice.cells = {3, 3, 3};
  options.lattice.local.functions = 0;
  if (share > 0) options.material.prony = {.count = 1, .terms = {{{share, 1}}}};
  options.supports.push_back({BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)}, stiffness});
  return {options, GridBox(Vector3d::Zero(), Vector3d(0.1, 0.1, 0.1), {4, 4, 4})};
}

TEST(SupportRelaxation, IsNoneOnRigidSupportsAndInElasticTissue) {
  EXPECT_FALSE(MeasureSupportRelaxation(Block(0.5, std::nullopt), kProbe));
  EXPECT_FALSE(MeasureSupportRelaxation(Block(0, 1e6), kProbe));
}

// On springs that are much softer than the block, nearly all compliance is theirs: the organ is
// stiffer by the whole factor of 2 that the springs should not have.
TEST(SupportRelaxation, GrowsAsTheSpringsBecomeSofter) {
  const auto stiff = MeasureSupportRelaxation(Block(0.5, 1e10), kProbe);
  const auto middle = MeasureSupportRelaxation(Block(0.5, 1e7), kProbe);
  const auto soft = MeasureSupportRelaxation(Block(0.5, 1e4), kProbe);
  ASSERT_TRUE(stiff && middle && soft);
  EXPECT_LT(stiff->median, 0.03);
  EXPECT_GT(middle->median, stiff->median);
  EXPECT_GT(soft->median, 0.9);
  EXPECT_LE(soft->greatest, 1 + 1e-6);
}

TEST(SupportRelaxation, IsAnnouncedIfItIsLarge) {
  EXPECT_EQ(SupportRemark("liver", {0.02, 0.09}), "");
  EXPECT_EQ(SupportRemark("liver", {0.15, 0.41}),
            "organ \"liver\": its supports with a stiffness relax with the tissue; at once it is "
            "15 % (median) to 41 % stiffer than on elastic supports; give them fixed = true or a "
            "greater stiffness, or less prony share");
}

}  // namespace
}  // namespace hpdm
