#include "engine/attachment/cohesive_law.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace hpdm {
namespace {

AttachmentOptions BedOptions() {
  AttachmentOptions attachment;
  attachment.young = 20000;
  attachment.thickness = 0.001;
  attachment.strength = 10000;
  attachment.toughness = 45;
  return attachment;
}

// The traction of a layer that was pulled to `effective` for the first time.
double FirstTraction(const CohesiveLaw& law, double effective) {
  return (1 - law.Damage(effective)) * law.stiffness * effective;
}

TEST(CohesiveLaw, RisesToTheStrengthAndFallsLinearlyToNothing) {
  const AttachmentOptions attachment = BedOptions();
  const CohesiveLaw law(attachment);
  EXPECT_EQ(law.Damage(0.99 * law.onset), 0);
  EXPECT_NEAR(FirstTraction(law, law.onset), attachment.strength, 1e-9 * attachment.strength);
  for (const double share : {0.1, 0.5, 0.9}) {
    const double effective = law.onset + share * (law.final - law.onset);
    EXPECT_NEAR(FirstTraction(law, effective), (1 - share) * attachment.strength,
                1e-9 * attachment.strength);
  }
  EXPECT_EQ(law.Damage(law.final), 1);
  EXPECT_EQ(law.Damage(2 * law.final), 1);
}

// The area below the traction, less what the layer would give back on unloading.
TEST(CohesiveLaw, DissipatesTheAreaBelowItsTraction) {
  const CohesiveLaw law(BedOptions());
  constexpr int kParts = 20000;
  double work = 0;
  for (int i = 0; i < kParts; ++i) {
    const double effective = (i + 0.5) * law.final / kParts;
    work += FirstTraction(law, effective) * law.final / kParts;
    if (i % 1000 != 999) continue;
    const double reached = (i + 1) * law.final / kParts;
    const double stored = 0.5 * FirstTraction(law, reached) * reached;
    EXPECT_NEAR(law.Dissipated(law.Damage(reached)), work - stored, 1e-5 * law.toughness);
  }
  EXPECT_NEAR(work, law.toughness, 1e-5 * law.toughness);
  EXPECT_NEAR(law.Dissipated(1), law.toughness, 1e-12 * law.toughness);
}

TEST(CohesiveLaw, CountsNoPressureAndNoDirection) {
  const CohesiveLaw law(BedOptions());
  const Vector3d normal = Vector3d(1, 2, 2) / 3, across = Vector3d(2, 1, -2) / 3;
  EXPECT_NEAR(law.Effective(0.003 * normal, normal), 0.003, 1e-15);
  EXPECT_NEAR(law.Effective(0.003 * across, normal), 0.003, 1e-15);
  EXPECT_NEAR(law.Effective(0.003 * normal + 0.004 * across, normal), 0.005, 1e-15);
  EXPECT_NEAR(law.Effective(-0.003 * normal + 0.004 * across, normal), 0.004, 1e-15);
  EXPECT_FALSE(law.Closed(0.001 * normal, normal));
  EXPECT_TRUE(law.Closed(-0.001 * normal + 0.9 * law.final * across, normal));
  EXPECT_FALSE(law.Closed(-0.001 * normal + 1.1 * law.final * across, normal));
}

TEST(AttachmentOptions, LeastToughnessIsThatOfALayerThatBreaksAtItsStrength) {
  AttachmentOptions attachment = BedOptions();
  attachment.toughness = LeastToughness(attachment, attachment.thickness);
  const CohesiveLaw law(attachment);
  EXPECT_NEAR(law.final, law.onset, 1e-12 * law.onset);
}

}  // namespace
}  // namespace hpdm
