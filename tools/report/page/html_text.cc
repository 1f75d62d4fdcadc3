#include "tools/report/page/html_text.h"

#include <algorithm>
#include <cstddef>

#include "tools/shared/path_text.h"

namespace hpdm {

std::string Replaced(std::string text, std::string_view what, std::string_view with) {
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += with.size()) {
    text.replace(at, what.size(), with);
  }
  return text;
}

std::string EscapeHtml(std::string_view text) {
  std::string html;
  while (!text.empty()) {
    const std::size_t length = CharacterLength(text);
    const char c = text[0];
    if (length == 0 || (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') ||
        c == 0x7f) {
      html += "\ufffd";
    } else if (c == '&') {
      html += "&amp;";
    } else if (c == '<') {
      html += "&lt;";
    } else if (c == '>') {
      html += "&gt;";
    } else if (c == '"') {
      html += "&quot;";
    } else if (c == '\'') {
      html += "&#39;";
    } else {
      html += text.substr(0, length);
    }
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return html;
}

std::string EscapeScript(const std::string& json) {
  // In JSON "<" occurs only in strings. U+2028 and U+2029 end lines in older scripts.
  return Replaced(Replaced(Replaced(json, "<", "\\u003c"), "\u2028", "\\u2028"), "\u2029",
                  "\\u2029");
}

}  // namespace hpdm
