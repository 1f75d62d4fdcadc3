#include "tools/python/native/scene_key_edit.h"

#include <charconv>
#include <optional>
#include <string_view>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/quoted_token.h"
#include "scenes/loader/toml_document.h"

namespace hpdm {
namespace {

[[noreturn]] void Refuse(const Scene& scene, const std::string& key, const std::string& why) {
  throw InputError(scene.path.string() + ": " + Quoted(key) + ": " + why);
}

// The parts of "organ[0].material.young": organ, 0, material, young.
std::vector<std::string> PartsOf(const std::string& key) {
  std::vector<std::string> parts(1);
  for (const char c : key) {
    if (c == '.' || c == '[') {
      if (!parts.back().empty() || c == '.') parts.emplace_back();
    } else if (c != ']') {
      parts.back() += c;
    }
  }
  return parts;
}

bool IsBareKey(const std::string& part) {
  return !part.empty() &&
         part.find_first_not_of("abcdefghijklmnopqrstuvwxyz_0123456789") == std::string::npos;
}

// Finds an element by its number or by its name.
const toml::node* ElementOf(const toml::array& tables, const std::string& part) {
  std::size_t number = 0;
  const char* const end = part.data() + part.size();
  const auto [parsed, error] = std::from_chars(part.data(), end, number);
  if (error == std::errc() && parsed == end) return tables.get(number);
  for (const toml::node& element : tables) {
    const toml::table* table = element.as_table();
    if (table != nullptr && (*table)["name"].value_or(std::string_view()) == part) return &element;
  }
  return nullptr;
}

// Byte of a place in the text; the column counts characters.
std::size_t At(const std::string& text, const toml::source_position& place) {
  std::size_t at = 0;
  for (toml::source_index line = 1; line < place.line; ++line) at = text.find('\n', at) + 1;
  for (toml::source_index column = 1; column < place.column; ++column) {
    ++at;
    while (at < text.size() && (static_cast<unsigned char>(text[at]) & 0xc0) == 0x80) ++at;
  }
  return at;
}

// The text with a line after the header of `table`; the root has none.
std::string WithLine(const std::string& text, const toml::table& table, bool is_root,
                     const std::string& line) {
  std::size_t at = 0;
  if (!is_root) {
    at = text.find('\n', At(text, table.source().begin));
    at = at == std::string::npos ? text.size() : at + 1;
  }
  std::string edited = text;
  return edited.insert(at, line + "\n");
}

}  // namespace

std::string WithKey(const Scene& scene, const std::string& key, const std::string& value) {
  const TomlDocument document = ParseToml(scene.source_text, scene.path);
  const std::vector<std::string> parts = PartsOf(key);
  const toml::node* node = &document.root;
  std::size_t found = 0;
  for (; found < parts.size(); ++found) {
    const toml::node* next = nullptr;
    if (const toml::table* table = node->as_table()) next = table->get(parts[found]);
    if (const toml::array* tables = node->as_array()) {
      next = ElementOf(*tables, parts[found]);
      if (next == nullptr) Refuse(scene, key, "there is no " + Quoted(parts[found]));
    }
    if (next == nullptr) break;
    node = next;
  }
  if (found == parts.size()) {
    if (node->is_table() || node->is_array_of_tables()) {
      Refuse(scene, key, "is a table; name one of its keys");
    }
    const std::size_t begin = At(document.text, node->source().begin);
    const std::size_t end = At(document.text, node->source().end);
    std::string edited = document.text;
    return edited.replace(begin, end - begin, value);
  }
  const toml::table* table = node->as_table();
  if (table == nullptr) Refuse(scene, key, "has no further keys");
  const bool is_root = table == &document.root;
  const std::size_t start = is_root ? 0 : At(document.text, table->source().begin);
  if (!is_root && document.text[start] != '[') {
    Refuse(scene, key, "its table is written in one line; set the whole table in the file");
  }
  std::string line;
  for (std::size_t p = found; p < parts.size(); ++p) {
    if (!IsBareKey(parts[p])) Refuse(scene, key, "is not a key");
    line += (p == found ? "" : ".") + parts[p];
  }
  return WithLine(document.text, *table, is_root, line + " = " + value);
}

}  // namespace hpdm
