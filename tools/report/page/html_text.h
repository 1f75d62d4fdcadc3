#pragma once

#include <string>
#include <string_view>

namespace hpdm {

/// Escapes text for HTML elements and quoted attributes: replaces & < > " '. Control characters and
/// bytes that are not UTF-8 become U+FFFD. So no name from a log is read as HTML.
std::string EscapeHtml(std::string_view text);

/// Escapes JSON for the inside of a <script>, so that it does not end the script or open a comment.
std::string EscapeScript(const std::string& json);

/// Returns the text with every `what` replaced by `with`.
std::string Replaced(std::string text, std::string_view what, std::string_view with);

}  // namespace hpdm
