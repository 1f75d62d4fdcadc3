#pragma once

#include <string>
#include <string_view>

namespace hpdm {

/// Text between tags and in quoted attributes: & < > " ' are replaced, other control characters and
/// what is not UTF-8 become U+FFFD. So no name from a log can be read as HTML.
std::string EscapeHtml(std::string_view text);

/// JSON for the inside of a <script>: nothing in it ends the script or opens a comment.
std::string EscapeScript(const std::string& json);

/// The text with every `what` replaced.
std::string Replaced(std::string text, std::string_view what, std::string_view with);

}  // namespace hpdm
