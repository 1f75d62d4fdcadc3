#include "scenes/loader/toml_document.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/quoted_token.h"

namespace hpdm {
namespace {

/// Refuses dotted keys (a.b.c) with more parts than any scene needs, before parsing. The parser
/// limits the depth of values but not of dotted keys, and frees their tables recursively: a long
/// key would overflow the stack. The check skips strings and comments as TOML delimits them. It
/// restarts the count at every character that cannot be inside a key.
constexpr int kMaxKeyDots = 8;

class DottedKeyCheck {
 public:
  explicit DottedKeyCheck(const TomlDocument& document)
      : document_(document), text_(document.text) {}

  void Run() {
    int dots = 0;
    while (at_ < text_.size()) {
      switch (text_[at_]) {
        case '"':
        case '\'':
          SkipString();
          continue;
        case '#':
          SkipTo('\n');
          continue;
        case '.':
          if (++dots > kMaxKeyDots) {
            FailAt(document_, Place(), "TOML syntax",
                   "the dotted key has too many parts; use at most " + std::to_string(kMaxKeyDots) +
                       " dots");
          }
          break;
        case '\n':
        case '=':
        case ',':
        case '[':
        case ']':
        case '{':
        case '}':
          dots = 0;
          break;
        default:
          break;
      }
      ++at_;
    }
  }

 private:
  void SkipTo(char c) { at_ = std::min(text_.find(c, at_), text_.size()); }

  void SkipString() {
    const char quote = text_[at_];
    const std::string triple(3, quote);
    if (text_.substr(at_, 3) == triple) {
      at_ += 3;
      while (at_ < text_.size() && text_.substr(at_, 3) != triple) Step(quote);
      // The string may end with up to two quotes, directly before the closing three.
      for (int i = 0; i < 5 && at_ < text_.size() && text_[at_] == quote; ++i) ++at_;
      return;
    }
    ++at_;
    while (at_ < text_.size() && text_[at_] != quote && text_[at_] != '\n') Step(quote);
    if (at_ < text_.size() && text_[at_] == quote) ++at_;
  }

  void Step(char quote) {
    at_ += quote == '"' && text_[at_] == '\\' ? 2 : 1;
    at_ = std::min(at_, text_.size());
  }

  toml::source_position Place() const {
    toml::source_position place{1, 1};
    for (const char c : text_.substr(0, at_)) {
      if (c == '\n') {
        ++place.line;
        place.column = 1;
      } else if ((static_cast<unsigned char>(c) & 0xc0) != 0x80) {
        ++place.column;
      }
    }
    return place;
  }

  const TomlDocument& document_;
  const std::string_view text_;
  std::size_t at_ = 0;
};

void CheckDepth(const TomlDocument& document, const toml::node& node, int depth) {
  if (depth > kMaxTomlDepth) {
    FailAt(document, node.source().begin, "TOML",
           "tables and arrays are nested too deeply; use at most " + std::to_string(kMaxTomlDepth) +
               " levels");
  }
  if (const auto* table = node.as_table()) {
    for (const auto& [key, child] : *table) CheckDepth(document, child, depth + 1);
  } else if (const auto* array = node.as_array()) {
    for (const toml::node& child : *array) CheckDepth(document, child, depth + 1);
  }
}

std::string ReadText(const std::filesystem::path& path) {
  const auto fail = [&path](const std::string& problem) {
    throw InputError(path.string() + ": " + problem);
  };
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (std::filesystem::is_directory(status)) fail("is a folder; give a scene file (.toml)");
  // Reading a pipe could block, and a device may have no end.
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    fail("not a regular file; give a scene file (.toml)");
  }
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::string text(kMaxTomlBytes + 1, '\0');
  if (file) file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!file && !file.eof()) {
    if (errno == ENOENT) fail("no such file; check the path");
    const std::string reason = errno != 0 ? std::strerror(errno) : "read error";
    fail("cannot be read: " + reason + "; check the " +
         (errno == EACCES ? "file's permissions" : "path"));
  }
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > kMaxTomlBytes) {
    fail("is larger than " + std::to_string(kMaxTomlBytes) +
         " bytes; give a scene file (.toml), meshes are separate files");
  }
  return text;
}

void AppendText(const toml::node& value, std::string* out) {
  if (out->size() > kMaxQuoted) return;
  if (const auto* integer = value.as_integer()) {
    *out += std::to_string(integer->get());
  } else if (const auto* number = value.as_floating_point()) {
    char digits[32];
    out->append(digits, std::to_chars(digits, digits + sizeof(digits), number->get()).ptr);
  } else if (const auto* boolean = value.as_boolean()) {
    *out += boolean->get() ? "true" : "false";
  } else if (const auto* text = value.as_string()) {
    *out += Quoted(text->get());
  } else if (const auto* elements = value.as_array()) {
    *out += '[';
    for (std::size_t i = 0; i < elements->size() && out->size() <= kMaxQuoted; ++i) {
      if (i > 0) *out += ", ";
      AppendText((*elements)[i], out);
    }
    *out += ']';
  } else {
    *out += value.is_table() ? "a table" : "a date or time";
  }
}

}  // namespace

void FailAt(const TomlDocument& document, const toml::source_position& place,
            std::string_view subject, std::string_view message) {
  std::string line = document.path.string();
  line += ':' + std::to_string(place.line) + ':' + std::to_string(place.column) + ": ";
  line.append(subject).append(": ").append(message);
  throw InputError(line);
}

std::string ValueText(const toml::node& value) {
  std::string text;
  AppendText(value, &text);
  return value.is_string() ? text : Shortened(text, kMaxQuoted);
}

TomlDocument ParseToml(std::string text, const std::filesystem::path& path) {
  TomlDocument document{path, std::move(text), {}};
  DottedKeyCheck(document).Run();
  try {
    document.root = toml::parse(document.text);
  } catch (const toml::parse_error& error) {
    std::string what(error.description());
    what += "; correct the text there (TOML 1.0, see toml.io)";
    FailAt(document, error.source().begin, "TOML syntax", what);
  }
  CheckDepth(document, document.root, 0);
  return document;
}

TomlDocument ReadToml(const std::filesystem::path& path) { return ParseToml(ReadText(path), path); }

}  // namespace hpdm
