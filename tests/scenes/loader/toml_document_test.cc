#include <chrono>
#include <random>

#include "scenes/loader/scene_edit.h"
#include "tests/support/scene_fixture.h"

namespace hpdm {
namespace {

/// Returns the seconds until the text is refused; the message must be one line of at most 1.1 kB.
double SecondsToRefuse(const std::string& text) {
  const auto start = std::chrono::steady_clock::now();
  const std::string error = ErrorOf([&] { ParseScene(text, "s.toml"); });
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  EXPECT_FALSE(error.empty());
  EXPECT_EQ(error.find_first_of("\n\r"), std::string::npos) << error;
  EXPECT_LT(error.size(), 1100u);
  return seconds.count();
}

// Generous: a megabyte takes some 0.1 s in a release build, and sanitizers are ten times slower.
constexpr double kBoundedSeconds = 10;

TEST(HostileToml, AMegabyteOfGarbageIsRefusedWithOneLineInBoundedTime) {
  std::mt19937 random(1);
  const std::string printable = "abc.=[]{}\"'#,\n 0123456789-_+\\\t";
  for (int round = 0; round < 20; ++round) {
    std::string bytes(1'000'000, '\0'), text(1'000'000, '\0');
    for (char& c : bytes) c = static_cast<char>(random());
    for (char& c : text) c = printable[random() % printable.size()];
    EXPECT_LT(SecondsToRefuse(bytes), kBoundedSeconds);
    EXPECT_LT(SecondsToRefuse(text), kBoundedSeconds);
  }
}

TEST(HostileToml, AMegabyteOfOneThingIsRefusedWithOneLineInBoundedTime) {
  const std::pair<const char*, const char*> repeated[] = {
      {"", "a"},          {"", "\n[[organ]]\nname='x'"},
      {"a=", "["},        {"a=", "{a="},
      {"a=[", "1,"},      {"a=\"", "x"},
      {"a='''", "\n"},    {"a=", "9"},
      {"a=\"\"\"", "\\"}, {"[", "a."},
      {"", "a."},         {"", "\"\"."},
      {"a=[", "'''',"},   {"#", "\r"},
      {"a", "\xc3\xa9"}};
  for (const auto& [start, unit] : repeated) {
    SCOPED_TRACE(std::string(start) + unit);
    std::string text = start;
    while (text.size() < 1'000'000) text += unit;
    EXPECT_LT(SecondsToRefuse(text), kBoundedSeconds);
  }
}

TEST(HostileToml, NestingBeyondAnySceneIsRefused) {
  const auto nested = [](int depth, const std::string& open, const std::string& close) {
    std::string text = "a=";
    for (int i = 0; i < depth; ++i) text += open;
    text += "1";
    for (int i = 0; i < depth; ++i) text += close;
    return text;
  };
  const auto error = [](const std::string& text) {
    return ErrorOf([&] { ParseScene(text, "s.toml"); });
  };
  EXPECT_TRUE(Contains(error(nested(20, "[", "]")), "a: is not a known key"));
  EXPECT_TRUE(Contains(error(nested(100, "[", "]")), "TOML: tables and arrays are nested too"));
  // Also refused: the deepest nesting that the parser accepts, with the longest allowed keys.
  EXPECT_TRUE(Contains(error(nested(250, "{a.a.a.a.a.a.a.a.a=", "}")), "nested too deeply"));
  EXPECT_TRUE(Contains(error(nested(100'000, "[", "]")), "TOML syntax"));
  EXPECT_TRUE(Contains(error("a . a.a.a.a.a.a.a.a.a=1"), "s.toml:1:20: TOML syntax: the dotted"));
}

TEST(HostileToml, DotsInStringsCommentsAndNumbersDoNotCount) {
  const std::string text =
      "# ..............\n"
      "a = '../../../../../../..'  # ............\n"
      "b = \"............\\\"............\"\n"
      "c = '''\n............''' \n"
      "d = \"\"\"\"............\"............\\\"\"\"\"\"\"\n"
      "e = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1]\n"
      "'............' = 1\n"
      "f.g.h = 1\n";
  // The text is TOML, so the first fault is the scene's.
  EXPECT_TRUE(Contains(ErrorOf([&] { ParseScene(text, "s.toml"); }), ": is not a known key"));
}

TEST(HostileToml, DamagedScenesLoadOrGiveOneLine) {
  const SceneFolder folder;
  const std::string good =
      ReadFile(std::filesystem::path(HPDM_SOURCE_DIR) / "scenes/liver_palpation.toml");
  int refused = 0;
  const auto load = [&](const std::string& text) {
    const std::string error = ErrorOf([&] { ParseScene(text, folder.path() / "s.toml"); });
    EXPECT_EQ(error.find_first_of("\n\r"), std::string::npos) << error;
    refused += error.empty() ? 0 : 1;
  };
  for (std::size_t size = 0; size < good.size(); size += 7) load(good.substr(0, size));
  std::mt19937 random(2);
  for (int round = 0; round < 3000; ++round) {
    std::string text = good;
    const int changes = 1 + static_cast<int>(random() % 4);
    for (int i = 0; i < changes; ++i) {
      const std::size_t at = random() % text.size();
      const std::size_t from = random() % good.size();
      switch (random() % 3) {
        case 0:
          text[at] = static_cast<char>(random());
          break;
        case 1:
          text.erase(at, random() % 20);
          break;
        default:
          text.insert(at, good.substr(from, random() % 20));
          break;
      }
    }
    load(text);
  }
  EXPECT_GT(refused, 1000);  // of about 3,400; damage in comments is harmless
}

}  // namespace
}  // namespace hpdm
