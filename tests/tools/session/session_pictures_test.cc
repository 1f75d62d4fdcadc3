#include <gtest/gtest.h>

#include "render/image/image_file.h"
#include "tests/support/scene_fixture.h"
#include "tools/session/session.h"

namespace hpdm {
namespace {

/// A tetrahedron of 0.1 m; `textured` gives it one texture coordinate for all corners.
std::string Tetrahedron(bool textured) {
  const std::string vt = textured ? "/1" : "";
  std::string text = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nvt 0.5 0.5\n";
  for (const char* face : {"132", "124", "143", "234"}) {
    text += 'f';
    for (int c = 0; c < 3; ++c) text += ' ' + (face[c] + vt);
    text += '\n';
  }
  return text;
}

class SessionPictures : public testing::Test {
 protected:
  SessionPictures() {
    folder_.Write("plain.obj", Tetrahedron(false));
    folder_.Write("textured.obj", Tetrahedron(true));
    folder_.Write("broken.png", "no picture");
    WritePng(folder_.path() / "good.png", Image{2, 1, {1, 2, 3, 4, 5, 6}});
  }

  Scene Load(const std::string& organ, const std::string& scene = "") const {
    return LoadScene(folder_.Write(
        "s.toml", "[scene]\n" + scene + "\n[[organ]]\nname='a'\n" + organ +
                      "\nlattice={basis='bspline',degree=1,cells=[1,1,1]}\nenergy.type='metric'\n"
                      "[[organ.support]]\nbox_fraction={min=[0,0,0],max=[1,1,0.5]}\nfixed=true\n"));
  }

  SceneFolder folder_;
};

TEST_F(SessionPictures, ReachTheViews) {
  const Session session(Load("mesh='textured.obj'\ntexture='good.png'", "background='good.png'"));
  const std::vector<OrganVisual> organs = session.OrganVisuals();
  ASSERT_EQ(organs.size(), 1u);
  ASSERT_NE(organs[0].texture, nullptr);
  EXPECT_EQ(organs[0].texture->width, 2);
  EXPECT_EQ(organs[0].rest->texture_coordinates.rows(), 3 * 4);
  ASSERT_NE(session.Background(), nullptr);
  EXPECT_EQ(session.Background()->height, 1);
}

TEST_F(SessionPictures, AreAbsentWhereTheSceneNamesNone) {
  const Session session(Load("mesh='plain.obj'"));
  EXPECT_EQ(session.OrganVisuals()[0].texture, nullptr);
  EXPECT_EQ(session.Background(), nullptr);
}

TEST_F(SessionPictures, UnreadablePicturesAreRefusedWithTheRemedy) {
  const std::string file = (folder_.path() / "broken.png").string();
  for (const auto& keys : {std::pair("mesh='textured.obj'\ntexture='broken.png'", ""),
                           std::pair("mesh='textured.obj'", "background='broken.png'")}) {
    const std::string error = ErrorOf([&] { Session session(Load(keys.first, keys.second)); });
    EXPECT_TRUE(StartsWith(error, file + ": "));
    EXPECT_TRUE(Contains(error, "; give a readable PNG file"));
  }
  const std::string error =
      ErrorOf([&] { Session session(Load("mesh='plain.obj'\ntexture='good.png'")); });
  EXPECT_TRUE(StartsWith(error, (folder_.path() / "plain.obj").string() + ": "));
  EXPECT_TRUE(Contains(error, "no texture coordinates"));
  EXPECT_TRUE(Contains(error, "remove organ.texture"));
}

}  // namespace
}  // namespace hpdm
