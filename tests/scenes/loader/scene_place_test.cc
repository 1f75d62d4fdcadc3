#include "scenes/loader/scene_place.h"

#include "tests/support/scene_fixture.h"

namespace hpdm {
namespace {

TEST_F(SceneTest, AKeyHasThePlaceOfItsValueOrElseOfItsTable) {
  const Scene scene = Read(
      "[[organ]]\nname='a'\nmesh='m.obj'\n[[organ]]\nname='b'\nmesh='m.obj'\nunit='mm'\n"
      "[[organ.support]]\nfixed=true\nsphere={centre=[0,0,0],radius=1}\n" +
      kInstrument);
  const auto place = [&](const OptionKey& key) { return Shorten(PlaceInScene(scene, key)); };
  EXPECT_EQ(place({"organ", "b", "unit"}), "s.toml:7:6");
  EXPECT_EQ(place({"organ", "b", "support[0]"}), "s.toml:8:1");
  EXPECT_EQ(place({"organ", "b", "support[1]"}), "s.toml:4:1");
  EXPECT_EQ(place({"organ", "a", "unit"}), "s.toml:1:1");
  EXPECT_EQ(place({"instrument", "probe", "trocar"}), "s.toml:13:8");
  EXPECT_EQ(place({"instrument", "probe", "hand.target"}), "s.toml:11:1");
  EXPECT_EQ(place({"organ", "c", "unit"}), "s.toml");
  EXPECT_EQ(place({}), "s.toml");
}

}  // namespace
}  // namespace hpdm
