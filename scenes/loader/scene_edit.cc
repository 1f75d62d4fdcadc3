#include "scenes/loader/scene_edit.h"

#include <algorithm>
#include <map>
#include <set>

#include "engine/base/error.h"
#include "engine/base/text_list.h"
#include "scenes/loader/scene_parts.h"
#include "scenes/loader/toml_document.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

std::string StringText(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted.append("\"");
}

std::string ValueOf(const SceneValue& value) {
  if (const bool* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  if (const int* integer = std::get_if<int>(&value)) return std::to_string(*integer);
  if (const double* number = std::get_if<double>(&value)) {
    return ValueText(toml::value<double>(*number));
  }
  if (const std::string* text = std::get_if<std::string>(&value)) return StringText(*text);
  const auto& three = std::get<std::array<int, 3>>(value);
  std::string text;
  for (const int integer : three) AppendToList(std::to_string(integer), &text);
  return "[" + text + "]";
}

/// Collects changes at places of the original text and applies them together.
class TextEdits {
 public:
  explicit TextEdits(const TomlDocument& document) : document_(document) {
    lines_.push_back(0);
    for (std::size_t i = 0; i < document.text.size(); ++i) {
      if (document.text[i] == '\n') lines_.push_back(i + 1);
    }
  }

  /// Returns the number of bytes before a place.
  std::size_t At(toml::source_position place) const {
    std::size_t at = lines_[place.line - 1];
    for (std::uint32_t column = 1; column < place.column; ++column) {
      ++at;
      while (at < Text().size() && (static_cast<unsigned char>(Text()[at]) & 0xc0) == 0x80) ++at;
    }
    return at;
  }
  char CharAt(toml::source_position place) const {
    const std::size_t at = At(place);
    return at < Text().size() ? Text()[at] : '\0';
  }

  std::string Slice(const toml::source_region& place) const {
    return Text().substr(At(place.begin), At(place.end) - At(place.begin));
  }

  void Replace(std::size_t begin, std::size_t end, std::string with) {
    edits_.push_back({begin, end, std::move(with)});
  }
  void Replace(const toml::source_region& place, std::string with) {
    Replace(At(place.begin), At(place.end), std::move(with));
  }
  /// Inserts `inserted` (without a line end) as a line. Several after one line keep their order.
  void InsertAfterLine(std::uint32_t line, const std::string& inserted) {
    const std::size_t at = line < lines_.size() ? lines_[line] : Text().size();
    const bool ended = at > 0 && Text()[at - 1] == '\n';
    std::string line_and_end;
    if (!ended) line_and_end.append("\n");
    line_and_end.append(inserted);
    if (ended) line_and_end.append("\n");
    Replace(at, at, std::move(line_and_end));
  }
  /// Returns the blanks at the line's start.
  std::string Indent(std::uint32_t line) const {
    const std::size_t begin = lines_[line - 1];
    return Text().substr(begin, Text().find_first_not_of(" \t", begin) - begin);
  }
  void CommentOut(std::uint32_t first, std::uint32_t last) {
    for (std::uint32_t line = first; line <= last; ++line) {
      const std::size_t at = lines_[line - 1] + Indent(line).size();
      if (at >= Text().size() || Text()[at] == '\n' || Text()[at] == '#') continue;
      if (commented_.insert(line).second) Replace(at, at, "# ");
    }
  }

  std::string Result() {
    std::stable_sort(edits_.begin(), edits_.end(),
                     [](const Edit& a, const Edit& b) { return a.begin < b.begin; });
    std::string text;
    std::size_t at = 0;
    for (const Edit& edit : edits_) {
      text += Text().substr(at, edit.begin - at) + edit.with;
      at = edit.end;
    }
    return text + Text().substr(at);
  }

 private:
  struct Edit {
    std::size_t begin, end;
    std::string with;
  };
  const std::string& Text() const { return document_.text; }

  const TomlDocument& document_;
  std::vector<std::size_t> lines_;
  std::vector<Edit> edits_;
  std::set<std::uint32_t> commented_;
};

/// Returns the value's last line; a header's table ends with its last entry.
std::uint32_t LastLine(const toml::node& value) {
  std::uint32_t last = value.source().end.line;
  if (const auto* table = value.as_table(); table != nullptr && !table->is_inline()) {
    for (const auto& [key, child] : *table) last = std::max(last, LastLine(child));
  } else if (const auto* elements = value.as_array()) {
    for (const toml::node& element : *elements) last = std::max(last, LastLine(element));
  }
  return last;
}

/// Applies the edits of one organ.
class OrganText {
 public:
  OrganText(const TomlDocument& document, const toml::table& organ, TextEdits* text)
      : organ_(organ), text_(*text) {
    if (organ.is_inline()) {
      FailAt(document, organ.source().begin, "organ", "is an inline table; write it as [[organ]]");
    }
  }

  void Apply(const OrganEdit& edit) {
    for (const std::string& name : edit.removed_tables) {
      if (const auto entry = organ_.find(name); entry != organ_.end()) {
        Remove(entry->first, entry->second);
      }
    }
    std::map<std::string, std::vector<SceneKeyEdit>> by_table;
    for (const SceneKeyEdit& key : edit.keys) by_table[key.table].push_back(key);
    for (const auto& [table, keys] : by_table) {
      if (table.empty()) {
        EditTable(organ_, "", keys);
      } else if (const toml::node* value = organ_.get(table)) {
        EditNamedTable(table, *value->as_table(), keys);
      } else {
        AddTable(table, keys);
      }
    }
  }

 private:
  // True for [table] and [[table]], false for key = {...}, key = [{...}] and key.part = ....
  bool HasHeader(const toml::node& value) const {
    if (const auto* elements = value.as_array()) {
      return elements->is_array_of_tables() && !elements->front().as_table()->is_inline();
    }
    return value.is_table() && text_.CharAt(value.source().begin) == '[';
  }

  // Returns the last line of a table's own keys, without the tables under their own headers.
  std::uint32_t LastOwnLine(const toml::table& table) const {
    std::uint32_t last = table.source().begin.line;
    for (const auto& [key, value] : table) {
      // The lines of an array of inline tables may be indented in their own way.
      if (HasHeader(value) || value.is_array_of_tables()) continue;
      last = std::max(last, LastLine(value));
    }
    return last;
  }

  static bool Given(const SceneKeyEdit& edit) {
    return !std::holds_alternative<std::monostate>(edit.value);
  }

  // `prefix` precedes inserted keys of a table that is written with dotted keys.
  void EditTable(const toml::table& table, const std::string& prefix,
                 const std::vector<SceneKeyEdit>& keys) {
    const std::uint32_t last = LastOwnLine(table);
    const std::string indent = text_.Indent(last);
    for (const SceneKeyEdit& edit : keys) {
      const auto entry = table.find(edit.key);
      if (entry == table.end()) {
        if (Given(edit)) {
          text_.InsertAfterLine(last, indent + prefix + edit.key + " = " + ValueOf(edit.value));
        }
      } else if (Given(edit)) {
        text_.Replace(entry->second.source(), ValueOf(edit.value));
      } else {
        text_.CommentOut(entry->first.source().begin.line, entry->second.source().end.line);
      }
    }
  }

  void EditNamedTable(const std::string& name, const toml::table& table,
                      const std::vector<SceneKeyEdit>& keys) {
    if (table.is_inline()) return EditInline(table, keys);
    EditTable(table, HasHeader(table) ? "" : name + ".", keys);
  }

  void EditInline(const toml::table& table, const std::vector<SceneKeyEdit>& keys) {
    std::string inside;
    std::set<std::string> edited;
    const auto add = [&inside](const std::string& key, const std::string& value) {
      inside.append(inside.empty() ? " " : ", ").append(key).append(" = ").append(value);
    };
    for (const SceneKeyEdit& edit : keys) {
      edited.insert(edit.key);
      if (Given(edit)) add(edit.key, ValueOf(edit.value));
    }
    for (const auto& [key, value] : table) {
      const std::string name(key);
      if (!edited.contains(name)) add(name, text_.Slice(value.source()));
    }
    text_.Replace(table.source(), std::string("{").append(inside).append(" }"));
  }

  void AddTable(const std::string& table, const std::vector<SceneKeyEdit>& keys) {
    const std::uint32_t last = LastOwnLine(organ_);
    const std::string indent = text_.Indent(last) + "  ";
    std::string added = "\n";
    added.append(indent).append("[organ.").append(table).append("]");
    bool any = false;
    for (const SceneKeyEdit& edit : keys) {
      if (!Given(edit)) continue;
      added.append("\n").append(indent).append(edit.key).append(" = ");
      added.append(ValueOf(edit.value));
      any = true;
    }
    if (any) text_.InsertAfterLine(last, added);
  }

  void Remove(const toml::key& key, const toml::node& value) {
    if (!HasHeader(value)) {
      text_.CommentOut(key.source().begin.line, LastLine(value));
    } else if (const auto* elements = value.as_array()) {
      for (const toml::node& element : *elements) RemoveTable(*element.as_table());
    } else {
      RemoveTable(*value.as_table());
    }
  }

  // Comments out the table's own lines; lines between them may belong to another table.
  void RemoveTable(const toml::table& table) {
    const std::uint32_t header = table.source().begin.line;
    text_.CommentOut(header, header);
    for (const auto& [key, value] : table) Remove(key, value);
  }

  const toml::table& organ_;
  TextEdits& text_;
};

void MoveNames(const toml::node& value, const std::map<std::string, std::string>& names,
               TextEdits* text) {
  if (const auto* table = value.as_table()) {
    static constexpr std::string_view kFileKeysOfScenes[] = {"mesh", "texture", "background",
                                                             "meshes", "file"};
    for (const auto& [key, child] : *table) {
      const bool names_files =
          std::ranges::find(kFileKeysOfScenes, key.str()) != std::end(kFileKeysOfScenes);
      if (names_files || child.is_table() || child.is_array_of_tables()) {
        MoveNames(child, names, text);
      }
    }
  } else if (const auto* elements = value.as_array()) {
    for (const toml::node& element : *elements) MoveNames(element, names, text);
  } else if (const auto* name = value.as_string()) {
    const auto found = names.find(name->get());
    if (found != names.end()) text->Replace(value.source(), StringText(found->second));
  }
}

fs::path FolderOf(const fs::path& path) { return path.empty() ? fs::path(".") : path; }

}  // namespace

std::string EditedScene(const Scene& scene, const std::vector<OrganEdit>& edits) {
  const TomlDocument document = ParseToml(scene.source_text, scene.path);
  const toml::array& organs = *document.root.get_as<toml::array>("organ");
  TextEdits text(document);
  for (const OrganEdit& edit : edits) {
    const toml::table& organ = *organs.at(edit.organ).as_table();
    OrganText(document, organ, &text).Apply(edit);
  }
  return text.Result();
}

std::string LeftHandedScene(const Scene& scene) {
  constexpr char kKey[] = "left_handed";
  const TomlDocument document = ParseToml(scene.source_text, scene.path);
  TextEdits text(document);
  const toml::table* table = document.root["scene"].as_table();
  if (table == nullptr) return scene.source_text + "\n[scene]\n" + kKey + " = true\n";
  const toml::source_region& place = table->source();
  if (const toml::node* value = table->get(kKey)) {
    text.Replace(value->source(), "true");
  } else if (table->is_inline()) {
    const std::size_t inside = text.At(place.begin) + 1;
    text.Replace(inside, inside,
                 std::string(" ") + kKey + (table->empty() ? " = true" : " = true,"));
  } else if (text.CharAt(place.begin) == '[') {
    text.InsertAfterLine(place.begin.line, std::string(kKey) + " = true");
  } else {  // scene.name = "..."
    text.InsertAfterLine(LastLine(*table), std::string("scene.") + kKey + " = true");
  }
  return text.Result();
}

std::string MovedScene(const Scene& scene, std::string text, const fs::path& to_folder) {
  std::error_code error;
  const fs::path from = fs::canonical(FolderOf(scene.path.parent_path()), error);
  const fs::path to = fs::weakly_canonical(fs::absolute(FolderOf(to_folder)), error);
  if (from == to) return text;
  if (scene.recorded) {
    throw InputError(scene.path.string() +
                     ": is a recorded scene, its files must stay in its folder; write it there");
  }
  std::map<std::string, std::string> names;
  for (const SceneFile& file : scene.files) {
    if (fs::path(file.name).is_absolute()) continue;
    const fs::path target = fs::canonical(file.path, error);
    names[file.name] = target.lexically_relative(to).generic_string();
  }
  const TomlDocument document = ParseToml(std::move(text), scene.path);
  TextEdits edits(document);
  MoveNames(document.root, names, &edits);
  return edits.Result();
}

Scene ParseScene(std::string text, const fs::path& path) {
  return ReadScene(ParseToml(std::move(text), path));
}

}  // namespace hpdm
