#include "tools/check/scene_schema.h"

#include <algorithm>

#include "scenes/loader/scene_key_forms.h"
#include "scenes/loader/scene_keys.h"
#include "tests/support/program.h"
#include "tests/support/scene_fixture.h"

/// The JSON Schema of scene files, judged by a validator that shares no code with the loader.

namespace hpdm {
namespace {

namespace fs = std::filesystem;

class SceneSchemaTest : public SceneTest {
 protected:
  /// Returns the validator's lines for scene files.
  std::string Validate(const std::vector<fs::path>& scenes) const {
    const fs::path schema = folder_.Write("schema.json", SceneSchema());
    const std::string out = folder_.path() / "verdicts.txt";
    std::string command = std::string("/usr/bin/python3 -B ") + HPDM_SOURCE_DIR +
                          "/tests/tools/check/validate_scenes.py " + schema.string();
    for (const fs::path& scene : scenes) command += " " + scene.string();
    EXPECT_EQ(Shell(command + " >" + out), 0);
    return ReadFile(out);
  }
};

TEST_F(SceneSchemaTest, TheFileForEditorsIsWhatTheProgramPrints) {
  EXPECT_EQ(ReadFile(kScenes / "scene.schema.json"), SceneSchema())
      << "run: build/tools/hpdm check --schema > scenes/scene.schema.json";
}

TEST_F(SceneSchemaTest, EveryKeyOfTheLoaderHasAForm) {
  const auto forms = SceneKeyForms();
  EXPECT_EQ(forms.size(), std::size(kSceneTables));
  for (const SceneTable& table : kSceneTables) {
    const auto form = forms.find(table.path);
    ASSERT_NE(form, forms.end()) << table.path;
    EXPECT_EQ(form->second.keys.size(), table.keys.size()) << table.path;
    for (const std::string_view key : table.keys) {
      EXPECT_TRUE(form->second.keys.contains(key)) << table.path << "." << key;
    }
  }
}

TEST_F(SceneSchemaTest, AnIndependentValidatorAcceptsTheShippedScenes) {
  std::vector<fs::path> scenes;
  for (const fs::path& folder : {kScenes, kScenes / "cases"}) {
    for (const auto& entry : fs::directory_iterator(folder)) {
      if (entry.path().extension() == ".toml") scenes.push_back(entry.path());
    }
  }
  ASSERT_GE(scenes.size(), 17u);
  const std::string verdicts = Validate(scenes);
  EXPECT_EQ(Count(verdicts, ": accepted\n"), static_cast<int>(scenes.size())) << verdicts;
}

TEST_F(SceneSchemaTest, ItRefusesWhatTheLoaderRefuses) {
  struct Mistake {
    std::string text, place;
  };
  const std::vector<Mistake> mistakes = {
      {"", "scene: 'organ' is a required property"},
      {"organs = 1\n" + kOrgan, "scene: Additional properties are not allowed ('organs'"},
      {kOrgan + "[organ.lattice]\nmarign=0.01\n", "organ.0.lattice: Additional properties"},
      {kOrgan + "mesh2='m.obj'\n", "organ.0: Additional properties"},
      {"[[organ]]\nname='a'\n", "organ.0: 'mesh' is a required property"},
      {kOrgan + "subdivisions='2'\n", "organ.0.subdivisions: '2' is not of type 'integer'"},
      {kOrgan + "subdivisions=6\n", "organ.0.subdivisions: 6 is greater than the maximum of 5"},
      {kOrgan + "model='jelly'\n", "organ.0.model: 'jelly' is not one of"},
      {kOrgan + "unit='inch'\n", "organ.0.unit: 'inch' is not valid under any of"},
      {kOrgan + "[organ.pose]\nposition=[0, 0]\n", "organ.0.pose.position: [0, 0] is too short"},
      {kOrgan + "[organ.pose]\nposition=[0, 0, 50]\n", "organ.0.pose.position.2: 50 is greater"},
      {kOrgan + "[organ.lattice]\ncells=[4, 4, 4.5]\n", "organ.0.lattice.cells: [4, 4, 4.5] is"},
      {kOrgan + "[organ.material]\npoisson=0.5\n", "organ.0.material.poisson: 0.5 is greater"},
      {kOrgan + "[organ.material]\nyoung=0\n", "organ.0.material.young: 0 is less than or equal"},
      {kOrgan + "[[organ.region]]\nbox={min=[0, 0, 0]}\nyoung=1\n", "organ.0.region.0.box: 'max'"},
      {kOrgan + kInstrument + "[instrument.jaws]\nmeshes=[]\npivot=0\nopening_deg=1\n",
       "instrument.0.jaws.meshes: [] "},
      {kOrgan + kInstrument + "[instrument.device]\npassivity_control=1\n",
       "instrument.0.device.passivity_control: 1 is not of type 'boolean'"},
      {kOrgan + "[laparoscope]\nfocal_length=0.004\nfield_of_view_deg=60\n", "laparoscope: "},
      {kOrgan + "[[scene]]\nname='a'\n", "scene: [{'name': 'a'}] is not of type 'object'"},
      {"[organ]\nname='a'\nmesh='m.obj'\n", "organ: "},
      {kOrgan + "[laparoscope]\nangle_deg=15\n", "laparoscope.angle_deg: 15 is not one of"},
      {kOrgan + "[scene]\ngravity=[0, 0, -981]\n", "scene.gravity.2: -981 is less than"},
      {kOrgan + "[organ.material]\nrelaxation_time=0.1\n",
       "organ.0.material.relaxation_time: 0.1 is not one of"},
      {kOrgan + "[[organ.material.prony]]\nshare=0.95\ntime=1\n",
       "organ.0.material.prony.0.share: 0.95 is greater than"},
      {kOrgan + "[[organ.support]]\nbox={min=[0, 0, 0], max=[1, 1, 1]}\nfixed=false\n",
       "organ.0.support.0.fixed: False is not one of"},
      {kOrgan + kInstrument + kInstrument + kInstrument + kInstrument + kInstrument,
       "instrument: "},
  };
  std::vector<fs::path> files;
  for (std::size_t i = 0; i < mistakes.size(); ++i) {
    files.push_back(folder_.Write("mistake_" + std::to_string(i) + ".toml", mistakes[i].text));
  }
  const std::string verdicts = Validate(files);
  for (std::size_t i = 0; i < mistakes.size(); ++i) {
    EXPECT_TRUE(
        Contains(verdicts, files[i].filename().string() + ": refused at " + mistakes[i].place));
    EXPECT_NE(ErrorOf([&] { LoadScene(files[i]); }), "") << mistakes[i].text;
  }
}

}  // namespace
}  // namespace hpdm
