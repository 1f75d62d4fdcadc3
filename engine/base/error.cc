#include "engine/base/error.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace hpdm {
namespace {

constexpr std::size_t kMaxLineLength = 2000;

// Returns the length of the text's first character in bytes, or 0 if it is invalid UTF-8 (RFC
// 3629).
std::size_t CharacterBytes(std::string_view text) {
  const auto byte = [text](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  const std::uint8_t first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t bytes = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4 || text.size() < bytes) return 0;
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
  }
  const std::uint8_t second = byte(1);
  const bool beyond = (first == 0xe0 && second < 0xa0) || (first == 0xed && second > 0x9f) ||
                      (first == 0xf0 && second < 0x90) || (first == 0xf4 && second > 0x8f);
  return beyond ? 0 : bytes;
}

bool IsControl(std::string_view character) {
  const auto first = static_cast<std::uint8_t>(character[0]);
  // U+0080 to U+009F are terminal escapes of one character.
  return first < 0x20 || first == 0x7f ||
         (first == 0xc2 && static_cast<std::uint8_t>(character[1]) < 0xa0);
}

bool ContinuesCharacter(char c) { return (static_cast<std::uint8_t>(c) & 0xc0) == 0x80; }

}  // namespace

std::string OneLine(std::string_view text) {
  constexpr char kHex[] = "0123456789abcdef";
  std::string line;
  line.reserve(text.size());
  while (!text.empty()) {
    const std::size_t bytes = CharacterBytes(text);
    const std::size_t taken = std::max<std::size_t>(bytes, 1);
    if (bytes > 0 && !IsControl(text)) {
      line.append(text, 0, bytes);
    } else if (text[0] == '\n') {
      line += "\\n";
    } else {
      for (std::size_t i = 0; i < taken; ++i) {
        line += {'\\', 'x', kHex[(text[i] >> 4) & 0xf], kHex[text[i] & 0xf]};
      }
    }
    text.remove_prefix(taken);
  }
  if (line.size() <= kMaxLineLength) return line;
  std::size_t head = kMaxLineLength / 2, tail = line.size() - kMaxLineLength / 2;
  while (ContinuesCharacter(line[head])) --head;
  while (tail < line.size() && ContinuesCharacter(line[tail])) ++tail;
  return line.substr(0, head) + "..." + line.substr(tail);
}

}  // namespace hpdm
