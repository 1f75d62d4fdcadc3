// Bad scene files as a user would give them to the program: tests/bad_input/scenes.csv.

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <fstream>

#include "tests/bad_input/bad_input.h"
#include "tests/bad_input/sound_scene.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

const std::string kMegabyte(1 << 20, ' ');

std::string Repeated(const std::string& text, std::size_t count) {
  std::string all;
  all.reserve(text.size() * count);
  for (std::size_t i = 0; i < count; ++i) all += text;
  return all;
}

/// Returns the parts of a text between "; ".
std::vector<std::string> Separate(const std::string& text) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0, end = 0; end != std::string::npos; begin = end + 2) {
    end = text.find("; ", begin);
    parts.push_back(text.substr(begin, end - begin));
  }
  return parts;
}

class Scenes : public BadInputs {
 public:
  Scenes() : BadInputs("scenes", WriteBox) {}

  using BadInputs::Add;
  /// Checks a text.
  void Text(const std::string& name, const std::string& text) {
    Add(name, {"check", "s.toml"}, WithFile("s.toml", text));
  }
  /// Checks the sound scene with another line in one of its tables.
  void Organ(const std::string& line) {
    Text("organ: " + line, SoundScene({.organ = line + "\n"}));
  }
  void Lattice(const std::string& line) {
    Text("lattice: " + line, SoundScene({.lattice = line + "\n"}));
  }
  void Material(const std::string& line) {
    Text("material: " + line, SoundScene({.material = line + "\n"}));
  }
  void Instrument(const std::string& line) {
    Text("instrument: " + line, SoundScene({.instrument = line + "\n"}));
  }
  /// Checks the sound scene with another table at its end.
  void Table(const std::string& name, const std::string& table) {
    Text(name, SoundScene({}) + table + "\n");
  }
  void Timing(const std::string& line) { Table("timing: " + line, "[timing]\n" + line); }
  /// Checks a path that `make` fills.
  void Place(const std::string& name, const Make& make) { Add(name, {"check", "s.toml"}, make); }
  void Solved(const std::string& name, const std::string& load) {
    Add(name, {"solve", "s.toml", "--out", "f.csv"},
        WithFile("s.toml", SoundScene({}) + "[[load]]\n" + load + "\n"));
  }
  void Run(const std::string& name, const std::string& text) {
    Add(name,
        {"run", "s.toml", "--clock", "lockstep", "--seconds", "0.1", "--no-pictures", "--verbose",
         "--out", "o"},
        WithFile("s.toml", text));
  }
};

void AddTexts(Scenes* s) {
  const std::string sound = SoundScene({});
  std::string crlf;
  for (const char c : sound) crlf += c == '\n' ? "\r\n" : std::string(1, c);
  std::string cr = sound;
  std::replace(cr.begin(), cr.end(), '\n', '\r');
  std::string utf16 = "\xff\xfe";
  for (const char c : sound) utf16 += {c, '\0'};
  s->Text("sound", sound);
  s->Text("empty", "");
  s->Text("a comment alone", "# nothing");
  s->Text("byte order mark", "\xef\xbb\xbf" + sound);
  s->Text("byte order mark alone", "\xef\xbb\xbf");
  s->Text("CRLF line ends", crlf);
  s->Text("CR line ends", cr);
  s->Text("UTF-16", utf16);
  s->Text("Latin-1", SoundScene({.name = "f\xfcr"}));
  s->Text("overlong UTF-8", SoundScene({.name = "\xc0\xaf"}));
  s->Text("UTF-8 of half a surrogate pair", SoundScene({.name = "\xed\xa0\x80"}));
  s->Text("a NUL byte", SoundScene({.name = std::string("a\0b", 3)}));
  s->Text("a name in another script", SoundScene({.name = "\xe8\x82\x9d"}));
  s->Text("a name of 65 bytes", SoundScene({.name = std::string(65, 'n')}));
  s->Text("a name of a megabyte", SoundScene({.name = std::string(1 << 20, 'n')}));
  const std::string after_name = sound.substr(sound.find("mesh="));
  s->Text("a name with a line break", "[[organ]]\nname=\"a\\nb\"\n" + after_name);
  s->Text("a name with a terminal's escape", "[[organ]]\nname=\"\\u001b[2J\"\n" + after_name);
}

void AddLargeTexts(Scenes* s) {
  s->Text("10 MB of garbage", Garbage(10'000'000));
  s->Text("a megabyte of garbage", Garbage(1'000'000));
  s->Text("a megabyte of spaces", kMegabyte);
  s->Text("a megabyte of comment", Repeated("# ", 1 << 19));
  s->Text("a megabyte of brackets", Repeated("[", 1 << 20));
  s->Text("arrays nested 100,000 deep", "a=" + Repeated("[", 100'000) + Repeated("]", 100'000));
  s->Text("inline tables nested 10,000 deep",
          "a=" + Repeated("{a=", 10'000) + "1" + Repeated("}", 10'000));
  s->Text("a key of 100,000 parts", Repeated("a.", 100'000) + "a=1");
  s->Text("a table of 10,000 parts", std::string("[") + Repeated("a.", 10'000) + "a]");
  s->Text("an unknown key of a megabyte", std::string((1 << 20) - 2, 'k') + "=1");
  s->Text("100,000 unknown keys", [] {
    std::string text;
    for (int i = 0; i < 100'000; ++i) text.append("k").append(std::to_string(i)).append("=1\n");
    return text;
  }());
  s->Text("an array of 500,000 numbers", "a=[" + Repeated("1,", 500'000) + "]");
  s->Text("100,000 organs", Repeated("[[organ]]\n", 100'000));
  s->Text("a million organs", Repeated("[[organ]]\n", 1'000'000));
  s->Text("one organ too many", [] {
    std::string text;
    for (int i = 0; i < 65; ++i) {
      text.append("[[organ]]\nmesh='../common/box.obj'\nname='")
          .append(std::to_string(i))
          .append("'\n");
    }
    return text;
  }());
}

void AddBrokenTexts(Scenes* s) {
  const std::string sound = SoundScene({});
  s->Text("a string without an end", "[scene]\nname = \"x\n");
  s->Text("a table without an end", "[scene\nname = 'x'\n");
  s->Text("a value without a key", "= 3\n");
  s->Text("half of a scene", sound.substr(0, sound.size() / 2));
  s->Text("a mesh instead of a scene", "v 0 0 0\nv 1 0 0\nf 1 2 3\n");
  s->Text("JSON instead of TOML", "{\"organ\": []}");
  s->Text("a key given twice", SoundScene({.organ = "name='again'\n"}));
  s->Text("a table given twice", sound + "[timing]\n[timing]\n");
  s->Text("a table that is a value already", "organ=1\n[[organ]]\n");
  s->Text("no organ", "[scene]\nname='x'\n");
  s->Text("organ = []", "organ=[]\n");
  s->Text("two organs of one name", sound + "[[organ]]\nname='liver'\nmesh='../common/box.obj'\n");
  s->Text("two instruments of one name", sound + "[[instrument]]\nname='probe'\ntrocar=[0,0,1]\n");
  s->Text("five instruments", sound +
                                  "[[instrument]]\nname='b'\ntrocar=[0,0,1]\n"
                                  "[[instrument]]\nname='c'\ntrocar=[0,0,1]\n"
                                  "[[instrument]]\nname='d'\ntrocar=[0,0,1]\n"
                                  "[[instrument]]\nname='e'\ntrocar=[0,0,1]\n");
}

void AddPlaces(Scenes* s) {
  s->Place("missing", {});
  s->Place("a folder", [](const fs::path& here) { fs::create_directory(here / "s.toml"); });
  s->Place("a pipe without a writer",
           [](const fs::path& here) { mkfifo((here / "s.toml").c_str(), 0600); });
  s->Place("a socket", [](const fs::path& here) {
    const int descriptor = socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un name{.sun_family = AF_UNIX, .sun_path = {}};
    (here / "s.toml").string().copy(name.sun_path, sizeof name.sun_path - 1);
    EXPECT_EQ(bind(descriptor, reinterpret_cast<const sockaddr*>(&name), sizeof name), 0);
    close(descriptor);
  });
  s->Place("a link to itself",
           [](const fs::path& here) { fs::create_symlink("s.toml", here / "s.toml"); });
  s->Place("a link to nothing",
           [](const fs::path& here) { fs::create_symlink("no.toml", here / "s.toml"); });
  s->Place("a link to a sound scene", [](const fs::path& here) {
    fs::create_directory(here / "real");
    WithFile("real/s.toml", SoundScene({}))(here);
    fs::create_symlink("real/s.toml", here / "s.toml");
  });
  s->Add("a file that may not be read",
         {.words = {"check", "s.toml"}, .folder = {}, .as_nobody_else = true},
         [](const fs::path& here) {
           WithFile("s.toml", SoundScene({}))(here);
           fs::permissions(here / "s.toml", fs::perms::none);
         });
  for (const std::string device : {"/dev/zero", "/dev/null", "/dev/stdin", "/proc/self/mem"}) {
    s->Add(device, {"check", device});
  }
  s->Add("no name", {"check", ""});
  s->Add("a file name with a line break", {"check", "a\nb.toml"});
  s->Add("a file name with a terminal's escape", {"check", "\x1b[2J.toml"});
  s->Add("a file name that is not UTF-8", {"check", "\xff.toml"});
  s->Add("a file name of 100,000 bytes", {"check", std::string(100'000, 'n')});
}

void AddOrgans(Scenes* s) {
  for (const std::string& line : Separate(
           "untt='mm'; unit='cm'; unit='inch'; unit=0; unit=-1; unit=nan; unit=inf; "
           "unit=1e-300; unit=1e-12; unit=1000; unit=1e9; unit=true; unit=[1]; unit=1979-05-27; "
           "unit=1e999; unit=0,001; unit=1_000_0; unit=9223372036854775808; model='jelly'; "
           "model=3; texture='no.png'; texture='../common'; wall_stiffness=1; "
           "pose.position=[0,0,150]; pose.position=[0,nan,0]; pose.position=[0,0]; "
           "pose.position=[9,9,9]; pose.rotation_deg=[0,0,inf]; pose.rotation_deg=[1e15,0,0]; "
           "pose={}; motion={displacement=[1,0,0],frequency=1}; "
           "motion={displacement=[0,0,0.01],frequency=-1}; "
           "motion={displacement=[0,0,0.01],frequency=0}; "
           "motion={displacement=[0,0,nan],frequency=1}; free={}; free={drag=1}")) {
    s->Organ(line);
  }
  for (const char* mesh : {"", "no.obj", "..", "s.toml", "/dev/zero", "/dev/null", "loop", "pipe",
                           "empty.obj", "garbage.obj", "../common/box.txt"}) {
    s->Add(std::string("organ: mesh='") + mesh + "'", {"check", "s.toml"},
           [mesh](const fs::path& here) {
             WithFile("s.toml", SoundScene({.mesh = mesh}))(here);
             WithFile("empty.obj", "")(here);
             WithFile("garbage.obj", Garbage(100'000))(here);
             fs::create_symlink("loop", here / "loop");
             mkfifo((here / "pipe").c_str(), 0600);
           });
  }
}

void AddLattices(Scenes* s) {
  for (const std::string& line :
       Separate("cells=0; cells=-1; cells=65; cells=1000000; cells=64; cells=[4,4]; cells=4.0; "
                "cells=4.5; cells=nan; cells='4'; degree=0; degree=4; degree=[1,2,3]; "
                "degree=9223372036854775807; basis='nurbs'; margin=-0.1; margin=nan; margin=1; "
                "split=false; split=1; notch_functions=false; notch_functions=1; "
                "local_functions=-1; local_functions=1000000; local_functions=250; "
                "local_refinement=1; local_refinement=100")) {
    s->Lattice(line);
  }
  s->Text("a Bernstein lattice of degree 30",
          SoundScene({.lattice = "basis='bernstein'\ndegree=30", .cells = ""}));
  s->Text("a Bernstein lattice that splits",
          SoundScene({.lattice = "basis='bernstein'\nsplit=true", .cells = ""}));
  s->Text("a Bernstein lattice with notches",
          SoundScene({.lattice = "basis='bernstein'\nnotch_functions=true", .cells = ""}));
  s->Text("a Bernstein lattice with cells", SoundScene({.lattice = "basis='bernstein'"}));
  s->Text("a Bernstein lattice with local functions",
          SoundScene({.lattice = "basis='bernstein'\nlocal_functions=8", .cells = ""}));
}

void AddMaterials(Scenes* s) {
  for (const std::string& line :
       Separate("young=-5000; young=0; young=nan; young=inf; young=1e-300; young=1e-6; young=1e12; "
                "young=1e13; young='soft'; poisson=0.5; poisson=0.4999999999999999; poisson=-0.1; "
                "poisson=1; poisson=nan; density=0; density=-1; density=inf; density=1e-300; "
                "relaxation_time=-1; relaxation_time=nan; relaxation_time=1001; relaxation_time=0; "
                "relaxation_time=0.1; relaxation_time=1e-300; colour='red'; "
                "prony=[{share=0.5}]; prony=[{time=1}]; prony=[{share=0, time=1}]; "
                "prony=[{share=-0.5, time=1}]; prony=[{share=0.95, time=1}]; "
                "prony=[{share=0.9, time=1}]; prony=[{share=0.5, time=0}]; "
                "prony=[{share=0.5, time=-1}]; prony=[{share=0.5, time=1e-4}]; "
                "prony=[{share=0.5, time=2000}]; prony=[{share=0.5, time=nan}]; "
                "prony=[{share=0.1, time=1, modulus=3}]; prony=0.5; prony=[]; "
                "prony=[{share=0.5, time=1}, {share=0.5, time=10}]; "
                "prony=[{share=0.1, time=1}, {share=0.2, time=10}, {share=0.6, time=100}]; "
                "prony=[{share=0.1, time=1}, {share=0.1, time=2}, {share=0.1, time=3}, "
                "{share=0.1, time=4}]")) {
    s->Material(line);
  }
  s->Text("Prony terms with Gauss-Seidel", SoundScene({.energy = "solver='gauss_seidel'",
                                                       .material = "prony=[{share=0.5, time=1}]"}));
  s->Text("a metric energy", SoundScene({.energy = "type='metric'"}));
  s->Text("a metric energy with local functions",
          SoundScene({.lattice = "local_functions=8", .energy = "type='metric'"}));
  s->Text("a stiffness of the metric energy without its type",
          SoundScene({.energy = "alpha=2000"}));
  s->Text("Gauss-Seidel without a type", SoundScene({.energy = "solver='gauss_seidel'"}));
  s->Text("Gauss-Seidel with local functions",
          SoundScene({.lattice = "local_functions=8", .energy = "solver='gauss_seidel'"}));
  s->Text("a metric energy without stiffness", SoundScene({.energy = "type='metric'\nalpha=0"}));
  s->Text("a metric energy of NaN", SoundScene({.energy = "type='metric'\nalpha=nan"}));
  s->Text("a metric energy of negative beta", SoundScene({.energy = "type='metric'\nbeta=-1"}));
  s->Text("an energy of another type", SoundScene({.energy = "type='magnetic'"}));
  s->Text("Newton without iterations",
          SoundScene({.energy = "strain='finite'\nnewton_iterations=0"}));
  s->Text("Newton without time", SoundScene({.energy = "strain='finite'\nnewton_budget=0"}));
}

void AddSupports(Scenes* s) {
  s->Table("a support without a region", "[[organ.support]]\nfixed=true");
  s->Table("a support of NaN",
           "[[organ.support]]\nstiffness=nan\nsphere={centre=[0,0,0],radius=1}");
  s->Table("a support of no stiffness",
           "[[organ.support]]\nstiffness=0\nsphere={centre=[0,0,0],radius=1}");
  s->Table("a support that is fixed and viscoelastic",
           "[[organ.support]]\nfixed=true\nviscoelastic=true\nsphere={centre=[0,0,0],radius=1}");
  s->Table("a support of a negative radius",
           "[[organ.support]]\nfixed=true\nsphere={centre=[0,0,0],radius=-1}");
  s->Table("a support turned inside out",
           "[[organ.support]]\nfixed=true\nbox={min=[0,0,1],max=[1,1,0]}");
  s->Table("a support beside the tissue",
           "[[organ.support]]\nfixed=true\nsphere={centre=[5,5,5],radius=0.01}");
  s->Table("a support between the samples",
           "[[organ.support]]\nfixed=true\nsphere={centre=[0,0,0.0501],radius=1e-12}");
  s->Table("a support of all tissue",
           "[[organ.support]]\nfixed=true\n"
           "box_fraction={min=[0,0,0],max=[1,1,1]}");
}

void AddTimings(Scenes* s) {
  for (const std::string& line :
       Separate("haptic_hz=0; haptic_hz=-1000; haptic_hz=nan; haptic_hz=1000000000; "
                "haptic_hz=1000.5; haptic_hz='1 kHz'; haptic_hz=100; haptic_hz=10000; "
                "deformation_hz=0; deformation_hz=-30; deformation_hz=1001; render_hz=0; "
                "render_hz=1000000; patch_delay_ticks=0; patch_delay_ticks=-34; "
                "patch_delay_ticks=2147483648; seconds=1")) {
    s->Timing(line);
  }
}

void AddInstruments(Scenes* s) {
  for (const std::string& line : Separate(
           "tip_radius=0; tip_radius=-1; tip_radius=nan; tip_radius=1e-300; tip_radius=10; "
           "friction=-1; friction=inf; trocar_friction=-1; trocar_friction=1e300; "
           "trocar_torque=-1e-9; trocar_torque=2; type='spoon'; hand.seed=-1; hand.script='dance'; "
           "hand.organ='lung'; hand.depth=nan; hand.depth=-1; hand.spread=0; hand.speed=0; "
           "hand.speed=1e9; "
           "device.mass=0; device.mass=-1; device.damping=nan; device.max_force=-1; "
           "device.max_force=1e300; device.encoder_step=-1; trace.file='no.csv'; trace.speed=0; "
           "trace.speed=nan; trace.scale=-1; exchange=[{name='probe'}]; jaws={}; mesh='no.obj'")) {
    s->Instrument(line);
  }
  for (const char* jaws : {"closing_force=-1", "closing_force=1e300", "closing_force=nan",
                           "jaw_friction=-1", "jaw_friction=0", "jaw_friction=3"}) {
    s->Text(std::string("a grasper: ") + jaws,
            SoundScene({.instrument = std::string("type='grasper'\n") + jaws + "\n"}));
  }
  s->Text("jaws wider than the organ",
          SoundScene({.organ = "unit=0.3\n", .instrument = "type='grasper'\ntip_radius=0.02\n"}));
  s->Text("a tip wider than the organ",
          SoundScene({.organ = "unit=0.3\n", .instrument = "tip_radius=0.02\n"}));
  s->Instrument("power=40");
  s->Text("a hook without power", SoundScene({.instrument = "type='hook'\npower=0\n"}));
  s->Text("a hook of NaN", SoundScene({.instrument = "type='hook'\npower=nan\n"}));
  s->Text("a hook with clips", SoundScene({.instrument = "type='hook'\nclips=3\n"}));
  s->Text("a magazine of -1 clips", SoundScene({.instrument = "type='clip_applier'\nclips=-1\n"}));
  s->Text("a probe with jaws: closing_force=5", SoundScene({.instrument = "closing_force=5\n"}));
  for (const char* jaws : {"closing_force=5", "jaw_friction=0.5"}) {
    const std::string line = jaws + std::string("\n");
    s->Text(std::string("a grasper of springs: ") + jaws,
            SoundScene({.instrument = "type='grasper'\nreaction='paper'\n" + line}));
  }
  s->Text("an exchange of springs: closing_force=5",
          SoundScene({.instrument = "reaction='paper'\nexchange=[{name='g',type='grasper',"
                                    "closing_force=5}]\n"}));
  s->Text("instrument: trocar=[0,0,50]", SoundScene({.trocar = "[0,0,50]"}));
}

void AddViewsAndRecords(Scenes* s) {
  s->Table("a scope at its target", "[laparoscope]\nposition=[0,0,0]\ntarget=[0,0,0]");
  s->Table("a scope of NaN", "[laparoscope]\nposition=[0,nan,0]");
  s->Table("a scope of 20 degrees", "[laparoscope]\nangle_deg=20");
  s->Table("a view of 180 degrees", "[laparoscope]\nfield_of_view_deg=180");
  s->Table("gravity of a hundred g", "[scene]\ngravity=[0,0,-981]");
  s->Table("a background that is missing", "[scene]\nbackground='no.png'");
  s->Table(
      "a file of a record that leads out",
      "[[file]]\nname='box.obj'\ncopy='../common/box.obj'\nsha256='" + std::string(64, '0') + "'");
  s->Table("a file of a record without a sum", "[[file]]\nname='../common/box.obj'");
  s->Table("a record that lacks the mesh",
           "[[file]]\nname='other'\nsha256='" + std::string(64, '0') + "'");
  s->Table("unknown table", "[laproscope]");
}

void AddLoads(Scenes* s) {
  const std::string at = "organ='liver'\npoint=[0,0,0.05]\nradius=0.03\n";
  s->Add("no load to solve", {"solve", "s.toml", "--out", "f.csv"},
         WithFile("s.toml", SoundScene({})));
  s->Solved("a load", at + "force=[0,0,-1]");
  s->Solved("a load on nothing", "organ='lung'\npoint=[0,0,0]\nradius=1\nforce=[0,0,1]");
  s->Solved("a load of NaN", at + "force=[0,nan,0]");
  s->Solved("a load of a meganewton too much", at + "force=[0,0,1e7]");
  s->Solved("a load beside the organ", "organ='liver'\npoint=[5,5,5]\nradius=0.03\nforce=[0,0,1]");
  s->Solved("a load of no radius", "organ='liver'\npoint=[0,0,0.05]\nradius=0\nforce=[0,0,1]");
  s->Solved("a load narrower than a number",
            "organ='liver'\npoint=[0,0,0.05]\nradius=1e-300\nforce=[0,0,1]");
  s->Solved("a load without a value", at);
  s->Solved("a pressure on no surface",
            "organ='liver'\npressure=10\nsphere={centre=[5,5,5],radius=0.01}");
  s->Solved("the same displacement twice",
            at + "displacement=[0,0,-0.001]\n[[load]]\n" + at + "displacement=[0,0,-0.001]");
  s->Solved("two displacements that contradict each other",
            at + "displacement=[0,0,-0.001]\n[[load]]\n" + at + "displacement=[0,0,0.001]");
}

void AddSessions(Scenes* s) {
  for (const char* material : {"young=1e-300", "young=1e12", "poisson=0.4999999999999999"}) {
    s->Run(std::string("a session of strain energy: ") + material,
           SoundScene({.energy = "type='strain'\n", .material = material}));
  }
  s->Text("a lattice of strain energy too fine for any memory",
          SoundScene({.lattice = "cells=32", .energy = "type='strain'\n"}));
  s->Text("a refinement of more than a million cells",
          SoundScene({.lattice = "cells=20\nlocal_refinement=6"}));
  s->Text("local functions too fine for any memory",
          SoundScene({.lattice = "cells=32\nlocal_functions=8\nlocal_refinement=6",
                      .energy = "type='strain'\n"}));
  s->Run("a session of a giant", SoundScene({.organ = "unit=1000\n"}));
  s->Run("a session of a dwarf", SoundScene({.organ = "unit=1e-12\n"}));
  s->Run("a session without an instrument", SoundScene({}).substr(0, SoundScene({}).find("[[ins")));
  s->Run("a session inside the organ", SoundScene({.trocar = "[0,0,0]"}));
  s->Run("two organs in one place",
         SoundScene({}) + "[[organ]]\nname='twin'\nmesh='../common/box.obj'\n");
  s->Run("a name that is a path", SoundScene({.name = "../../../x"}));
}

void AddCuts(Scenes* s) {
  const auto cut = [s](const std::string& name, const std::string& strip,
                       const SceneChange& change = {}, const std::string& more = "") {
    s->Text(name, SoundScene(change) + more + "[[cut]]\norgan='liver'\nstrip=[" + strip + "]\n");
  };
  const std::string sound = "[[0.01,-0.06,0.06],[0.01,-0.06,0]],[[0.01,0.06,0.06],[0.01,0.06,0]]";
  cut("a cut", sound);
  cut("a cut outside the organ", "[[1,0,0],[1,0,1]],[[1,1,0],[1,1,1]]");
  cut("a cut of zero length", "[[0,0,0],[0,0,0]],[[0,0,0.01],[0,0,0.01]]");
  cut("a cut of equal edges", "[[0,0,0],[0,0,0.01]],[[0,0,0],[0,0,0.01]]");
  cut("a cut of NaN", "[[0,0,nan],[0,0,0]],[[0.01,0,0.06],[0.01,0,0]]");
  cut("a cut of one edge", "[[0,0,0.06],[0,0,0]]");
  cut("a cut of points", "[0,0,0.06],[0,0,0]");
  cut("a cut that crosses itself",
      "[[-0.03,0,-0.01],[-0.03,0,0.06]],[[0.03,0,-0.01],[0.03,0,0.06]],"
      "[[0.03,0.03,-0.01],[0.03,0.03,0.06]],[[0,-0.03,-0.01],[0,-0.03,0.06]]");
  const std::string other = "[[organ]]\nname='other'\nmesh='../common/box.obj'\nmodel=";
  const std::string cut_other = "\n[[cut]]\norgan='other'\nstrip=[" + sound + "]\n";
  s->Text("a cut of a rigid organ", other + "'rigid'" + cut_other);
  s->Text("a cut of a surface model", other + "'mass_spring'" + cut_other);
  cut("a cut in finite strain", sound, {.energy = "strain='finite'\n"});
  cut("a cut along a support", sound, {.organ = ""},
      "[[organ]]\nname='held'\nmesh='../common/box.obj'\n[organ.lattice]\ncells=2\n"
      "[[organ.support]]\nbox={min=[-1,-1,-1],max=[1,1,1]}\nfixed=true\n"
      "[[cut]]\norgan='held'\nstrip=[" +
          sound + "]\n");
  s->Run("a session of a cut organ",
         SoundScene({}) + "[[cut]]\norgan='liver'\nstrip=[" + sound + "]\n");
}

// A box with a cavity as an OBJ file, `triangles` of its wall (12: closed).
std::string HollowBox(int triangles) {
  std::ostringstream file;
  for (const double half : {0.05, 0.03}) {
    for (int i = 0; i < 8; ++i) {
      file << "v " << ((i & 1) != 0 ? half : -half) << ' ' << ((i & 2) != 0 ? half : -half) << ' '
           << ((i & 4) != 0 ? half : -half) << '\n';
    }
  }
  constexpr int kFaces[12][3] = {{1, 3, 4}, {1, 4, 2}, {5, 6, 8}, {5, 8, 7}, {1, 2, 6}, {1, 6, 5},
                                 {3, 7, 8}, {3, 8, 4}, {1, 5, 7}, {1, 7, 3}, {2, 4, 8}, {2, 8, 6}};
  for (const auto& f : kFaces) file << "f " << f[0] << ' ' << f[1] << ' ' << f[2] << '\n';
  for (int t = 0; t < triangles; ++t) {
    const auto& f = kFaces[t];
    file << "f " << f[0] + 8 << ' ' << f[2] + 8 << ' ' << f[1] + 8 << '\n';
  }
  return file.str();
}

void AddFillingsAndLayers(Scenes* s) {
  const auto hollow = [&](const std::string& name, int triangles, const std::string& more) {
    s->Place(name, [=](const fs::path& here) {
      WithFile("hollow.obj", HollowBox(triangles))(here);
      WithFile("s.toml", SoundScene({.mesh = "hollow.obj", .organ = more}))(here);
    });
  };
  hollow("a filled lumen", 12, "lumen=[{}]\n");
  hollow("a lumen that is open", 11, "lumen=[{}]\n");
  s->Place("a perforated lumen of viscoelastic tissue", [](const fs::path& here) {
    WithFile("hollow.obj", HollowBox(12))(here);
    WithFile("s.toml", SoundScene({.mesh = "hollow.obj",
                                   .organ = "lumen=[{perforated_at=1}]\n",
                                   .material = "prony=[{share=0.5, time=1}]\n"}))(here);
  });
  hollow("a lumen elsewhere", 12, "lumen=[{sphere={centre=[0,0,0],radius=0.01}}]\n");
  s->Organ("lumen=[{}]");
  s->Organ("lumen=[{leak_resistance=0}]");
  s->Organ("lumen=[{bulk_modulus=0}]");
  s->Organ("lumen=[{filled=1}]");
  s->Organ("layer=[{stiffness=20, strength=300}]");
  s->Organ("layer=[{}]");
  s->Organ("layer=[{stiffness=0}]");
  s->Organ("layer=[{stiffness=20, poisson=0.5}]");
  s->Organ("layer=[{stiffness=20, strength=0}]");
  s->Organ("layer=[{stiffness=20, sphere={centre=[0,0,1],radius=0.1}}]");
  s->Text("a layer in finite strain",
          SoundScene({.organ = "layer=[{stiffness=20}]\n", .energy = "strain='finite'\n"}));
  s->Table("a layer on a rigid organ",
           "[[organ]]\nname='wall'\nmesh='../common/box.obj'\nmodel='rigid'\n"
           "[[organ.layer]]\nstiffness=20");
  s->Table("a cut organ with a layer",
           "[[organ]]\nname='held'\nmesh='../common/box.obj'\nlayer=[{stiffness=20}]\n"
           "[[cut]]\norgan='held'\nstrip=[[[0,-1,-1],[0,1,-1]],[[0,-1,0],[0,1,0]]]");
}

void AddExercises(Scenes* s) {
  const auto exercise = [s](const std::string& name, const std::string& step,
                            const std::string& error = "", const std::string& keys = "") {
    s->Table("an exercise " + name,
             "[exercise]\n" + keys + (step.empty() ? "" : "[[exercise.step]]\nname='a'\n" + step) +
                 (error.empty() ? "" : "[[exercise.error]]\n" + error));
  };
  const std::string step = "hold='liver'\n";
  exercise("that is sound", step, "kind='force'\n");
  exercise("without steps", "");
  exercise("with a step without conditions", "time=1\n");
  exercise("that holds no organ", "hold='lung'\n");
  exercise("with no instrument", "hold='liver'\nhold_with='spoon'\n");
  exercise("that holds with nothing held", "force=1\nhold_with='probe'\n");
  exercise("that lifts nothing", "force=1\nlift=0.01\n");
  exercise("that touches somewhere", "touch='liver'\nat=[0,0,0]\n");
  exercise("that touches nowhere", "touch='liver'\nwithin=0.1\n");
  exercise("that frees what is not attached", "free='liver'\narea=1e-4\n");
  exercise("that frees no area", "free='liver'\n");
  exercise("of negative time", step + "time=-1\n");
  exercise("without time", step, "", "time_limit=0\n");
  exercise("with a late target", step, "", "time_limit=10\ntarget_time=10\n");
  exercise("with a goal of 300 bytes", step, "", "goal='" + std::string(300, 'a') + "'\n");
  exercise("with an unknown error", step, "kind='sneeze'\n");
  exercise("with an error without a kind", step, "limit=1\n");
  exercise("with a force of NaN", step, "kind='force'\nlimit=nan\n");
  exercise("with a tear of no attachment", step, "kind='tear'\norgan='liver'\n");
  exercise("with a limit of inversion", step, "kind='inverted'\nlimit=1\n");
  exercise("with a stray burn of an organ", step, "kind='stray_burn'\norgan='liver'\n");
  exercise("with a perforation of no lumen", step, "kind='perforation'\norgan='liver'\n");
  exercise("with a perforation of nothing", step, "kind='perforation'\n");
  exercise("with a stretch of nothing", step, "kind='stretch'\n");
  exercise("with points below zero", step, "kind='force'\npoints=-5\n");
  exercise("that clips no duct", "clip='aorta'\n");
  exercise("that counts clips of nothing", step + "clips=3\n");
  exercise("that cuts no duct", "cut='aorta'\n");
  exercise("that removes no organ", step, "", "removes='lung'\n");
  exercise("with a bad clip of an organ", step, "kind='bad_clip'\norgan='liver'\n");
  exercise("with a clip turned by 100 degrees", step, "kind='bad_clip'\nlimit=100\n");
  exercise("with a wrong clip of nothing", step, "kind='wrong_clip'\n");
  exercise("with a wrong cut of nothing", step, "kind='wrong_cut'\n");
  exercise("with a burn near no duct", step, "kind='near_burn'\nduct='aorta'\nwithin=0.005\n");
  exercise("with a limit of lost clips", step, "kind='dropped_clip'\nlimit=1\n");
  exercise("with a force on a duct", step, "kind='force'\nduct='aorta'\n");
  exercise("with an early cut without a step", step, "kind='early_cut'\n");
  exercise("with an early clip before no step", step, "kind='early_clip'\nbefore='b'\n");
  exercise("with a force before a step", step, "kind='force'\nbefore='a'\n");
  exercise("with a burn near nothing", step, "kind='near_burn'\nwithin=0.005\n");
  exercise("with a burn near a point", step, "kind='near_burn'\npath=[[0,0,0]]\nwithin=0.005\n");
  exercise("with a burn somewhere near", step, "kind='near_burn'\npath=[[0,0,0],[0,0,1]]\n");
  exercise("with a burn near an organ", step,
           "kind='near_burn'\npath=[[0,0,0],[0,0,1]]\nwithin=0.005\norgan='liver'\n");
  exercise("with a burn of a line", step, "kind='burn'\npath=[[0,0,0],[0,0,1]]\n");
  exercise("with a drop off a line anywhere", step, "kind='drop'\npath=[[0,0,0],[0,0,1]]\n");
  exercise("with a drop off a line and its place", step,
           "kind='drop'\nlimit=0.01\nwithin=0.01\npath=[[0,0,0],[0,0,1]]\n");
  exercise("with a force within a distance", step, "kind='force'\nwithin=0.005\n");
}

void AddAttachments(Scenes* s) {
  constexpr const char* kFace = "box={min=[0.049,-1,-1],max=[0.051,1,1]}\n";
  const auto layer = [](const std::string& region, const std::string& toughness = "45",
                        const std::string& strength = "10000") {
    return "[[attachment]]\na='liver'\nb='other'\n" + region +
           "young=20000\nthickness=0.001\nstrength=" + strength + "\ntoughness=" + toughness + "\n";
  };
  const auto scene = [](const std::string& other, const std::string& more,
                        const SceneChange& change = {}) {
    return SoundScene(change) +
           "[[organ]]\nname='other'\nmesh='../common/box.obj'\n"
           "pose={position=[0.1003,0,0]}\n" +
           other + more;
  };
  const std::string soft = "lattice={cells=2}\n", rigid = "model='rigid'\n";
  s->Text("an attachment", scene(rigid, layer(kFace)));
  s->Text("an attachment in the air", scene(soft, layer("sphere={centre=[0,0,1],radius=0.1}\n")));
  s->Text("an attachment across a gap", scene("unit=0.9\n" + rigid, layer(kFace)));
  s->Text("an attachment of less than one function",
          scene(soft, layer("sphere={centre=[0.05,0,0],radius=0.02}\n")));
  s->Text("an attachment over a support",
          scene("lattice={cells=2}\n[[organ.support]]\n"
                "box={min=[0.04,0,-1],max=[0.2,0.03,1]}\nfixed=true\n",
                layer(kFace)));
  s->Text("an attachment of no strength", scene(soft, layer(kFace, "45", "0")));
  s->Text("an attachment of less toughness than it stores", scene(soft, layer(kFace, "2.4")));
  s->Text("an attachment that the weight overloads",
          scene(rigid, layer(kFace, "45", "10") + "[scene]\ngravity=[0,0,-9.81]\n",
                {.organ = "support=[{box={min=[-1,-1,-1],max=[-0.03,1,1]}, fixed=true}]\n"}));
  s->Text("an attachment of NaN", scene(soft, layer(kFace, "nan")));
  s->Text("an attachment that burns without heat", scene(soft, layer(kFace) + "burn_energy=0\n"));
  s->Text("two attachments on one surface", scene(soft, layer(kFace) + layer(kFace)));
  s->Text("an attachment of two rigid organs",
          scene(rigid,
                "[[organ]]\nname='wall'\nmesh='../common/box.obj'\nmodel='rigid'\n"
                "[[attachment]]\na='wall'\nb='other'\n"));
  s->Text("an attachment of an organ to itself",
          scene(soft, "[[attachment]]\na='other'\nb='other'\n"));
  s->Text("an attachment of organs in contact",
          scene(soft, "[[contact]]\na='liver'\nb='other'\n" + layer(kFace)));
  s->Text("an attachment in finite strain",
          scene(soft, layer(kFace), {.energy = "strain='finite'\n"}));
  s->Text("an attachment of a surface model", scene("model='mass_spring'\n", layer(kFace)));
  s->Text("an attachment of no organ", scene(soft, "[[attachment]]\na='liver'\nb='kidney'\n"));
  s->Text("an attachment without a region", scene(soft, layer("")));
  const auto leaf = [&](const std::string& a, const std::string& b, const std::string& toughness) {
    return layer("path_a=[" + a + "]\npath_b=[" + b + "]\n", toughness);
  };
  const std::string on_a = "[0.03,-0.02,0.05],[0.03,0.02,0.05]",
                    on_b = "[0.07,-0.02,0.05],[0.07,0.02,0.05]";
  s->Text("a leaf", scene(soft, leaf(on_a, on_b, "200")));
  s->Text("a leaf with a region", scene(soft, leaf(on_a, on_b, "200") + kFace));
  s->Text("a leaf with one path", scene(soft, layer("path_a=[" + on_a + "]\n")));
  s->Text("a leaf of NaN", scene(soft, leaf(on_a, "[nan,0,0],[1,0,0]", "200")));
  s->Text("a leaf of no length", scene(soft, leaf(on_a, "[0.07,0,0.05],[0.07,0,0.05]", "200")));
  s->Text("a leaf off its organ", scene(soft, leaf(on_a, "[0.07,0,0.09],[0.07,0.02,0.09]", "200")));
  s->Text(
      "a leaf between surfaces that touch",
      scene(soft, leaf("[0.05,-0.02,0],[0.05,0.02,0]", "[0.0503,-0.02,0],[0.0503,0.02,0]", "200")));
  s->Text("a leaf that breaks at its strength", scene(soft, leaf(on_a, on_b, "99")));
  s->Run("a session of attached organs", scene(rigid, layer(kFace)));
  s->Add("a static case of an attached organ", {"solve", "s.toml", "--out", "f.csv"},
         WithFile("s.toml", scene(soft, layer(kFace) + "[[load]]\norgan='other'\npoint=[0.15,0,0]\n"
                                                       "radius=0.02\nforce=[1,0,0]\n")));
}

void AddDucts(Scenes* s) {
  const auto duct = [](const std::string& ends, const std::string& path,
                       const std::string& section = "radius=0.002\nwall=0.0008\nyoung=5e5\n") {
    return "[[duct]]\nname='cystic'\n" + ends + "path=" + path + "\n" + section;
  };
  const auto scene = [](const std::string& more, const SceneChange& change = {}) {
    return SoundScene(change) + more;
  };
  const std::string liver = "a='liver'\n", path = "[[0.045,0,0],[0.07,0,0],[0.09,0.01,0]]";
  s->Text("a duct", scene(duct(liver + "label='do not touch'\n", path)));
  s->Text("a duct of no organ", scene(duct("a='kidney'\n", path)));
  s->Text("a duct between the world and itself", scene(duct("", path)));
  s->Text("a duct that begins in the air", scene(duct(liver, "[[0.06,0,0],[0.09,0,0]]")));
  s->Text("a duct of zero length", scene(duct(liver, "[[0.045,0,0],[0.045,0,0]]")));
  s->Text("a duct shorter than four radii", scene(duct(liver, "[[0.048,0,0],[0.055,0,0]]")));
  s->Text("a duct that doubles back", scene(duct(liver, "[[0.045,0,0],[0.09,0,0],[0.06,0,0]]")));
  s->Text("a duct of one point", scene(duct(liver, "[[0.045,0,0]]")));
  s->Text("a duct along a number", scene(duct(liver, "0.045")));
  s->Text("a duct along points of two numbers", scene(duct(liver, "[[0.045,0],[0.09,0]]")));
  s->Text("a duct in millimetres", scene(duct(liver, "[[45,0,0],[90,0,0]]")));
  s->Text("a duct of NaN", scene(duct(liver, "[[0.045,0,nan],[0.09,0,0]]")));
  s->Text("a duct without a lumen",
          scene(duct(liver, path, "radius=0.002\nwall=0.002\nyoung=5e5\n")));
  s->Text("a duct without a wall", scene(duct(liver, path, "radius=0.002\nwall=0\nyoung=5e5\n")));
  s->Text("a duct without a modulus", scene(duct(liver, path, "radius=0.002\nwall=0.0008\n")));
  s->Text("two ducts of one name", scene(duct(liver, path) + duct(liver, path)));
  s->Text("two ducts with the same ends",
          scene(duct(liver, path) + "[[duct]]\nname='other'\n" + liver + "path=" + path +
                "\nradius=0.002\nwall=0.0008\nyoung=5e5\n"));
  s->Text("a duct of an organ in finite strain",
          scene(duct(liver, path), {.energy = "strain='finite'\n"}));
  const auto free = [&](const std::string& more) {
    return scene(more, {.organ = "free={drag=1}\n"});
  };
  const std::string bed =
      "[[organ]]\nname='wall'\nmesh='../common/box.obj'\nmodel='rigid'\n"
      "pose={position=[-0.1003,0,0]}\n[[attachment]]\na='liver'\nb='wall'\n"
      "box={min=[-0.051,-1,-1],max=[-0.049,1,1]}\nyoung=20000\nthickness=0.001\n"
      "strength=10000\ntoughness=45\n";
  s->Text("a duct of a free organ that no attachment holds", free(duct(liver, path)));
  s->Text("a duct with both ends in a free organ",
          free(bed + duct(liver + "b='liver'\n", "[[0.045,0,0],[0.07,0.01,0],[0.045,0.03,0]]")));
  s->Run("a session with a duct of a free organ on its bed", free(bed + duct(liver, path)));
  s->Run("a session with a duct", scene(duct(liver, path)));
  s->Add("a static case of an organ with a duct", {"solve", "s.toml", "--out", "f.csv"},
         WithFile("s.toml", scene(duct(liver, path) + "[[load]]\norgan='liver'\npoint=[0.05,0,0]\n"
                                                      "radius=0.02\nforce=[1,0,0]\n")));
}

TEST(BadInput, ScenesHaveTheOutcomesOfTheTable) {
  Scenes scenes;
  AddTexts(&scenes);
  AddLargeTexts(&scenes);
  AddBrokenTexts(&scenes);
  AddPlaces(&scenes);
  AddOrgans(&scenes);
  AddLattices(&scenes);
  AddMaterials(&scenes);
  AddSupports(&scenes);
  AddTimings(&scenes);
  AddInstruments(&scenes);
  AddViewsAndRecords(&scenes);
  AddLoads(&scenes);
  AddCuts(&scenes);
  AddFillingsAndLayers(&scenes);
  AddAttachments(&scenes);
  AddDucts(&scenes);
  AddExercises(&scenes);
  AddSessions(&scenes);
  scenes.Compare();
}

}  // namespace
}  // namespace hpdm
