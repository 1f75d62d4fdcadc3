// Bad command lines: tests/bad_input/command_lines.csv. An input's name is the command
// line itself, unless that is unreadable.

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <sstream>

#include "tests/bad_input/bad_input.h"
#include "tests/bad_input/sound_scene.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

/// Fills the folder of every command line.
void Prepare(const fs::path& here) {
  WithFile("s.toml", SoundScene({}) +
                         "[[load]]\norgan='liver'\npoint=[0,0,0.05]\nradius=0.03\n"
                         "force=[0,0,-1]\n")(here);
  WithFile("kept.csv", "do not lose this\n")(here);
  WithFile("t.csv", "t,px,py,pz\n0,0,0,0.1\n0.1,0,0,0.1\n")(here);
  fs::create_directory(here / "folder");
  fs::create_directory(here / "read_only");
  fs::permissions(here / "read_only", fs::perms::owner_read | fs::perms::owner_exec);
  mkfifo((here / "pipe").c_str(), 0600);
}

class CommandLines : public BadInputs {
 public:
  CommandLines() : BadInputs("command_lines", WriteBox) {}

  static std::vector<std::string> Words(const std::string& line) {
    std::istringstream words(line);
    std::vector<std::string> all;
    for (std::string word; words >> word;) all.push_back(word);
    return all;
  }
  using BadInputs::Add;
  void Add(const std::string& line) { Named(line, Words(line)); }
  void Named(const std::string& name, std::vector<std::string> words) {
    BadInputs::Add(name, std::move(words), Prepare);
  }
  void To(const std::string& out, const std::string& line) {
    BadInputs::Add(line + " > " + out, {.words = Words(line), .folder = {}, .out = out}, Prepare);
  }
  void AsNobodyElse(const std::string& line) {
    BadInputs::Add(line, {.words = Words(line), .folder = {}, .as_nobody_else = true}, Prepare);
  }
};

void AddSubcommands(CommandLines* c) {
  c->Named("nothing", {});
  c->Add("fly");
  c->Add("fly --help");
  c->Add("log fly --help");
  c->Add("runn --help");
  c->Add("--frobnicate");
  c->Add("--headless run s.toml");
  for (const char* misspelled :
       {"runn s.toml --seconds 1", "run s.toml --secnds=1", "run --secnds 1", "log exprt t.csv",
        "plan s.toml --error 0.1 --budgetms 1"}) {
    c->Add(misspelled);
  }
  c->Add("--version");
  c->Add("--help");
  for (const char* help :
       {"help", "help run", "help log export", "help runn", "help --frobnicate"}) {
    c->Add(help);
  }
  for (const std::string command :
       {"run", "replay", "report", "spy", "log", "log check", "log export", "check", "inspect",
        "solve", "chart", "plan", "generate"}) {
    c->Add(command);
  }
  for (const std::string command :
       {"run s.toml", "replay s.toml", "report folder", "spy s.toml", "log check s.toml",
        "log export s.toml", "check s.toml", "inspect s.toml", "solve s.toml", "chart s.toml",
        "plan s.toml", "bench", "haptics", "generate", "stress"}) {
    c->Add(command + " --frobnicate");
    c->Add(command + " --help");
  }
  c->Named("an empty argument", {"check", ""});
  c->Named("an empty value", {"run", "s.toml", "--out", "", "--seconds", "0.01"});
  c->Named("an empty value behind =", {"run", "s.toml", "--out=", "--seconds", "0.01"});
  c->Named("an argument with a line break", {"check", "s.toml", "a\nb\nc"});
  c->Named("an argument with a terminal's escape", {"check", "s.toml", "\x1b[2J"});
  c->Named("an argument that is not UTF-8", {"check", "s.toml", "\xff\xfe"});
  c->Named("an argument of 100,000 bytes", {"check", "s.toml", std::string(100'000, 'x')});
  c->Named("a value with a line break", {"run", "s.toml", "--clock", "real\ntime"});
  c->Named("10,000 arguments", std::vector<std::string>(10'000, "check"));
}

void AddRun(CommandLines* c) {
  const std::string run = "run s.toml --no-pictures --clock lockstep --out o";
  for (const char* seconds : {"", " 0", " -1", " nan", " inf", " 1e7", " 1e999", " abc", " 0x10",
                              " 1,5", " 0.01s", " 0.01 --seconds 0.02"}) {
    c->Add(run + " --seconds" + seconds);
  }
  c->Add(run);
  for (const char* option : {"--fps nan",
                             "--fps -1",
                             "--fps 241",
                             "--log-rate nan",
                             "--log-rate 0",
                             "--log-rate 0.5",
                             "--log-rate 1001",
                             "--log-rate 1e7",
                             "--log-rate often",
                             "--size wide",
                             "--size 0x0",
                             "--size -5x5",
                             "--size 99999999999x5",
                             "--size 8193x100",
                             "--size 640x480x2",
                             "--size 640X480",
                             "--ffd gpu",
                             "--overlay wings",
                             "--overlay error",
                             "--device piano",
                             "--device nobody=sim",
                             "--device trace:",
                             "--device trace:no.csv",
                             "--device trace:s.toml",
                             "--device trace:folder",
                             "--device trace:pipe",
                             "--device lcm",
                             "--device mouse",
                             "--exchange probe",
                             "--exchange probe=hook@nan",
                             "--exchange probe=hook@-1",
                             "--exchange nobody=hook@1",
                             "--pedal probe",
                             "--pedal probe@2-1",
                             "--pedal probe@nan-1",
                             "--pedal nobody@1-2",
                             "--restart 2@1",
                             "--reference no.csv",
                             "--reference s.toml",
                             "--reference pipe",
                             "--reference kept.csv",
                             "--film",
                             "--window",
                             "--headless --window",
                             "s.toml"}) {
    c->Add(run + " --seconds 0.01 " + option);
  }
  const std::string short_run = "run s.toml --no-pictures --clock lockstep --seconds 0.01 --out ";
  for (const char* out : {"s.toml", "s.toml/x", "/dev/full", "/dev/null/x", "/proc/x", "pipe"}) {
    c->Add(short_run + out);
  }
  c->AsNobodyElse(short_run + "read_only");
  c->AsNobodyElse(short_run + "read_only/o");
  c->Add(short_run + "p --out q");
  c->Add("run no.toml --clock lockstep --seconds 0.01");
}

void AddReplaysAndReports(CommandLines* c) {
  for (const char* line : {"replay t.csv",
                           "replay no.csv --scene s.toml",
                           "replay t.csv --scene no.toml",
                           "replay t.csv --scene s.toml --tolerance nan",
                           "replay t.csv --scene s.toml --tolerance -1",
                           "replay t.csv --scene s.toml --tolerance 2",
                           "replay t.csv --scene s.toml --clock wall",
                           "replay folder",
                           "replay s.toml",
                           "replay pipe",
                           "replay no.lcmlog",
                           "report no",
                           "report folder",
                           "report s.toml",
                           "report pipe",
                           "report --json-line",
                           "report folder --force-limit nan",
                           "report folder --force-limit inf",
                           "report folder --force-limit 0",
                           "report folder --force-limit -1",
                           "report folder --all",
                           "report no --all",
                           "report folder --all --json",
                           "report folder --all --jobs 0",
                           "report folder --all --jobs 1e9",
                           "report folder --all --timeout nan",
                           "report folder --all --out kept.csv",
                           "report folder --jobs 2",
                           "report folder --all --out folder",
                           "report --collect no --out t.sqlite",
                           "report --collect s.toml",
                           "report --collect /dev/zero --out t.sqlite",
                           "report --collect s.toml --out kept.csv"}) {
    c->Add(line);
  }
}

void AddSpies(CommandLines* c) {
  for (const char* line : {"spy --once s.toml",
                           "spy --once no.lcmlog",
                           "spy no.lcmlog",
                           "spy --once folder",
                           "spy --once pipe",
                           "spy --once --seconds 0",
                           "spy --once --seconds nan",
                           "spy --once t.csv --speed nan",
                           "spy --once t.csv --speed 0",
                           "spy --once t.csv --from nan",
                           "spy --once t.csv --from -1",
                           "spy --once --speed 2",
                           "spy --once --web",
                           "spy --json",
                           "spy --web 99999",
                           "spy --web no.lcmlog kept.csv",
                           "spy --host 127.0.0.1",
                           "spy --once t.csv --types no.lcm",
                           "spy --once t.csv --types s.toml",
                           "spy --once t.csv --types folder",
                           "spy --once t.csv --types pipe"}) {
    c->Add(line);
  }
}

void AddLogsAndMeshes(CommandLines* c) {
  for (const char* line : {"log check no.lcmlog",
                           "log check folder",
                           "log check pipe",
                           "log check /dev/zero",
                           "log check t.csv --repair kept.csv",
                           "log check t.csv --repair t.csv",
                           "log check t.csv --repair no/such/log",
                           "log check t.csv --types s.toml",
                           "log export no.lcmlog --out l",
                           "log export t.csv --out l.mcap",
                           "log export t.csv --format mcap --out folder",
                           "log export t.csv --format xml --out l",
                           "log export t.csv --format vtk --out l",
                           "log export t.csv --format vtk --out l --channels A",
                           "log export t.csv --format vtk --out l.mcap",
                           "log export t.csv --format mcap --out t.csv",
                           "log export t.csv --out kept.csv",
                           "log export t.csv --out l --channels NO_SUCH",
                           "inspect no.obj",
                           "inspect folder",
                           "inspect pipe",
                           "inspect s.toml",
                           "inspect /dev/zero",
                           "inspect ../common/box.obj --unit cm",
                           "inspect ../common/box.obj --unit 0",
                           "inspect ../common/box.obj --unit -1",
                           "inspect ../common/box.obj --unit nan",
                           "inspect ../common/box.obj --unit inf",
                           "inspect ../common/box.obj --unit 1,5"}) {
    c->Add(line);
  }
}

void AddWriters(CommandLines* c) {
  for (const char* line : {"solve s.toml --out s.toml",
                           "solve s.toml --out ../common/box.obj",
                           "solve s.toml --out ./folder/../s.toml",
                           "solve s.toml --out folder",
                           "solve s.toml --out no/such/f.csv",
                           "solve s.toml --out /dev/full",
                           "solve s.toml --out kept.csv --reference no.csv",
                           "solve s.toml --out kept.csv --reference kept.csv",
                           "solve s.toml --out f.csv --reference pipe",
                           "solve s.toml --out f.csv --picture s.toml",
                           "solve no.toml --out f.csv",
                           "solve s.toml --out f.csv",
                           "check no.toml",
                           "check --schema",
                           "check --schema s.toml",
                           "check s.toml s.toml",
                           "generate nothing --out g",
                           "generate liver_274 --out s.toml",
                           "generate liver_274 --out /dev/full",
                           "generate --out",
                           "teach",
                           "teach point --x 1.5",
                           "teach restart --step 0",
                           "teach poke",
                           "bench --only nothing",
                           "bench --only hand-over --quick --out s.toml",
                           "haptics --delay-ms -1 --out o",
                           "haptics --haptic-hz 50 --out o",
                           "haptics --only nothing --out o",
                           "stress --only nothing",
                           "stress --list --out",
                           "haptics no.toml --only press --out o",
                           "chart no.toml --out o",
                           "chart s.toml --only adaptive --quick --out o",
                           "chart s.toml --only nothing --out o",
                           "chart s.toml --out o --references folder",
                           "chart --out o",
                           "plan no.toml --error 0.1 --budget-ms 1",
                           "plan s.toml --error 0.1",
                           "plan s.toml --error 5 --budget-ms 1",
                           "plan s.toml --error nan --budget-ms 1",
                           "plan s.toml --error 0.1 --budget-ms 0",
                           "plan s.toml --error 0.1 --budget-ms 1 --out s.toml",
                           "plan s.toml --error 0.1 --budget-ms 1 --out no/such/p.toml",
                           "plan s.toml --error 0.1 --budget-ms 1 --out folder"}) {
    c->Add(line);
  }
  c->AsNobodyElse("solve s.toml --out read_only/f.csv");
  c->AsNobodyElse("generate liver_274 --out read_only/g");
  c->To("/dev/full", "check s.toml");
  c->To("/dev/full", "check s.toml --json");
  c->To("/dev/full", "inspect ../common/box.obj");
  c->To("/dev/full", "--help");
  c->To("/dev/full", "--version");
  c->To("/dev/full", "generate --list");
}

TEST(BadInput, CommandLinesHaveTheOutcomesOfTheTable) {
  CommandLines lines;
  AddSubcommands(&lines);
  AddRun(&lines);
  AddReplaysAndReports(&lines);
  AddSpies(&lines);
  AddLogsAndMeshes(&lines);
  AddWriters(&lines);
  lines.Compare();
}

}  // namespace
}  // namespace hpdm
