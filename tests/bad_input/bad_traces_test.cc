// Bad recorded motions, played on a sound scene: tests/bad_input/traces.csv.

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <fstream>

#include "tests/bad_input/bad_input.h"
#include "tests/bad_input/sound_scene.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

constexpr char kHeader[] = "t,px,py,pz\n";

std::string Number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

/// Returns rows every `step` seconds that move down and up by 5 mm.
std::string Rows(int count, double step, double scale = 1) {
  std::string rows;
  for (int i = 0; i < count; ++i) {
    rows += Number(i * step) + ",0,0," + Number(scale * 0.005 * std::sin(0.1 * i)) + "\n";
  }
  return rows;
}

class Traces : public BadInputs {
 public:
  Traces()
      : BadInputs("traces", [](const fs::path& common) {
          WriteBox(common);
          WithFile("s.toml", SoundScene({.mesh = "box.obj"}))(common);
        }) {}

  void Text(const std::string& name, const std::string& text) {
    Place(name, WithFile("t.csv", text));
  }
  void Place(const std::string& name, const Make& make) {
    Add(name, {"replay", "t.csv", "--scene", "../common/s.toml"}, make);
  }
};

void AddShapes(Traces* t) {
  const std::string sound = kHeader + Rows(50, 0.004);
  std::string crlf, commas;
  for (const char c : sound) crlf += c == '\n' ? "\r\n" : std::string(1, c);
  commas = "t;px;py;pz\n0,5;0,1;0,2;0,3\n";
  std::string utf16 = "\xff\xfe";
  for (const char c : sound) utf16 += {c, '\0'};
  t->Text("sound", sound);
  t->Text("empty", "");
  t->Text("a comment alone", "# nothing\n");
  t->Text("a header alone", kHeader);
  t->Text("one row", std::string(kHeader) + "0,0,0,0\n");
  t->Text("one row without a line end", std::string(kHeader) + "0,0,0,0");
  t->Text("half a row", std::string(kHeader) + "0,0,0,0\n1,0,");
  t->Text("no header", "0,0,0,0\n");
  t->Text("no time", "px,py,pz\n0,0,0\n");
  t->Text("half a place", "t,px,py\n0,0,0\n");
  t->Text("two kinds of places", "t,px,py,pz,pitch,yaw,insertion\n0,0,0,0,0,0,0.1\n");
  t->Text("a column twice", "t,px,py,pz,px\n0,0,0,0,0\n");
  t->Text("nothing that moves", "t,force\n0,1\n");
  t->Text("an unknown column", "t,px,py,pz,mood\n0,0,0,0,good\n1,0,0,0,bad\n");
  t->Text("decimal commas and semicolons", commas);
  t->Text("decimal commas between commas", std::string(kHeader) + "0,5,0,1,0,2,0,3\n");
  t->Text("tabs between cells", "t\tpx\tpy\tpz\n0\t0\t0\t0\n");
  t->Text("CRLF line ends", crlf);
  t->Text("CR line ends", "t,px,py,pz\r0,0,0,0\r");
  t->Text("byte order mark", "\xef\xbb\xbf" + sound);
  t->Text("UTF-16", utf16);
  t->Text("quoted cells", "\"t\",\"px\",\"py\",\"pz\"\n\"0\",\"0\",\"0\",\"0\"\n");
  t->Text("too few cells", std::string(kHeader) + "0,0,0,0\n1,0,0\n");
  t->Text("too many cells", std::string(kHeader) + "0,0,0,0,0\n");
  t->Text("a long line", std::string(kHeader) + "0,0,0," + std::string(5000, '0') + "\n");
  t->Text("a line of 10 MB", std::string(10'000'000, 't'));
  t->Text("a million columns", [] {
    std::string text = "t,px,py,pz";
    for (int i = 0; i < 1'000'000; ++i) text += ",c";
    return text + "\n";
  }());
  t->Text("binary", Garbage(1'000'000));
  t->Text("binary behind the header", kHeader + Garbage(1'000'000));
  t->Text("NUL bytes", kHeader + std::string(1000, '\0'));
  t->Text("a terminal's escape", std::string(kHeader) + "0,0,\x1b[2J,0\n");
}

void AddValues(Traces* t) {
  const std::string header = kHeader;
  for (const char* value : {"nan", "inf", "-inf", "1e999", "1e300", "1e5", "0x10", "", "1 2", "abc",
                            "1e-400", "--1", "0,1"}) {
    t->Text(std::string("z of \"") + value + "\"", header + "0,0,0," + value + "\n");
  }
  for (const char* value : {"nan", "inf", "1e300", "1e18", "-1e300"}) {
    t->Text(std::string("time of \"") + value + "\"", header + "0,0,0,0\n" + value + ",0,0,0\n");
  }
  t->Text("a first time of 1e300", header + "1e300,0,0,0\n1e300,0,0,0\n");
  t->Text("times from -1000 s", header + "-1000,0,0,0\n-999.9,0,0,0.001\n");
  t->Text("times of 2026", header + "1795000000.5,0,0,0\n1795000000.6,0,0,0.001\n");
  t->Text("unsorted", header + "0,0,0,0\n1,0,0,0\n0.5,0,0,0\n");
  t->Text("more than a day", header + "0,0,0,0\n86401,0,0,0\n");
  t->Text("every row twice", header + "0,0,0,0\n0,0,0,0.001\n0.1,0,0,0\n0.1,0,0,0.001\n");
  t->Text("one time in all rows", header + "5,0,0,0\n5,0,0,0.001\n5,0,0,0.002\n");
  t->Text("a gap of two seconds",
          header + "0,0,0,0\n0.004,0,0,0\n2.004,0,0,0.005\n2.008,0,0,0.005\n");
  t->Text("in millimetres", header + Rows(50, 0.004, 1000));
  t->Add("in millimetres, as the scene says", {"replay", "t.csv", "--scene", "mm.toml"},
         [](const fs::path& here) {
           WithFile("t.csv", kHeader + Rows(50, 0.004, 1000))(here);
           WithFile("mm.toml", SoundScene({.instrument = "trace.scale=0.001\n"}))(here);
         });
  t->Text("a jump of 0.3 m in a nanosecond",
          header + "0,0,0,0\n0.1,0,0,0\n0.100000001,0,0,0.3\n0.2,0,0,0.3\n");
  t->Text("a nanosecond in all", header + "0,0,0,0\n1e-9,0,0,0.001\n");
  t->Text("200,000 rows in a second", header + Rows(200'000, 5e-6));
  t->Text("more rows than are taken", [] {
    std::string text = "t,jaw\n";
    for (int i = 0; i <= 1'000'000; ++i) text.append(std::to_string(i)).append("e-3,1\n");
    return text;
  }());
  t->Text("a jaw and a roll beyond their ends", "t,roll,jaw\n0,1000,-5\n0.1,-1000,7\n");
}

void AddPlaces(Traces* t) {
  t->Place("missing", {});
  t->Place("a folder", [](const fs::path& here) { fs::create_directory(here / "t.csv"); });
  t->Place("a pipe without a writer",
           [](const fs::path& here) { mkfifo((here / "t.csv").c_str(), 0600); });
  t->Place("a link to itself",
           [](const fs::path& here) { fs::create_symlink("t.csv", here / "t.csv"); });
  t->Place("a device without an end",
           [](const fs::path& here) { fs::create_symlink("/dev/zero", here / "t.csv"); });
  t->Add("a file that may not be read",
         {.words = {"replay", "t.csv", "--scene", "../common/s.toml"},
          .folder = {},
          .as_nobody_else = true},
         [](const fs::path& here) {
           WithFile("t.csv", kHeader)(here);
           fs::permissions(here / "t.csv", fs::perms::none);
         });
  t->Add("a name with a line break", {"run", "../common/s.toml", "--device", "trace:a\nb.csv",
                                      "--clock", "lockstep", "--no-pictures", "--out", "o"});
}

TEST(BadInput, TracesHaveTheOutcomesOfTheTable) {
  Traces traces;
  AddShapes(&traces);
  AddValues(&traces);
  AddPlaces(&traces);
  traces.Compare();
}

}  // namespace
}  // namespace hpdm
