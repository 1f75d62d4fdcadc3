#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

#include "engine/base/error.h"
#include "engine/base/quoted_token.h"
#include "engine/mesh/files/mesh_file.h"

/// Shared by the readers of the three formats and by mesh_import.cc.
namespace hpdm::mesh_file {

MeshFile ReduceObj(std::string_view text, const std::string& path);
MeshFile ReduceStl(std::string_view bytes, const std::string& path);
MeshFile ReducePly(std::string_view bytes, const std::string& path);

/// Throws the InputError "path: what"; `what` ends with the remedy.
[[noreturn]] inline void Refuse(const std::string& path, const std::string& what) {
  throw InputError(path + ": " + what);
}

/// Returns the text without a UTF-8 byte-order mark.
inline std::string_view WithoutByteOrderMark(std::string_view text) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  return text.substr(text.starts_with(kMark) ? kMark.size() : 0);
}

/// Splits a text into tokens at white space and counts its lines, which end with '\n', '\r' or
/// "\r\n".
class TextCursor {
 public:
  TextCursor(std::string_view text, const std::string& path, std::size_t at = 0, int line = 1)
      : text_(text), path_(path), at_(at), line_(line) {}

  int line() const { return line_; }
  bool AtEnd() const { return at_ == text_.size(); }
  std::size_t position() const { return at_; }

  /// Returns the next token on this line; empty at the line's end. A backslash before the line's
  /// end joins the next line to this one.
  std::string_view NextInLine() {
    while (at_ < text_.size()) {
      if (IsBlank(text_[at_])) {
        ++at_;
      } else if (JoinsLines(at_)) {
        ++at_;
        EndLine();
      } else {
        break;
      }
    }
    return Token();
  }

  /// Returns the next token on this or any later line; empty at the end of the text.
  std::string_view Next() {
    while (at_ < text_.size() && (IsBlank(text_[at_]) || IsLineEnd(text_[at_]))) {
      if (IsLineEnd(text_[at_])) {
        EndLine();
      } else {
        ++at_;
      }
    }
    return Token();
  }

  /// Skips the rest of this line. A backslash at its end joins no line, because comments may end
  /// with a path.
  void SkipLine() {
    while (at_ < text_.size() && !IsLineEnd(text_[at_])) ++at_;
    if (at_ < text_.size()) EndLine();
  }

  /// Parses the token as a finite number in the range of float; refuses anything else.
  float Number(std::string_view token) const {
    std::string_view digits = token;
    if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    const float narrow = static_cast<float>(value);
    if (error != std::errc() || end != digits.data() + digits.size() || !std::isfinite(narrow)) {
      RefuseHere("expected a finite number, found " +
                 (token.empty() ? "nothing" : QuotedToken(token)) + "; export the mesh again");
    }
    return narrow;
  }

  [[noreturn]] void RefuseHere(const std::string& what) const {
    Refuse(path_, "line " + std::to_string(line_) + ": " + what);
  }

 private:
  static bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
  static bool IsLineEnd(char c) { return c == '\n' || c == '\r'; }
  bool JoinsLines(std::size_t at) const {
    return text_[at] == '\\' && at + 1 < text_.size() && IsLineEnd(text_[at + 1]);
  }

  void EndLine() {
    if (text_[at_] == '\r' && at_ + 1 < text_.size() && text_[at_ + 1] == '\n') ++at_;
    ++at_;
    ++line_;
  }

  std::string_view Token() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && !IsBlank(text_[at_]) && !IsLineEnd(text_[at_]) &&
           !JoinsLines(at_)) {
      ++at_;
    }
    return text_.substr(begin, at_ - begin);
  }

  std::string_view text_;
  const std::string& path_;
  std::size_t at_;
  int line_;
};

/// Refuses a mesh beyond the limits.
inline void CheckLimits(const MeshFile& file, const std::string& path) {
  if (file.vertices > MeshFileLimits::kVertices || file.corners > MeshFileLimits::kCorners) {
    Refuse(path, "more than " + std::to_string(MeshFileLimits::kVertices) +
                     " vertices or face corners; reduce the mesh");
  }
}

}  // namespace hpdm::mesh_file
