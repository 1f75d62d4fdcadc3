#include "tools/shared/path_text.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>
#include <string>

namespace hpdm {
namespace {

TEST(PathText, EveryByteComesBackFromOneLineOfUtf8) {
  EXPECT_EQ(PathText("a b/\xC3\xA9"), "a b/\xC3\xA9");
  EXPECT_EQ(PathText("a\nb\x7F"), "a\\x0Ab\\x7F");
  EXPECT_EQ(PathText("a\\x0A"), "a\\\\x0A");
  EXPECT_EQ(PathText("\xC2\x85"), "\\xC2\\x85") << "a control character too";
  // Overlong, a surrogate, too large, torn.
  EXPECT_EQ(PathText("\xC0\x80\xED\xA0\x80\xF4\x90\x80\x80\xE2\x82"),
            "\\xC0\\x80\\xED\\xA0\\x80\\xF4\\x90\\x80\\x80\\xE2\\x82");
  std::mt19937 random(6);
  for (int trial = 0; trial < 2000; ++trial) {
    std::string bytes(random() % 12, '\0');
    for (char& c : bytes) c = static_cast<char>(random() % 4 == 0 ? '\\' : random());
    const std::string text = PathText(bytes);
    EXPECT_NO_THROW(nlohmann::json(text).dump()) << "it is UTF-8";
    std::string back;
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] != '\\') {
        back += text[i];
      } else if (text[++i] == '\\') {
        back += '\\';
      } else {
        back += static_cast<char>(std::stoi(text.substr(i + 1, 2), nullptr, 16));
        i += 2;
      }
    }
    EXPECT_EQ(back, bytes);
  }
}

}  // namespace
}  // namespace hpdm
