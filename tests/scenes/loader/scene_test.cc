#include "scenes/loader/scene.h"

#include <clocale>
#include <locale>

#include "tests/support/comma_locale.h"
#include "tests/support/scene_fixture.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

TEST_F(SceneTest, ShippedLiverSceneLoads) {
  const fs::path path = fs::path(HPDM_SOURCE_DIR) / "scenes/liver_palpation.toml";
  const Scene scene = LoadScene(path);
  EXPECT_EQ(scene.name, "liver palpation");
  EXPECT_EQ(scene.source_text, ReadFile(path));
  EXPECT_EQ(scene.path, path);
  ASSERT_EQ(scene.organs.size(), 1u);
  EXPECT_EQ(scene.organs[0].supports.size(), 1u);
  ASSERT_EQ(scene.instruments.size(), 1u);
  EXPECT_EQ(scene.instruments[0].hand.script, HandScript::kPalpate);
}

TEST_F(SceneTest, AnOrgansEnergyIsStrainWithLocalFunctionsUnlessSaidOtherwise) {
  const struct {
    const char* text;
    EnergyType type;
    int local_functions;
  } cases[] = {
      {"", EnergyType::kStrain, 27},
      {"energy.strain='finite'", EnergyType::kStrain, 27},
      {"energy.strain='adaptive'", EnergyType::kStrain, 27},
      {"energy.law='stvk'", EnergyType::kStrain, 27},
      {"lattice.local_refinement=3", EnergyType::kStrain, 27},
      {"lattice.local_functions=0", EnergyType::kStrain, 0},
      {"lattice.local_functions=5", EnergyType::kStrain, 5},
      {"energy.type='metric'", EnergyType::kMetric, 0},
      {"energy.type='metric'\nlattice={cells=30,local_refinement=6}", EnergyType::kMetric, 0},
      {"energy.solver='gauss_seidel'", EnergyType::kStrain, 0},
      {"lattice.basis='bernstein'", EnergyType::kStrain, 0},
      {"lattice.cells=51", EnergyType::kStrain, 0},  // more than a million of half the size
      {"lattice={cells=30,local_refinement=6,local_functions=0}", EnergyType::kStrain, 0},
  };
  for (const auto& [text, type, local_functions] : cases) {
    const OrganOptions organ = Load(kOrgan + text + "\n").organs.at(0);
    EXPECT_EQ(organ.energy.type, type) << text;
    EXPECT_EQ(LocalFunctionsOf(organ), local_functions) << text;
  }
  for (const char* model : {"continuum", "mass_spring", "rigid"}) {
    EXPECT_EQ(LocalFunctionsOf(Load(kOrgan + "model='" + model + "'\n").organs.at(0)), 0) << model;
  }
}

TEST_F(SceneTest, EveryHandScriptIsRead) {
  const std::pair<const char*, HandScript> scripts[] = {
      {"palpate", HandScript::kPalpate},      {"tap", HandScript::kTap},
      {"slide", HandScript::kSlide},          {"grasp_lift", HandScript::kGraspLift},
      {"grasp_pull", HandScript::kGraspPull}, {"random", HandScript::kRandom}};
  for (const auto& [name, script] : scripts) {
    const Scene scene = Load(kOrgan + kInstrument + "type='grasper'\nhand.script='" + name + "'\n");
    EXPECT_EQ(scene.instruments[0].hand.script, script);
  }
}

TEST_F(SceneTest, ATracesPlaceIsFittedUnlessGiven) {
  folder_.Write("r.csv", "");
  const Scene scene = Load(kOrgan + kInstrument +
                           "trace={file='r.csv',scale=0.001,rotation_deg=[0,0,90],"
                           "position=[0.1,0.2,0.3],speed=2}\n" +
                           "[[instrument]]\nname='q'\ntrocar=[0,0,1]\n");
  const TraceOptions& trace = scene.instruments[0].trace;
  EXPECT_EQ(trace.file, (folder_.path() / "r.csv").string());
  EXPECT_EQ(trace.scale, 0.001);
  EXPECT_LT((trace.R_WF * Vector3d::UnitX() - Vector3d::UnitY()).norm(), 1e-15);
  EXPECT_EQ(trace.position, Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(trace.speed, 2);
  EXPECT_EQ(scene.instruments[1].trace.file, "");
  EXPECT_EQ(scene.instruments[1].trace.position, std::nullopt);
}

TEST_F(SceneTest, PatchDelayIsOneStepUnlessGiven) {
  EXPECT_EQ(Load(kOrgan).timing.patch_delay_ticks, 34);
  EXPECT_EQ(Load(kOrgan + "[timing]\n").timing.patch_delay_ticks, 34);
  EXPECT_EQ(Load(kOrgan + "[timing]\ndeformation_hz=100\n").timing.patch_delay_ticks, 10);
  EXPECT_EQ(Load(kOrgan + "[timing]\npatch_delay_ticks=1\n").timing.patch_delay_ticks, 1);
}

TEST_F(SceneTest, FileNamesAreRelativeToTheScenesFolder) {
  const std::string scene = "[[organ]]\nname='liver'\nmesh='meshes/../m.obj'\n";
  EXPECT_EQ(Load(scene).organs[0].mesh, (folder_.path() / "m.obj").string());

  const fs::path here = fs::current_path();
  fs::current_path(folder_.path() / "meshes");
  folder_.Write("s.toml", scene);
  EXPECT_EQ(LoadScene("../s.toml").organs[0].mesh, "../m.obj");
  fs::current_path(here);

  const std::string absolute = (folder_.path() / "t.png").string();
  EXPECT_EQ(Load("[[organ]]\nname='liver'\nmesh='" + absolute + "'\n").organs[0].mesh, absolute);
}

class CommaNumbers : public std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

TEST_F(SceneTest, ADecimalCommaOfStreamsChangesNoNumber) {
  const std::locale before = std::locale::global(std::locale(std::locale(), new CommaNumbers));
  const Scene scene = Load(kOrgan + "unit=0.031\n");
  const std::string error = LoadError(kOrgan + "unit=1234.5\n[timing]\n");
  std::locale::global(before);
  EXPECT_EQ(scene.organs[0].unit_m, 0.031);
  EXPECT_TRUE(Contains(error,
                       "s.toml:4:6: organ[0].unit: is out of range (1234.5); give a "
                       "number above 0 and at most 1000, in metres per unit"));
}

TEST_F(SceneTest, ADecimalCommaOfTheCLibraryChangesNoNumber) {
  if (!MakeCommaLocale(folder_.path())) GTEST_SKIP() << "no locale can be made; install locales";
  setenv("LOCPATH", folder_.path().c_str(), 1);
  ASSERT_NE(std::setlocale(LC_ALL, kCommaLocale), nullptr);
  ASSERT_STREQ(std::localeconv()->decimal_point, ",");
  const double unit_m = Load(kOrgan + "unit=0.031\n").organs[0].unit_m;
  std::setlocale(LC_ALL, "C");
  unsetenv("LOCPATH");
  EXPECT_EQ(unit_m, 0.031);
}

}  // namespace
}  // namespace hpdm
