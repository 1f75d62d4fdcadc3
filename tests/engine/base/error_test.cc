#include "engine/base/error.h"

#include <gtest/gtest.h>

namespace hpdm {
namespace {

TEST(OneLine, LeavesTextOfAnyScriptAlone) {
  const std::string text = "mesh.obj:3: f\xc3\xbcr \xe8\x82\x9d \xf0\x9f\xab\x80; give metres";
  EXPECT_EQ(OneLine(text), text);
}

TEST(OneLine, UntrustedTextCannotBreakTheLineOrMoveTheCursor) {
  EXPECT_EQ(OneLine("a\nb\r\t\x7f"), "a\\nb\\x0d\\x09\\x7f");
  EXPECT_EQ(OneLine("\x1b[2J"), "\\x1b[2J");
  EXPECT_EQ(OneLine("\xc2\x9b"
                    "2J"),
            "\\xc2\\x9b2J")
      << "the same in one character";
  EXPECT_EQ(OneLine(std::string("a\0b", 3)), "a\\x00b");
}

TEST(OneLine, EscapesInvalidUtf8) {
  // Cut, overlong, half a surrogate pair, beyond Unicode, a lone continuation byte.
  EXPECT_EQ(OneLine("\xe8\x82"), "\\xe8\\x82");
  EXPECT_EQ(OneLine("\xc0\xaf"), "\\xc0\\xaf");
  EXPECT_EQ(OneLine("\xed\xa0\x80"), "\\xed\\xa0\\x80");
  EXPECT_EQ(OneLine("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");
  EXPECT_EQ(OneLine("\x80"), "\\x80");
}

TEST(OneLine, LongMessagesKeepFileAndRemedy) {
  const std::string line =
      InputError("a.toml:1: " + std::string(1'000'000, '\n') + "; rename it").what();
  // Length of both halves and the dots between them.
  EXPECT_LE(line.size(), 2003u);
  EXPECT_TRUE(line.starts_with("a.toml:1: \\n"));
  EXPECT_TRUE(line.ends_with("; rename it"));
}

}  // namespace
}  // namespace hpdm
