#include <algorithm>
#include <span>

#include "tests/support/scene_fixture.h"

namespace hpdm {
namespace {

/// A faulty scene and parts of its message.
struct BadScene {
  const char* text;     // after kOrgan, which takes lines 1 to 3
  const char* place;    // LINE:COLUMN
  const char* subject;  // key.path
  const char* problem;
  const char* remedy;
};

class SceneFaults : public SceneTest {
 protected:
  void ExpectFaults(std::span<const BadScene> cases) const {
    for (const BadScene& c : cases) {
      SCOPED_TRACE(std::string("scene:\n") + c.text);
      const std::string error = ReadError(kOrgan + c.text + "\n");
      EXPECT_TRUE(StartsWith(error, std::string("s.toml:") + c.place + ": "));
      EXPECT_TRUE(Contains(error, std::string(": ") + c.subject + ": "));
      EXPECT_TRUE(Contains(error, c.problem));
      EXPECT_TRUE(Contains(error.substr(std::min(error.size(), error.find("; "))), c.remedy));
    }
  }
};

TEST_F(SceneFaults, MessageNamesFileLineColumnKeyValueAndRemedy) {
  EXPECT_EQ(LoadError(kOrgan + "\n  [organ.material]\n  young = -5\n"),
            "s.toml:6:11: organ[0].material.young: is out of range (-5); give a number above 0 and "
            "at most 1e+12, in Pa");
}

TEST_F(SceneFaults, SyntaxErrorsCarryTheParsersPlace) {
  EXPECT_TRUE(StartsWith(LoadError("[scene]\nname = \n"), "s.toml:2:"));
  EXPECT_TRUE(Contains(LoadError("[scene\n"), "TOML syntax: "));
  EXPECT_TRUE(StartsWith(LoadError(kOrgan + "name='again'\n"), "s.toml:4:"));
  EXPECT_TRUE(Contains(LoadError("a = \"\xff\xfe\"\n"), "s.toml:1:"));
}

TEST_F(SceneFaults, UnknownKeysNameTheNearestKnownOne) {
  const BadScene cases[] = {
      {"untt='mm'", "4:1", "organ[0].untt", "is not a known key", "did you mean unit?"},
      {"zzz=1", "4:1", "organ[0].zzz", "is not a known key",
       "known keys: name, mesh, unit, model, texture, pose, motion, lattice, energy, material, "
       "region"},
      {"[laproscope]", "4:2", "laproscope", "is not a known key", "did you mean laparoscope?"},
      {"pose.rotation=[0,0,0]", "4:6", "organ[0].pose.rotation", "is not a known key",
       "did you mean rotation_deg?"},
      {"'a\\b'=1", "4:1", "organ[0].a\\b", "is not a known key", "known keys:"},
      {"\"a\\nb\"=1", "4:1", "organ[0].a\\nb", "is not a known key", "known keys:"},
  };
  ExpectFaults(cases);
}

TEST_F(SceneFaults, WrongTypesAndLengthsNameTheRightOnes) {
  const BadScene cases[] = {
      {"texture=3", "4:9", "organ[0].texture", "is an integer (3)", "give a string in quotes"},
      {"unit=true", "4:6", "organ[0].unit", "is a boolean (true)", "give a number"},
      {"unit=1979-05-27", "4:6", "organ[0].unit", "is a date", "give a number"},
      {"lattice.margin='2'", "4:16", "organ[0].lattice.margin", "is a string (\"2\")", "in m"},
      {"lattice.degree=2.0", "4:16", "organ[0].lattice.degree", "is a number (2.0)", "integer"},
      {"lattice.cells=[4,-4.0,4]", "4:18", "organ[0].lattice.cells", "is a number (-4.0)",
       "an integer from 1 to 64"},
      {"lattice.degree=4e10", "4:16", "organ[0].lattice.degree", "is a number (4e+10)", "integer"},
      {"lattice=4", "4:9", "organ[0].lattice", "is an integer (4)", "one table"},
      {"[organ.support]\nfixed=true", "4:1", "organ[0].support", "is a table", "[[...]]"},
      {"support=[1]", "4:10", "organ[0].support", "is an integer (1)", "[[...]]"},
      {"pose.position=[1,2]", "4:15", "organ[0].pose.position", "has 2 elements ([1, 2])",
       "give three numbers, [x, y, z]"},
      {"pose.position=1", "4:15", "organ[0].pose.position", "is an integer (1)", "three numbers"},
      {"pose.position=[1,'a',2]", "4:18", "organ[0].pose.position", "is a string", "a number"},
      {"lattice.cells=[4,4]", "4:15", "organ[0].lattice.cells", "has 2 elements", "three"},
  };
  ExpectFaults(cases);
}

TEST_F(SceneFaults, ValuesOutOfRangeNameTheRange) {
  const BadScene cases[] = {
      {"unit=nan", "4:6", "organ[0].unit", "is not finite (nan)", "above 0"},
      {"pose.position=[0,inf,0]", "4:18", "organ[0].pose.position", "is not finite (inf)", "in m"},
      {"unit=0", "4:6", "organ[0].unit", "is out of range (0)", "above 0"},
      {"unit='cm'", "4:6", "organ[0].unit", "is not a known value (\"cm\")", "\"m\", \"mm\" or"},
      {"pose.position=[0,0,150]", "4:20", "organ[0].pose.position", "out of range (150)", "in m"},
      {"lattice.margin=-0.1", "4:16", "organ[0].lattice.margin", "out of range (-0.1)", "in m"},
      {"lattice.degree=0", "4:16", "organ[0].lattice.degree", "out of range (0)", "from 1 to 3"},
      {"lattice.degree=[2,4,2]", "4:19", "organ[0].lattice.degree", "range (4)", "from 1 to 3"},
      {"lattice.cells=[0,4,4]", "4:16", "organ[0].lattice.cells", "range (0)", "from 1 to 64"},
      {"lattice.cells=[4,4,65]", "4:20", "organ[0].lattice.cells", "range (65)", "from 1 to 64"},
      {"lattice={basis='bernstein',degree=0}", "4:35", "organ[0].lattice.degree", "range (0)",
       "from 1 to 30"},
      {"lattice={basis='bernstein',cells=[4,4,4]}", "4:34", "organ[0].lattice.cells",
       "needs basis = \"bspline\" ([4, 4, 4])", "remove it"},
      {"lattice.basis='nurbs'", "4:15", "organ[0].lattice.basis", "(\"nurbs\")",
       "give one of \"bspline\", \"bernstein\""},
      {"energy={type='metric',alpha=0}", "4:29", "organ[0].energy.alpha", "out of range (0)",
       "above 0"},
      {"energy={type='metric',alpha=-1}", "4:29", "organ[0].energy.alpha", "out of range (-1)",
       "in Pa"},
      {"energy.alpha=1", "4:14", "organ[0].energy.alpha", "needs type = \"metric\" (1)",
       "remove it or give that type"},
      {"energy={type='metric'}\nlattice.local_functions=5", "5:25",
       "organ[0].lattice.local_functions", "needs energy.type = \"strain\" (5)", "give 0"},
      {"energy={solver='gauss_seidel'}\nlattice.local_functions=5", "5:25",
       "organ[0].lattice.local_functions", "needs energy.solver = \"cholesky\" (5)", "give 0"},
      {"lattice={cells=17,local_refinement=6}", "4:36", "organ[0].lattice.local_refinement",
       "makes more than a million cells (6)", "local_functions = 0"},
      {"lattice.adaptive_functions=-1", "4:28", "organ[0].lattice.adaptive_functions",
       "out of range (-1)", "from 0 to 2000"},
      {"lattice.adaptive_functions=2001", "4:28", "organ[0].lattice.adaptive_functions",
       "out of range (2001)", "from 0 to 2000"},
      {"lattice.adaptive_functions=nan", "4:28", "organ[0].lattice.adaptive_functions", "nan",
       "integer"},
      {"lattice={adaptive_functions=300,adaptive_levels=4}", "4:49",
       "organ[0].lattice.adaptive_levels", "out of range (4)", "from 1 to 2"},
      {"lattice={cells=17,adaptive_functions=300,adaptive_levels=2}", "4:58",
       "organ[0].lattice.adaptive_levels", "makes more than 262,144 cells",
       "fewer cells or levels"},
      {"lattice={basis='bernstein',adaptive_functions=300}", "4:47",
       "organ[0].lattice.adaptive_functions", "needs basis = \"bspline\" (300)", "give 0"},
      {"energy={type='metric'}\nlattice.adaptive_functions=300", "5:28",
       "organ[0].lattice.adaptive_functions", "needs energy.type = \"strain\" (300)", "give 0"},
      {"energy={solver='gauss_seidel'}\nlattice.adaptive_functions=300", "5:28",
       "organ[0].lattice.adaptive_functions", "needs energy.solver = \"cholesky\" (300)", "give 0"},
      {"energy={strain='finite',newton_iterations=0}", "4:43", "organ[0].energy.newton_iterations",
       "out of range (0)", "from 1 to 1000"},
      {"energy={strain='finite',newton_budget=-1}", "4:39", "organ[0].energy.newton_budget",
       "out of range (-1)", "in s"},
      {"energy={newton_budget=0.01}", "4:23", "organ[0].energy.newton_budget",
       "needs strain = \"finite\"", "remove it"},
      {"material.poisson=0.5", "4:18", "organ[0].material.poisson", "out of range (0.5)",
       "give a number at least 0 and below 0.5"},
      {"material.poisson=-0.1", "4:18", "organ[0].material.poisson", "(-0.1)", "below 0.5"},
      {"material.density=0", "4:18", "organ[0].material.density", "(0)", "in kg/m^3"},
  };
  ExpectFaults(cases);
}

TEST_F(SceneFaults, FaultyRegionsAreNamed) {
  const BadScene cases[] = {
      {"[[organ.region]]\nyoung=1", "4:1", "organ[0].region[0]", "has no region", "sphere"},
      {"[[organ.region]]\nsphere={centre=[0,0,0],radius=1}", "4:1", "organ[0].region[0].young",
       "is missing", "in Pa"},
      {"[[organ.region]]\nyoung=0\nsphere={centre=[0,0,0],radius=1}", "5:7",
       "organ[0].region[0].young", "out of range (0)", "above 0"},
      {"[[organ.region]]\nyoung=-nan\nsphere={centre=[0,0,0],radius=1}", "5:7",
       "organ[0].region[0].young", "is not finite", "above 0"},
      {"model='continuum'\n[[organ.region]]\nyoung=1", "5:1", "organ[0].region",
       "needs model = \"hpdm\"", "change the model"},
  };
  ExpectFaults(cases);
}

TEST_F(SceneFaults, FaultySupportsAreNamed) {
  const BadScene cases[] = {
      {"[[organ.support]]\nfixed=true", "4:1", "organ[0].support[0]", "has no region",
       "give box, box_fraction or sphere"},
      {"[[organ.support]]\nsphere={centre=[0,0,0],radius=1}", "4:1", "organ[0].support[0]",
       "has neither fixed nor stiffness", "fixed = true or stiffness"},
      {"[[organ.support]]\nfixed=true\nstiffness=1\nsphere={centre=[0,0,0],radius=1}", "6:11",
       "organ[0].support[0].stiffness", "combined with fixed (1)", "keep one"},
      {"[[organ.support]]\nfixed=false\nsphere={centre=[0,0,0],radius=1}", "5:7",
       "organ[0].support[0].fixed", "without effect (false)", "stiffness"},
      {"[[organ.support]]\nfixed=true\nsphere={centre=[0,0,0],radius=0}", "6:31",
       "organ[0].support[0].sphere.radius", "out of range (0)", "above 0"},
      {"[[organ.support]]\nfixed=true\nsphere={centre=[0,0,0]}", "6:8",
       "organ[0].support[0].sphere.radius", "is missing", "give it in m"},
      {"[[organ.support]]\nbox={min=[0,0,1],max=[1,1,0]}", "5:22", "organ[0].support[0].box.max",
       "not above min in every coordinate ([1, 1, 0])", "a volume"},
      {"[[organ.support]]\nbox_fraction={min=[0,0,0],max=[1,1,2]}", "5:36",
       "organ[0].support[0].box_fraction.max", "out of range (2)", "at most 1"},
      {"[[organ.support]]\nbox={min=[0,0,0],max=[1,1,1]}\nsphere={}", "6:8",
       "organ[0].support[0].sphere", "combined with box", "keep one"},
  };
  ExpectFaults(cases);
}

TEST_F(SceneFaults, FaultyNamesAndFilesAreNamed) {
  const BadScene cases[] = {
      {"[[organ]]\nname='liver'\nmesh='m.obj'", "5:6", "organ[1].name",
       "is already used (\"liver\")", "its own name"},
      {"[[organ]]\nmesh='m.obj'", "4:1", "organ[1].name", "is missing", "name the organ"},
      {"[[organ]]\nname='b'", "4:1", "organ[1].mesh", "is missing", "OBJ, STL or PLY"},
      {"[[organ]]\nname=' '\nmesh='m.obj'", "5:6", "organ[1].name", "is not a name", "64"},
      {"[[organ]]\nname='b'\nmesh='no.obj'", "6:6", "organ[1].mesh",
       "there is no such file (\"no.obj\")", "leads to \"no.obj\""},
      {"[[organ]]\nname='b'\nmesh='meshes'", "6:6", "organ[1].mesh", "not a regular file",
       "folder"},
      {"[[organ]]\nname='b'\nmesh=\"m.obj\\u0000\"", "6:6", "organ[1].mesh", "control character",
       "remove it"},
  };
  ExpectFaults(cases);
}

TEST_F(SceneFaults, FaultyInstrumentsAreNamed) {
  const BadScene cases[] = {
      {"[[instrument]]\nname='p'", "4:1", "instrument[0].trocar", "is missing", "in m"},
      {"[[instrument]]\nname='p'\ntrocar=[50,-120,160]", "6:9", "instrument[0].trocar", "(50)",
       "at most 10, in m"},
      {"[[instrument]]\nname='p'\ntrocar=[0,0,0]\n[[instrument]]\nname='p'\ntrocar=[0,0,0]", "8:6",
       "instrument[1].name", "is already used", "its own name"},
      {"[[instrument]]\nname='p'\ntrocar=[0,0,0]\n[[instrument]]\nname='q'\ntrocar=[0,0,0]\n"
       "[[instrument]]\nname='r'\ntrocar=[0,0,0]\n[[instrument]]\nname='s'\ntrocar=[0,0,0]\n"
       "[[instrument]]\nname='t'\ntrocar=[0,0,0]",
       "16:1", "instrument[4]", "is one too many", "at most 4"},
      {"[[instrument]]\nname='p'\ntrocar=[0,0,0]\ntip_radius=0", "7:12", "instrument[0].tip_radius",
       "out of range (0)", "above 0"},
      {"[[instrument]]\nname='p'\ntrocar=[0,0,0]\n[instrument.device]\nmin_insertion=0.5", "8:15",
       "instrument[0].device.min_insertion", "leaves no travel", "above min_insertion"},
      {"[[instrument]]\nname='p'\ntrocar=[0,0,0]\n[instrument.device]\npassivity_control='on'",
       "8:19", "instrument[0].device.passivity_control", "is a string (\"on\")", "true or false"},
      {"[[instrument]]\nname='p'\ntrocar=[0,0,0]\ndevice.profile='omega'", "7:16",
       "instrument[0].device.profile", "(\"omega\")", "\"impulse_engine\""},
      {"[[instrument]]\nname='p'\ntrocar=[0,0,0]\nhand.organ='lung'", "7:12",
       "instrument[0].hand.organ", "(\"lung\")", "the scene's organs are \"liver\""},
      {"[[instrument]]\nname='p'\ntrocar=[0,0,0]\nhand.script='grasp_lift'", "7:13",
       "instrument[0].hand.script", "needs an instrument that holds tissue", "type = \"grasper\""},
  };
  ExpectFaults(cases);
}

TEST_F(SceneFaults, FaultyJawsAndExchangesAreNamed) {
  const BadScene cases[] = {
      {"[[instrument]]\nname='p'\ntrocar=[0,0,0]\njaws={meshes=['m.obj']}", "7:6",
       "instrument[0].jaws", "needs mesh", "give mesh"},
      {"[[instrument]]\nname='p'\ntrocar=[0,0,0]\nmesh='m.obj'\njaws.meshes=['m.obj','n.obj']",
       "8:1", "instrument[0].jaws.pivot", "is missing", "a pivot in m"},
      {"[[instrument]]\nname='p'\ntrocar=[0,0,0]\nmesh='m.obj'\n"
       "jaws={meshes=['m.obj','n.obj'],pivot=0,opening_deg=9}",
       "8:14", "instrument[0].jaws.meshes", "there is no such file", "n.obj"},
      {"[[instrument]]\nname='p'\ntrocar=[0,0,0]\nmesh='m.obj'\n"
       "jaws={meshes=['m.obj','m.obj','m.obj'],pivot=0,opening_deg=9}",
       "8:14", "instrument[0].jaws.meshes", "has 3 values", "1 to 2 file names"},
      {"[[instrument]]\nname='p'\ntrocar=[0,0,0]\nmesh='m.obj'\n"
       "jaws={meshes='m.obj',pivot=0,opening_deg=9}",
       "8:14", "instrument[0].jaws.meshes", "is a string (\"m.obj\")", "an array of 1 to 2"},
      {"[[instrument]]\nname='p'\ntrocar=[0,0,0]\n[[instrument.exchange]]\nname='p'", "8:6",
       "instrument[0].exchange[0].name", "is already used", "its own name"},
      {"[[instrument]]\nname='p'\ntrocar=[0,0,0]\n[[instrument.exchange]]\ntype='hook'", "7:1",
       "instrument[0].exchange[0].name", "is missing", "name the instrument"},
      {"[[instrument]]\nname='p'\ntrocar=[0,0,0]\nexchange=[{name='1'},{name='2'},{name='3'},"
       "{name='4'},{name='5'},{name='6'},{name='7'},{name='8'}]",
       "7:88", "instrument[0].exchange[7]", "is one too many", "at most 7"},
  };
  ExpectFaults(cases);
}

TEST_F(SceneFaults, FaultyHandsAndTracesAreNamed) {
  const BadScene cases[] = {
      {"[[instrument]]\nname='p'\ntrocar=[0,0,0]\nhand.seed=-1", "7:11", "instrument[0].hand.seed",
       "out of range (-1)", "from 0 to 4294967295"},
      {"[[instrument]]\nname='p'\ntrocar=[0,0,0]\ntrace.file='no.csv'", "7:12",
       "instrument[0].trace.file", "there is no such file (\"no.csv\")", "scene's folder"},
      {"[[instrument]]\nname='p'\ntrocar=[0,0,0]\ntrace.speed=0", "7:13",
       "instrument[0].trace.speed", "out of range (0)", "at least 0.01 and at most 100"},
      {"[[instrument]]\nname='p'\ntrocar=[0,0,0]\ntrace.scale=-1", "7:13",
       "instrument[0].trace.scale", "out of range (-1)", "above 0"},
  };
  ExpectFaults(cases);
}

TEST_F(SceneFaults, FaultyTimingIsNamed) {
  const BadScene cases[] = {
      {"[timing]\nhaptic_hz=0", "5:11", "timing.haptic_hz", "out of range (0)", "from 100"},
      {"[timing]\npatch_delay_ticks=0", "5:19", "timing.patch_delay_ticks", "(0)", "from 1"},
      {"[timing]\nrender_hz=1000", "5:11", "timing.render_hz", "(1000)", "to 240"},
      {"[timing]\nhaptic_hz=100\ndeformation_hz=200", "6:16", "timing.deformation_hz",
       "is above haptic_hz = 100 (200)", "at most haptic_hz"},
      {"[timing]\nhaptic_hz=9223372036854775807", "5:11", "timing.haptic_hz", "out of range",
       "to 10000"},
  };
  ExpectFaults(cases);
}

TEST_F(SceneFaults, FaultyLaparoscopesAreNamed) {
  const BadScene cases[] = {
      {"[laparoscope]\nangle_deg=20", "5:11", "laparoscope.angle_deg", "(20)", "0, 30 or 45"},
      {"[laparoscope]\nfocal_length=0.003\nfield_of_view_deg=70", "5:14",
       "laparoscope.focal_length", "combined with field_of_view_deg", "keep one"},
      {"[laparoscope]\nfield_of_view_deg=180", "5:19", "laparoscope.field_of_view_deg", "(180)",
       "at most 120"},
      {"[laparoscope]\ntrocar=[0,-0.25,0.12]", "5:8", "laparoscope.trocar", "within 2 mm",
       "farther"},
      {"[laparoscope]\ndistortion=-0.5", "5:12", "laparoscope.distortion", "(-0.5)", "0.3"},
      {"[laparoscope]\nposition=[0,0,0]", "4:1", "laparoscope.target", "within 2 mm", "farther"},
  };
  ExpectFaults(cases);
}

TEST_F(SceneFaults, ASceneWithoutAnOrganIsRefused) {
  EXPECT_EQ(ReadError(""), "s.toml:1:1: organ: is missing; add at least one [[organ]] table");
}

TEST_F(SceneFaults, FaultyLoadsAreNamed) {
  const auto error = [&](const std::string& load) { return ReadError(kOrgan + load); };
  EXPECT_TRUE(Contains(error("[[load]]\norgan='lung'\n"),
                       "s.toml:5:7: load[0].organ: is not the name of an organ (\"lung\"); the "
                       "scene's organs are \"liver\""));
  const std::string load = "[[load]]\norgan='liver'\npoint=[0,0,0]\nradius=0.01\n";
  EXPECT_TRUE(Contains(error(load), "s.toml:4:1: load[0]: has no load; give force or"));
  EXPECT_TRUE(Contains(error(load + "force=[0,0,1]\ndisplacement=[0,0,1]\n"),
                       "load[0].displacement: cannot be combined with force"));
  EXPECT_TRUE(
      Contains(error(load + "pressure=10\n"), "load[0].pressure: cannot be combined with point"));
  EXPECT_TRUE(Contains(error(load + "force=[0,0,1]\nsphere={centre=[0,0,0],radius=1}\n"),
                       "load[0].sphere: needs pressure (a table); remove it or give pressure"));
  EXPECT_TRUE(
      Contains(error("[[load]]\norgan='liver'\npressure=1\nbox={min=[0,0,1],max=[1,1,0]}\n"),
               "load[0].box.max: is not above min in every coordinate"));
  EXPECT_TRUE(Contains(error("[[load]]\norgan='liver'\npressure=2e9\n"),
                       "load[0].pressure: is out of range (2e+09)"));
}

TEST_F(SceneFaults, SurfaceModelsTakeNoLatticeEnergyOrPronyTerms) {
  for (const std::string model : {"continuum", "mass_spring"}) {
    const std::string organ = kOrgan + "model='" + model + "'\n";
    for (const std::string table : {"lattice", "energy"}) {
      EXPECT_TRUE(Contains(ReadError(organ + "[organ." + table + "]\n"),
                           "organ[0]." + table + ": needs model = \"hpdm\""));
    }
    EXPECT_TRUE(Contains(ReadError(organ + "[[organ.material.prony]]\nshare=0.5\ntime=1\n"),
                         "organ[0].material.prony: needs model = \"hpdm\""));
    const Scene scene = Load("[timing]\ndeformation_hz=50\n" + organ);
    EXPECT_NE(scene.organs[0].model, OrganModelType::kHpdm);
    EXPECT_EQ(scene.organs[0].time_step, 1.0 / 50);
  }
}

TEST_F(SceneFaults, RigidOrgansTakeNoLatticeEnergyMaterialOrSupport) {
  const std::string organ = kOrgan + "model='rigid'\n";
  for (const std::string table : {"lattice", "energy"}) {
    EXPECT_TRUE(Contains(ReadError(organ + "[organ." + table + "]\n"),
                         "organ[0]." + table + ": needs model = \"hpdm\""));
  }
  for (const std::string table : {"[organ.material]", "[[organ.support]]"}) {
    const std::string error = ReadError(organ + table + "\n");
    EXPECT_TRUE(Contains(error, "does not apply to model = \"rigid\"")) << error;
  }
  EXPECT_TRUE(Contains(ReadError(kOrgan + "wall_stiffness=200\n"),
                       "organ[0].wall_stiffness: needs model = \"rigid\""));
  EXPECT_TRUE(Contains(ReadError(organ + "wall_stiffness=0\n"), "is out of range"));
  EXPECT_EQ(Load(organ + "wall_stiffness=200\n").organs[0].wall_stiffness, 200);
  EXPECT_FALSE(Load(organ).organs[0].wall_stiffness);
}

TEST_F(SceneFaults, AMissingFilesPlaceIsNamedOnce) {
  const auto error = [](const std::string& mesh, const std::string& scene) {
    return ErrorOf([&] { ParseScene("[[organ]]\nname='a'\nmesh='" + mesh + "'\n", scene); });
  };
  EXPECT_EQ(error("no.obj", "s.toml"),
            "s.toml:3:6: organ[0].mesh: there is no such file (\"no.obj\"); paths are relative to "
            "the scene's folder");
  EXPECT_EQ(
      error("no.obj", "a/s.toml"),
      "a/s.toml:3:6: organ[0].mesh: there is no such file (\"no.obj\"); paths are relative to "
      "the scene's folder, this one leads to \"a/no.obj\"");
  EXPECT_EQ(error("/no.obj", "a/s.toml"),
            "a/s.toml:3:6: organ[0].mesh: there is no such file (\"/no.obj\"); check the path");
}

TEST_F(SceneFaults, AFreeOrganTakesNoSupportMotionMemoryOrOtherModel) {
  const std::string free = "free={drag=1}\n";
  for (const std::string other :
       {"support=[{sphere={centre=[0,0,0],radius=1},fixed=true}]", "model='rigid'",
        "model='mass_spring'", "energy={strain='finite'}", "energy={type='metric'}",
        "energy={solver='gauss_seidel'}", "material={prony=[{share=0.5,time=1}]}",
        "motion={displacement=[0,0,0.01],frequency=1}"}) {
    const std::string error = ReadError(kOrgan + other + "\n" + free);
    EXPECT_TRUE(Contains(error, "organ[0].free: does not apply to this organ")) << error;
    EXPECT_TRUE(Contains(error, "without support, motion or prony")) << error;
  }
  EXPECT_TRUE(Contains(ReadError(kOrgan + "free={}\n"), "organ[0].free.drag: is missing"));
  EXPECT_TRUE(Contains(ReadError(kOrgan + "free={drag=-1}\n"), "is out of range (-1)"));
  EXPECT_TRUE(
      Contains(ReadError(kOrgan + "[scene]\ngravity=[0,0,-981]\n"), "is out of range (-981)"));
  const Scene scene = Load(kOrgan + free + "[scene]\ngravity=[0,1,-9.81]\n");
  ASSERT_TRUE(scene.organs[0].free);
  EXPECT_EQ(scene.organs[0].free->drag, 1);
  EXPECT_EQ(scene.organs[0].gravity_W, Vector3d(0, 1, -9.81));
}

TEST_F(SceneFaults, UnsupportedFeaturesAreRefusedNotIgnored) {
  EXPECT_EQ(LoadError(kOrgan + "[organ.material]\nrelaxation_time=0.1\n"),
            "s.toml:5:17: organ[0].material.relaxation_time: was replaced by Prony terms (0.1); "
            "remove the key; [[organ.material.prony]] share = 0.5, time = 0.3 relaxes half of the "
            "force in 0.3 s");
  Load("[scene]\ngravity=[0,0,0]\n" + kOrgan + "material.relaxation_time=0\n");
}

}  // namespace
}  // namespace hpdm
