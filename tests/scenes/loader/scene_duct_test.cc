#include "tests/support/scene_fixture.h"

namespace hpdm {
namespace {

const std::string kOrgansOfDuct = kOrgan + "[[organ]]\nname='bag'\nmesh='m.obj'\n";

TEST_F(SceneTest, ADuctHasTheValuesOfItsKeys) {
  const Scene scene = Load(kOrgansOfDuct +
                           "[[duct]]\nname='cystic duct'\nlabel='clip'\na='bag'\nb='liver'\n"
                           "path=[[1,2,3],[4,5,6],[7,8,9]]\nradius=0.003\nwall=0.001\n"
                           "young=19000\n");
  ASSERT_EQ(scene.ducts.size(), 1);
  const DuctOptions& duct = scene.ducts[0];
  EXPECT_EQ(duct.name, "cystic duct");
  EXPECT_EQ(duct.label, "clip");
  EXPECT_EQ(duct.a, "bag");
  EXPECT_EQ(duct.b, "liver");
  EXPECT_EQ(duct.path_W, (Points(3, 3) << 1, 2, 3, 4, 5, 6, 7, 8, 9).finished());
  EXPECT_EQ(duct.radius, 0.003);
  EXPECT_EQ(duct.wall, 0.001);
  EXPECT_EQ(duct.young, 19000);
}

TEST_F(SceneTest, TheWorldHoldsAnEndWithoutAnOrgan) {
  const Scene scene = Load(kOrgansOfDuct +
                           "[[duct]]\nname='artery'\nb='bag'\npath=[[1,2,3],[4,5,6]]\n"
                           "radius=0.001\nwall=0.0003\nyoung=1\n");
  EXPECT_EQ(scene.ducts.at(0).a, "");
  EXPECT_EQ(scene.ducts[0].label, "");
}

}  // namespace
}  // namespace hpdm
