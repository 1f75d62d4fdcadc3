// Bad environment variables, and locales: tests/bad_input/environment.csv.

#include <gtest/gtest.h>

#include <fstream>

#include "tests/bad_input/bad_input.h"
#include "tests/bad_input/sound_scene.h"
#include "tests/support/comma_locale.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

class Environment : public BadInputs {
 public:
  using Variables = std::vector<std::pair<std::string, std::optional<std::string>>>;

  Environment()
      : BadInputs("environment", [](const fs::path& common) {
          WriteBox(common);
          WithFile("a_file", "do not lose this\n")(common);
          WithFile("motion.csv", "t,px,py,pz\n0,0,0,0.0015\n0.05,0,0,0.0005\n")(common);
          WithFile("s.toml", SoundScene({.mesh = "box.obj", .organ = "unit=0.5\n"}) +
                                 "[[load]]\norgan='liver'\npoint=[0,0,0.025]\nradius=0.015\n"
                                 "force=[0,0,-0.125]\n")(common);
          WithFile("own.lcm", "package own; struct own_t { double x; }\n")(common);
        }) {}

  void Add(const std::string& name, const Variables& variables, std::vector<std::string> words) {
    BadInputs::Add(name, {.words = std::move(words),
                          .folder = {},
                          .environment = variables,
                          .memory = std::size_t{4} << 30});
  }
  /// Adds values of one variable, by name, each with the same command.
  void Values(const std::string& variable,
              const std::vector<std::pair<std::string, std::optional<std::string>>>& values,
              const std::vector<std::string>& words) {
    for (const auto& [name, value] : values) Add(variable + " " + name, {{variable, value}}, words);
  }
};

const std::vector<std::string> kCheck = {"check", "../common/s.toml"};

void AddFolders(Environment* e) {
  const std::vector<std::pair<std::string, std::optional<std::string>>> folders = {
      {"unset", std::nullopt},
      {"empty", ""},
      {"relative", "some/where"},
      {"missing", "/no/such/folder"},
      {"a file", (e->common() / "a_file").string()},
      {"unwritable", "/proc/self"},
      {"a device", "/dev/full"},
      {"of 100,000 bytes", "/" + std::string(100'000, 'x')},
      {"with a line break", (e->common() / "a\nb").string()}};
  // If HPDM_CACHE is unset, the other variables lead into the user's own cache.
  for (const char* variable : {"XDG_CACHE_HOME", "HOME"}) {
    for (const auto& [name, value] : folders) {
      Environment::Variables variables = {
          {"HPDM_CACHE", std::nullopt}, {"XDG_CACHE_HOME", std::nullopt}, {"HOME", std::nullopt}};
      variables.emplace_back(variable, value);
      e->Add(std::string(variable) + " " + name, variables, kCheck);
    }
  }
  for (const auto& [name, value] : folders) {
    if (value)
      e->Add("HPDM_CACHE " + name, {{"HOME", std::nullopt}, {"HPDM_CACHE", value}}, kCheck);
    e->Add("TMPDIR " + name, {{"TMPDIR", value}},
           {"run", "../common/s.toml", "--clock", "lockstep", "--seconds", "0.01", "--no-pictures",
            "--verbose", "--out", "o"});
  }
}

void AddNetworkAddresses(Environment* e) {
  e->Values("LCM_DEFAULT_URL",
            {{"without a provider", "garbage"},
             {"of no known provider", "garbage://"},
             {"of half an address", "udpm://239.255"},
             {"of no address", "udpm://999.1.2.3:7667"},
             {"of no multicast address", "udpm://10.1.2.3:7667"},
             {"of no port", "udpm://239.255.76.67:99999"},
             {"of no number", "udpm://239.255.76.67:port"},
             {"with a line break", "udpm://\n"},
             {"of 100,000 bytes", std::string(100'000, 'x')}},
            {"spy", "--once", "--seconds", "0.05"});
  e->Add("LCM_DEFAULT_URL of no known provider, published", {{"LCM_DEFAULT_URL", "garbage://"}},
         {"run", "../common/s.toml", "--live", "--clock", "lockstep", "--seconds", "0.01",
          "--no-pictures", "--out", "o"});
  e->Add("LCM_DEFAULT_URL of no known provider, not used", {{"LCM_DEFAULT_URL", "garbage://"}},
         kCheck);
}

void AddDisplays(Environment* e) {
  const std::vector<std::string> window = {
      "run", "../common/s.toml", "--window", "--seconds", "0.1", "--out", "o"};
  for (const auto& [name, value] : std::vector<std::pair<std::string, std::optional<std::string>>>{
           {"unset", std::nullopt}, {"empty", ""}, {"garbage", "garbage"}, {"nobody's", ":4711"}}) {
    e->Add("DISPLAY " + name, {{"DISPLAY", value}, {"WAYLAND_DISPLAY", std::nullopt}}, window);
  }
  const std::vector<std::string> picture = {
      "run", "../common/s.toml", "--clock", "lockstep", "--seconds", "0.01", "--out", "o"};
  e->Add("no EGL", {{"__EGL_VENDOR_LIBRARY_FILENAMES", "/no/such.json"}}, picture);
  e->Add("EGL of another platform, without pictures", {{"EGL_PLATFORM", "garbage"}}, kCheck);
}

void AddLocales(Environment* e) {
  for (const char* name : {"C", "POSIX", "", "garbage", "xx_YY.UTF-8", "../../etc/passwd"}) {
    e->Add("LC_ALL \"" + std::string(name) + "\"", {{"LC_ALL", name}}, kCheck);
  }
}

void AddDecimalCommas(Environment* e) {
  const Environment::Variables comma = {{"LC_ALL", kCommaLocale},
                                        {"LOCPATH", e->common().string()}};
  e->Add("a decimal comma: check", comma, {"check", "../common/s.toml"});
  e->Add("a decimal comma: solve", comma,
         {"solve", "../common/s.toml", "--out", "f.csv", "--json"});
  e->Add("a decimal comma: replay", comma,
         {"replay", "../common/motion.csv", "--scene", "../common/s.toml"});
  e->Add("a decimal comma: run", comma,
         {"run", "../common/s.toml", "--clock", "lockstep", "--seconds", "0.025", "--no-pictures",
          "--verbose", "--out", "o"});
  e->Add("a decimal comma on the command line", comma,
         {"run", "../common/s.toml", "--clock", "lockstep", "--seconds", "0,025", "--no-pictures",
          "--out", "o"});
  e->Add("a decimal comma: inspect", comma, {"inspect", "../common/box.obj", "--unit", "0.5"});
}

TEST(BadInput, EnvironmentsHaveTheOutcomesOfTheTable) {
  Environment e;
  AddFolders(&e);
  AddNetworkAddresses(&e);
  AddDisplays(&e);
  AddLocales(&e);
  if (!MakeCommaLocale(e.common())) GTEST_SKIP() << "no locale can be made; install locales";
  AddDecimalCommas(&e);
  e.Compare();
}

}  // namespace
}  // namespace hpdm
