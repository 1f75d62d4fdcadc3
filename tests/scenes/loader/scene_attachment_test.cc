#include "tests/support/scene_fixture.h"

namespace hpdm {
namespace {

const std::string kTwoOrgans = kOrgan + "[[organ]]\nname='bag'\nmesh='m.obj'\n";

TEST_F(SceneTest, AnAttachmentHasTheValuesOfItsKeys) {
  const Scene scene =
      Load(kTwoOrgans +
           "[[attachment]]\na='bag'\nb='liver'\nsphere={centre=[1,2,3],radius=0.25}\n"
           "young=19000\nthickness=0.002\nstrength=9000\ntoughness=40\nreach=0.007\n");
  ASSERT_EQ(scene.attachments.size(), 1);
  const AttachmentOptions& attachment = scene.attachments[0];
  EXPECT_EQ(attachment.a, "bag");
  EXPECT_EQ(attachment.b, "liver");
  EXPECT_EQ(std::get<Sphere>(attachment.region).centre, Vector3d(1, 2, 3));
  EXPECT_EQ(attachment.young, 19000);
  EXPECT_EQ(attachment.thickness, 0.002);
  EXPECT_EQ(attachment.strength, 9000);
  EXPECT_EQ(attachment.toughness, 40);
  EXPECT_EQ(attachment.reach, 0.007);
}

TEST_F(SceneTest, AnAttachmentReachesOverThreeThicknesses) {
  const Scene scene =
      Load(kTwoOrgans +
           "[[attachment]]\na='bag'\nb='liver'\nbox={min=[0,0,0],max=[1,1,1]}\nyoung=19000\n"
           "thickness=0.002\nstrength=9000\ntoughness=40\n");
  EXPECT_EQ(scene.attachments.at(0).reach, 0.006);
}

}  // namespace
}  // namespace hpdm
