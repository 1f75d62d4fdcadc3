#include "scenes/loader/toml_document.h"

#include <toml++/toml.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <utility>

#include "engine/base/error.h"

namespace hpdm {
namespace {

constexpr std::size_t kMaxShown = 60;  // bytes of a value in a message

/// Cuts between two characters (UTF-8).
std::string Shortened(std::string_view text, std::size_t max_bytes) {
  if (text.size() <= max_bytes) return std::string(text);
  std::size_t end = max_bytes;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) --end;
  return std::string(text.substr(0, end)) + "...";
}

template <typename T>
std::string NumberText(T number) {
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof(buffer), number).ptr;
  return std::string(buffer, end);
}

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

  TomlPlace Place() const {
    TomlPlace place;
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

/// Returns the parent's place for tables that only a longer key implies: they have none.
TomlPlace PlaceOf(const toml::source_region& region, TomlPlace parent) {
  if (!region.begin) return parent;
  return {region.begin.line, region.begin.column};
}

TomlValue Convert(const TomlDocument& document, const toml::node& node, TomlPlace parent,
                  int depth) {
  TomlValue out;
  out.place = PlaceOf(node.source(), parent);
  out.end =
      node.source().end ? TomlPlace{node.source().end.line, node.source().end.column} : out.place;
  if (depth > kMaxTomlDepth) {
    FailAt(document, out.place, "TOML",
           "tables and arrays are nested too deeply; use at most " + std::to_string(kMaxTomlDepth) +
               " levels");
  }
  if (const auto* table = node.as_table()) {
    TomlTable entries;
    entries.reserve(table->size());
    for (auto&& [key, child] : *table) {
      const TomlPlace place = PlaceOf(key.source(), out.place);
      entries.push_back(
          {std::string(key.str()), place, Convert(document, child, place, depth + 1)});
    }
    out.value = std::move(entries);
  } else if (const auto* array = node.as_array()) {
    TomlArray elements;
    elements.reserve(array->size());
    for (const toml::node& child : *array) {
      elements.push_back(Convert(document, child, out.place, depth + 1));
    }
    out.value = std::move(elements);
  } else if (const auto* text = node.as_string()) {
    out.value = text->get();
  } else if (const auto* integer = node.as_integer()) {
    out.value = integer->get();
  } else if (const auto* number = node.as_floating_point()) {
    out.value = number->get();
  } else if (const auto* boolean = node.as_boolean()) {
    out.value = boolean->get();
  } else {
    out.value = TomlDate();
  }
  return out;
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

void AppendText(const TomlValue& value, std::string* out) {
  if (out->size() > kMaxShown) return;
  if (const auto* integer = std::get_if<std::int64_t>(&value.value)) {
    *out += NumberText(*integer);
  } else if (const auto* number = std::get_if<double>(&value.value)) {
    *out += NumberText(*number);
  } else if (const auto* boolean = std::get_if<bool>(&value.value)) {
    *out += *boolean ? "true" : "false";
  } else if (const auto* text = std::get_if<std::string>(&value.value)) {
    *out += Quoted(*text);
  } else if (const auto* elements = std::get_if<TomlArray>(&value.value)) {
    *out += '[';
    for (std::size_t i = 0; i < elements->size() && out->size() <= kMaxShown; ++i) {
      if (i > 0) *out += ", ";
      AppendText((*elements)[i], out);
    }
    *out += ']';
  } else if (std::holds_alternative<TomlTable>(value.value)) {
    *out += "a table";
  } else {
    *out += "a date or time";
  }
}

}  // namespace

void FailAt(const TomlDocument& document, TomlPlace place, std::string_view subject,
            std::string_view message) {
  std::string line = document.path.string();
  line += ':' + std::to_string(place.line) + ':' + std::to_string(place.column) + ": ";
  line.append(subject).append(": ").append(message);
  throw InputError(line);
}

std::string Quoted(std::string_view text) { return '"' + Shortened(text, kMaxShown) + '"'; }

std::string ValueText(const TomlValue& value) {
  std::string text;
  AppendText(value, &text);
  return std::holds_alternative<std::string>(value.value) ? text : Shortened(text, kMaxShown);
}

TomlDocument ParseToml(std::string text, const std::filesystem::path& path) {
  TomlDocument document;
  document.path = path;
  document.text = std::move(text);
  DottedKeyCheck(document).Run();
  try {
    const toml::table root = toml::parse(document.text);
    document.root = Convert(document, root, TomlPlace(), 0);
  } catch (const toml::parse_error& error) {
    std::string what(error.description());
    what += "; correct the text there (TOML 1.0, see toml.io)";
    FailAt(document, PlaceOf(error.source(), TomlPlace()), "TOML syntax", what);
  }
  return document;
}

TomlDocument ReadToml(const std::filesystem::path& path) { return ParseToml(ReadText(path), path); }

}  // namespace hpdm
