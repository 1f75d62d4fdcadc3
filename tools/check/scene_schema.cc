#include "tools/check/scene_schema.h"

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>
#include <string_view>
#include <vector>

#include "scenes/loader/scene_key_forms.h"
#include "scenes/loader/scene_keys.h"
#include "tools/shared/json_text.h"

// The assembler copies scenes/README.md in, for what the keys mean.
__asm__(".section .rodata\nhpdm_scenes_readme_begin:\n.incbin \"" HPDM_SCENES_README
        "\"\nhpdm_scenes_readme_end:\n.byte 0\n.previous\n");
extern "C" const char hpdm_scenes_readme_begin[], hpdm_scenes_readme_end[];

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;
using TableForms = std::map<std::string, TableForm, std::less<>>;

/// A key's row in a table of scenes/README.md.
struct KeyText {
  std::string unit, initial, meaning;
};
using KeyTexts = std::map<std::string, KeyText>;  // by "organ.lattice.cells"

std::string Trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(' ');
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(' ') - first + 1);
}

/// Returns the text without links, which lead nowhere in an editor, and without emphasis.
std::string Plain(const std::string& markdown) {
  static const std::regex kAside(R"( \(\[(below|above)\]\([^)]*\)\))");
  static const std::regex kLink(R"(\[([^\]]+)\]\([^)]*\))");
  static const std::regex kBold(R"(\*\*)");
  const std::string text = std::regex_replace(markdown, kAside, "");
  return std::regex_replace(std::regex_replace(text, kLink, "$1"), kBold, "");
}

KeyTexts ReadmeTexts() {
  KeyTexts texts;
  std::istringstream readme(
      std::string(hpdm_scenes_readme_begin,
                  static_cast<std::size_t>(hpdm_scenes_readme_end - hpdm_scenes_readme_begin)));
  std::string section, line;
  while (std::getline(readme, line)) {
    if (line.starts_with("#")) {
      section.clear();
      for (const char c : line) {
        if (c != '#' && c != ' ' && c != '[' && c != ']') section += c;
      }
      section = section == "Tables" ? "" : section + ".";
    } else if (line.starts_with("| `")) {
      std::vector<std::string> cells;
      std::istringstream row(line.substr(1));
      for (std::string cell; std::getline(row, cell, '|');) cells.push_back(Trimmed(cell));
      const std::string key = cells[0].substr(1, cells[0].size() - 2);
      // The rows of the file's own tables are key, form, number, meaning.
      if (cells.size() == 4) texts[section + key] = {"", "", Plain(cells[3])};
      if (cells.size() == 5) texts[section + key] = {cells[2], cells[3], Plain(cells[4])};
    }
  }
  return texts;
}

/// Returns whole numbers as integers, so that they read 1000 and not 1000.0.
Json NumberValue(double x) {
  return x == std::floor(x) && std::abs(x) < 1e15 ? Json(static_cast<long long>(x)) : Json(x);
}

Json NumberSchema(const char* type, const KeyForm& form) {
  Json schema = {{"type", type}};
  for (const double x : form.only) schema["enum"].push_back(NumberValue(x));
  if (!form.only.empty()) return schema;
  const Interval& range = form.range;
  if (std::isfinite(range.min)) {
    schema[range.above_min ? "exclusiveMinimum" : "minimum"] = NumberValue(range.min);
  }
  if (std::isfinite(range.max)) {
    schema[range.below_max ? "exclusiveMaximum" : "maximum"] = NumberValue(range.max);
  }
  return schema;
}

Json BooleanSchema(const KeyForm& form) {
  Json schema = {{"type", "boolean"}};
  for (const double x : form.only) schema["enum"].push_back(x != 0);
  return schema;
}

Json ArrayOf(const Json& items, std::size_t min, std::size_t max) {
  return {{"type", "array"}, {"items", items}, {"minItems", min}, {"maxItems", max}};
}

class SchemaWriter {
 public:
  Json TableSchema(const std::string& path) const {
    const TableForm& form = forms_.at(path);
    Json schema = {
        {"type", "object"}, {"additionalProperties", false}, {"properties", Json::object()}};
    for (const SceneTable& table : kSceneTables) {
      if (table.path != path) continue;
      for (const std::string_view key : table.keys) {
        const std::string name(key);
        schema["properties"][name] =
            KeySchema(path.empty() ? name : path + "." + name, form.keys.at(name));
      }
    }
    if (!form.required.empty()) schema["required"] = form.required;
    for (const auto& [a, b] : form.exclusive) {
      schema["allOf"].push_back({{"not", {{"required", {a, b}}}}});
    }
    return schema;
  }

 private:
  Json KeySchema(const std::string& path, const std::vector<KeyForm>& forms) const {
    Json schema;
    const auto text = texts_.find(path);
    if (text != texts_.end()) Describe(text->second, &schema);
    if (forms.size() == 1) {
      schema.update(FormSchema(path, forms[0]));
      return schema;
    }
    for (const KeyForm& form : forms) schema["anyOf"].push_back(FormSchema(path, form));
    return schema;
  }

  Json FormSchema(const std::string& path, const KeyForm& form) const {
    using Type = KeyForm::Type;
    switch (form.type) {
      case Type::kNumber:
        return NumberSchema("number", form);
      case Type::kVector:
        return ArrayOf(NumberSchema("number", form), 3, 3);
      case Type::kPoints:
        return ArrayOf(ArrayOf(NumberSchema("number", form), 3, 3), 2, form.max_size);
      case Type::kEdges:
        return ArrayOf(ArrayOf(ArrayOf(NumberSchema("number", form), 3, 3), 2, 2), 2,
                       form.max_size);
      case Type::kInteger:
        return NumberSchema("integer", form);
      case Type::kIntegers: {
        const Json integer = NumberSchema("integer", form);
        return {{"anyOf", {integer, ArrayOf(integer, 3, 3)}}};
      }
      case Type::kBoolean:
        return BooleanSchema(form);
      case Type::kString:
        return {{"type", "string"}};
      case Type::kName:  // its bytes are at least as many as its characters
        return {{"type", "string"}, {"pattern", "[^ ]"}, {"maxLength", form.max_size}};
      case Type::kFiles:
        return ArrayOf({{"type", "string"}}, 1, form.max_size);
      case Type::kChoice:
        return {{"enum", form.choices}};
      case Type::kTable:
        return TableSchema(path);
      case Type::kTables: {
        Json schema = {{"type", "array"}, {"items", TableSchema(path)}};
        if (form.max_size > 0) schema["maxItems"] = form.max_size;
        return schema;
      }
    }
    return {};
  }

  static void Describe(const KeyText& text, Json* schema) {
    std::string description = text.meaning;
    const auto add = [&description](const std::string& name, const std::string& value) {
      description += (description.empty() ? "" : ". ") + name + ": " + Plain(value);
    };
    if (!text.unit.empty()) add("Unit", text.unit);
    const bool elsewhere = text.initial == "required" || text.initial == "see below";
    if (!text.initial.empty() && !elsewhere) add("Default", text.initial);
    (*schema)["description"] = description;
    const std::string& quoted = text.initial;
    if (quoted.size() < 2 || quoted.front() != '`' || quoted.back() != '`') return;
    // TOML writes these values as JSON does.
    const Json value = Json::parse(quoted.substr(1, quoted.size() - 2), nullptr, false);
    if (!value.is_discarded()) (*schema)["default"] = value;
  }

  const TableForms forms_ = SceneKeyForms();
  const KeyTexts texts_ = ReadmeTexts();
};

}  // namespace

std::string SceneSchema() {
  Json schema = {{"$schema", "http://json-schema.org/draft-07/schema#"},
                 {"title", "HPDM scene"},
                 {"description", "A scene of hpdm run; `hpdm check --schema` prints this schema"}};
  schema.update(SchemaWriter().TableSchema(""));
  return JsonText(schema) + "\n";
}

}  // namespace hpdm
