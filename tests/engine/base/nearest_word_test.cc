#include "engine/base/nearest_word.h"

#include <gtest/gtest.h>

#include <string>

namespace hpdm {
namespace {

constexpr std::string_view kCommands[] = {"run", "replay", "report", "check", "inspect"};

TEST(NearestWord, OneWrongLetterOfAShortWordIsFound) {
  for (const std::string_view word : {"runn", "rn", "ran", "rnu"}) {
    EXPECT_EQ(NearestWord(word, kCommands), "run") << word;
  }
}

TEST(NearestWord, AThirdOfTheLettersMayBeWrong) {
  EXPECT_EQ(NearestWord("inspekkt", kCommands), "inspect") << "two of seven letters";
  EXPECT_EQ(NearestWord("inzpekkt", kCommands), "") << "three of seven letters";
}

TEST(NearestWord, TheNearerOfTwoIsTaken) {
  EXPECT_EQ(NearestWord("reprot", kCommands), "report");
  EXPECT_EQ(NearestWord("relpay", kCommands), "replay");
}

TEST(NearestWord, UnrelatedEmptyAndEndlessWordsHaveNone) {
  EXPECT_EQ(NearestWord("fly", kCommands), "");
  EXPECT_EQ(NearestWord("", kCommands), "");
  EXPECT_EQ(NearestWord(std::string(1'000'000, 'r'), kCommands), "");
  EXPECT_EQ(NearestWord("run", {}), "");
}

}  // namespace
}  // namespace hpdm
