#include "engine/mesh/organ_size.h"

#include <gtest/gtest.h>

#include "tests/support/shapes.h"

namespace hpdm {
namespace {

/// An ellipsoid of a liver's size in metres, times `scale`.
SurfaceMesh Liver(double scale) { return Ellipsoid(scale * Vector3d(0.1, 0.08, 0.06), 2); }

TEST(OrganSize, AnOrganInItsOwnUnitIsOne) {
  EXPECT_TRUE(SizeOfOrgan(Liver(1), 1).IsOrgan());
  EXPECT_TRUE(SizeOfOrgan(Liver(0.05), 1).IsOrgan()) << "a gallstone of 10 mm";
  EXPECT_TRUE(SizeOfOrgan(Liver(2.5), 1).IsOrgan()) << "a torso";
}

TEST(OrganSize, AWrongUnitIsNoticedAndTheRightOneNamed) {
  const OrganSize mm = SizeOfOrgan(Liver(1000), 1), cm = SizeOfOrgan(Liver(100), 1),
                  m = SizeOfOrgan(Liver(0.001), 0.001);
  EXPECT_FALSE(mm.IsOrgan() || cm.IsOrgan() || m.IsOrgan());
  EXPECT_EQ(mm.likely_unit, "mm");
  EXPECT_EQ(cm.likely_unit, "0.01");
  EXPECT_EQ(m.likely_unit, "m");
}

TEST(OrganSize, TooMuchTissueIsNoOrganEvenIfItIsShort) {
  const SurfaceMesh ball = Ellipsoid(Vector3d(0.5, 0.5, 0.5), 2);
  EXPECT_LT(SizeOfOrgan(ball, 1).across, OrganSize::kMaxAcross);
  EXPECT_FALSE(SizeOfOrgan(ball, 1).IsOrgan());
}

}  // namespace
}  // namespace hpdm
