#include "scenes/loader/scene_edit.h"

#include "tests/support/scene_fixture.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

class SceneEdits : public SceneTest {
 protected:
  /// Returns the text after changes to the first organ and checks that it is a valid scene.
  std::string Edited(const std::string& text, std::vector<SceneKeyEdit> keys,
                     const std::vector<std::string>& removed = {}) {
    const Scene scene = Load(text);
    const std::string edited =
        EditedScene(scene, {{.organ = 0, .keys = std::move(keys), .removed_tables = removed}});
    after_ = Read(edited);
    return edited;
  }
  const OrganOptions& Organ() const { return after_.organs.at(0); }

  Scene after_;
};

constexpr char kTwoInstruments[] =
    "[[organ]]\nname = \"o\"\nmesh = \"m.obj\"\n"
    "[[instrument]]\nname = \"a\"\ntrocar = [-0.1, 0, 0.2]\ntrocar_friction = 1\n"
    "device.max_force = 5\n"
    "[[instrument]]\nname = \"b\"\ntrocar = [0.1, 0, 0.3]\n";

TEST_F(SceneEdits, ALeftHandedSceneExchangesPortsAndKeepsItsText) {
  const std::string end = kTwoInstruments;
  for (const std::string& begin :
       {std::string(), std::string("[scene]  # of mine\nname = \"s\"\n"),
        std::string("scene = {}\n"), std::string("scene = { name = \"s\" }\n"),
        std::string("scene.name = \"s\"\n"), std::string("[scene]\nleft_handed = false  # yet\n"),
        std::string("[scene]\nleft_handed = true\n")}) {
    SCOPED_TRACE(begin);
    const Scene right = Load(begin + end);
    const std::string text = LeftHandedScene(right);
    const Scene left = Read(text);
    EXPECT_TRUE(left.left_handed);
    EXPECT_NE(text.find("# "), begin.find('#') == std::string::npos ? 0 : std::string::npos);
    ASSERT_EQ(left.instruments.size(), 2u);
    EXPECT_EQ(left.instruments[0].name, "a");
    EXPECT_EQ(left.instruments[0].p_trocar_W, Vector3d(0.1, 0, 0.3));
    EXPECT_EQ(left.instruments[1].p_trocar_W, Vector3d(-0.1, 0, 0.2));
    EXPECT_EQ(left.instruments[0].trocar_friction, 0);
    EXPECT_EQ(left.instruments[1].trocar_friction, 1);
    EXPECT_EQ(left.instruments[1].device.max_force, 5);
    EXPECT_EQ(left.name, right.name);
    EXPECT_EQ(LeftHandedScene(left), text) << "twice is once";
  }
}

constexpr char kAuthors[] =
    "# what it is for\n"
    "[[organ]]\n"
    "name = \"liver\"   # the large one\n"
    "mesh = \"m.obj\"\n"
    "\n"
    "  [organ.lattice]   # \xc3\xa4 comment\n"
    "  cells = [6,\n"
    "           6, 6]   # dear\n"
    "  margin = 0.02\n"
    "\n"
    "  [organ.energy]\n"
    "  type = \"strain\"\n"
    "\n"
    "  [[organ.support]]\n"
    "  box_fraction = { min = [0, 0.7, 0], max = [1, 1, 1] }\n"
    "  fixed = true\n";

TEST_F(SceneEdits, ReplaceAValueAndNothingElse) {
  std::string expected = kAuthors;
  const std::string cells = "[6,\n           6, 6]";
  expected.replace(expected.find(cells), cells.size(), "[5, 4, 3]");
  EXPECT_EQ(Edited(kAuthors, {{"lattice", "cells", std::array<int, 3>{5, 4, 3}}}), expected);
  EXPECT_EQ(Organ().lattice.cells, (std::array<int, 3>{5, 4, 3}));
}

TEST_F(SceneEdits, PutMissingKeysBehindTheLastOfTheirTable) {
  std::string expected = kAuthors;
  const std::string last = "  margin = 0.02\n";
  expected.insert(expected.find(last) + last.size(), "  degree = 3\n  local_functions = 27\n");
  EXPECT_EQ(Edited(kAuthors, {{"lattice", "degree", 3}, {"lattice", "local_functions", 27}}),
            expected);
  EXPECT_EQ(Organ().lattice.local.functions, 27);
}

TEST_F(SceneEdits, AddATableWhereThereIsNone) {
  const std::string edited = Edited(kOrgan + "# end", {{"lattice", "margin", 0.0125}});
  EXPECT_EQ(edited, kOrgan + "\n  [organ.lattice]\n  margin = 0.0125\n# end");
  EXPECT_EQ(Organ().lattice.margin, 0.0125);
}

TEST_F(SceneEdits, AddATableAtTheEndOfAFileWithoutALineEnd) {
  std::string text = kOrgan;
  text.pop_back();
  Edited(text, {{"energy", "type", "strain"}});
  EXPECT_EQ(Organ().energy.type, EnergyType::kStrain);
}

TEST_F(SceneEdits, RewriteInlineTablesAndFollowDottedKeys) {
  const std::string inlined =
      Edited(kOrgan + "lattice = { margin = 0.01, cells = 4 }  # so\n",
             {{"lattice", "cells", std::array<int, 3>{3, 2, 1}}, {"lattice", "degree", 1}});
  EXPECT_TRUE(
      Contains(inlined, "lattice = { cells = [3, 2, 1], degree = 1, margin = 0.01 }  # so"));
  EXPECT_EQ(Organ().lattice.margin, 0.01);
  const std::string dotted = Edited(kOrgan + "lattice.margin = 0.01  # so\nunit = 'mm'\n",
                                    {{"lattice", "margin", 0.005}, {"lattice", "degree", 1}});
  EXPECT_TRUE(Contains(dotted, "lattice.margin = 0.005  # so\nlattice.degree = 1\nunit"));
  EXPECT_EQ(Organ().lattice.degree[0], 1);
}

TEST_F(SceneEdits, CommentOutRemovedKeysAndTables) {
  const std::string edited = Edited(kAuthors, {{"lattice", "basis", "bernstein"},
                                               {"lattice", "cells", std::monostate()},
                                               {"lattice", "local_functions", std::monostate()}});
  EXPECT_TRUE(Contains(edited, "  # cells = [6,\n           # 6, 6]   # dear\n"));
  EXPECT_EQ(Organ().lattice.basis, BasisType::kBernstein);
  const std::string rigid =
      Edited(kAuthors, {{"", "model", "rigid"}}, {"lattice", "energy", "material", "support"});
  EXPECT_TRUE(Contains(rigid, "mesh = \"m.obj\"\nmodel = \"rigid\"\n"));
  EXPECT_TRUE(Contains(rigid, "  # [[organ.support]]\n  # box_fraction"));
  EXPECT_EQ(Organ().model, OrganModelType::kRigid);
}

TEST_F(SceneEdits, RefuseAnOrganInAnInlineTable) {
  const Scene scene = Load("organ = [{ name = 'a', mesh = 'm.obj' }]\n");
  const std::string error =
      ErrorOf([&] { EditedScene(scene, {{.organ = 0, .keys = {}, .removed_tables = {}}}); });
  EXPECT_TRUE(Contains(error, "s.toml:1:10: organ: is an inline table"));
}

TEST_F(SceneEdits, RewriteNamesForAnotherFolder) {
  const std::string text =
      "[scene]\nname = \"m.obj\"\nbackground = 't.png'\n[[organ]]\nname='m.obj'\n"
      "mesh = \"meshes/liver_1332.obj\"  # there\n";
  const Scene scene = Load(text);
  EXPECT_EQ(MovedScene(scene, text, folder_.path()), text);
  const fs::path other = folder_.path() / "a" / "b";
  fs::create_directories(other);
  const std::string moved = MovedScene(scene, text, other);
  EXPECT_TRUE(Contains(moved, "mesh = \"../../meshes/liver_1332.obj\"  # there"));
  EXPECT_TRUE(Contains(moved, "name = \"m.obj\""));
  const Scene there = ParseScene(moved, other / "s.toml");
  EXPECT_TRUE(fs::equivalent(there.organs.at(0).mesh, scene.organs.at(0).mesh));
  EXPECT_TRUE(fs::equivalent(there.background, scene.background));
}

}  // namespace
}  // namespace hpdm
