#include "scenes/loader/scene_edit.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <set>

#include "engine/base/error.h"
#include "scenes/loader/toml_document.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

const TomlEntry* FindEntry(const TomlValue& table, std::string_view key) {
  const auto* entries = std::get_if<TomlTable>(&table.value);
  if (entries == nullptr) return nullptr;
  for (const TomlEntry& entry : *entries) {
    if (entry.key == key) return &entry;
  }
  return nullptr;
}

bool IsTable(const TomlValue& value) { return std::holds_alternative<TomlTable>(value.value); }

bool IsArrayOfTables(const TomlValue& value) {
  const auto* elements = std::get_if<TomlArray>(&value.value);
  return elements != nullptr && !elements->empty() && IsTable(elements->front());
}

std::string NumberText(double number) {
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof digits, number).ptr};
}

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
  if (const double* number = std::get_if<double>(&value)) return NumberText(*number);
  if (const std::string* text = std::get_if<std::string>(&value)) return StringText(*text);
  const auto& three = std::get<std::array<int, 3>>(value);
  std::string text = "[";
  for (int i = 0; i < 3; ++i) text.append(i > 0 ? ", " : "").append(std::to_string(three[i]));
  return text.append("]");
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
  std::size_t At(TomlPlace place) const {
    std::size_t at = lines_[place.line - 1];
    for (std::uint32_t column = 1; column < place.column; ++column) {
      ++at;
      while (at < Text().size() && (static_cast<unsigned char>(Text()[at]) & 0xc0) == 0x80) ++at;
    }
    return at;
  }
  char CharAt(TomlPlace place) const {
    const std::size_t at = At(place);
    return at < Text().size() ? Text()[at] : '\0';
  }

  std::string Slice(TomlPlace begin, TomlPlace end) const {
    return Text().substr(At(begin), At(end) - At(begin));
  }

  void Replace(std::size_t begin, std::size_t end, std::string with) {
    edits_.push_back({begin, end, std::move(with)});
  }
  void Replace(TomlPlace begin, TomlPlace end, std::string with) {
    Replace(At(begin), At(end), std::move(with));
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
std::uint32_t LastLine(const TextEdits& text, const TomlValue& value) {
  std::uint32_t last = value.end.line;
  if (text.CharAt(value.place) == '{') return last;
  if (const auto* entries = std::get_if<TomlTable>(&value.value)) {
    for (const TomlEntry& entry : *entries) last = std::max(last, LastLine(text, entry.value));
  } else if (const auto* elements = std::get_if<TomlArray>(&value.value)) {
    for (const TomlValue& element : *elements) last = std::max(last, LastLine(text, element));
  }
  return last;
}

/// Applies the edits of one organ.
class OrganText {
 public:
  OrganText(const TomlDocument& document, const TomlValue& organ, TextEdits* text)
      : organ_(organ), text_(*text) {
    if (text_.CharAt(organ.place) != '[') {
      FailAt(document, organ.place, "organ", "is an inline table; write it as [[organ]]");
    }
  }

  void Apply(const OrganEdit& edit) {
    for (const std::string& name : edit.removed_tables) {
      if (const TomlEntry* entry = FindEntry(organ_, name)) Remove(*entry);
    }
    std::map<std::string, std::vector<SceneKeyEdit>> by_table;
    for (const SceneKeyEdit& key : edit.keys) by_table[key.table].push_back(key);
    for (const auto& [table, keys] : by_table) {
      if (table.empty()) {
        EditTable(organ_, "", keys);
      } else if (const TomlEntry* entry = FindEntry(organ_, table)) {
        EditEntry(*entry, keys);
      } else {
        AddTable(table, keys);
      }
    }
  }

 private:
  // Returns the last line of a table's own keys, without the tables under their own headers.
  std::uint32_t LastOwnLine(const TomlValue& table) const {
    std::uint32_t last = table.place.line;
    for (const TomlEntry& entry : std::get<TomlTable>(table.value)) {
      if (text_.CharAt(entry.value.place) == '[' &&
          (IsTable(entry.value) || IsArrayOfTables(entry.value))) {
        continue;  // a header
      }
      last = std::max(last, LastLine(text_, entry.value));
    }
    return last;
  }

  static bool Given(const SceneKeyEdit& edit) {
    return !std::holds_alternative<std::monostate>(edit.value);
  }

  // `prefix` precedes inserted keys of a table that is written with dotted keys.
  void EditTable(const TomlValue& table, const std::string& prefix,
                 const std::vector<SceneKeyEdit>& keys) {
    const std::uint32_t last = LastOwnLine(table);
    const std::string indent = text_.Indent(last);
    for (const SceneKeyEdit& edit : keys) {
      const TomlEntry* entry = FindEntry(table, edit.key);
      if (entry == nullptr) {
        if (Given(edit)) {
          text_.InsertAfterLine(last, indent + prefix + edit.key + " = " + ValueOf(edit.value));
        }
      } else if (Given(edit)) {
        text_.Replace(entry->value.place, entry->value.end, ValueOf(edit.value));
      } else {
        text_.CommentOut(entry->place.line, entry->value.end.line);
      }
    }
  }

  void EditEntry(const TomlEntry& entry, const std::vector<SceneKeyEdit>& keys) {
    const char first = text_.CharAt(entry.value.place);
    if (first == '{') return EditInline(entry.value, keys);
    EditTable(entry.value, first == '[' ? "" : entry.key + ".", keys);
  }

  void EditInline(const TomlValue& table, const std::vector<SceneKeyEdit>& keys) {
    std::string inside;
    std::set<std::string> edited;
    const auto add = [&inside](const std::string& key, const std::string& value) {
      inside.append(inside.empty() ? " " : ", ").append(key).append(" = ").append(value);
    };
    for (const SceneKeyEdit& edit : keys) {
      edited.insert(edit.key);
      if (Given(edit)) add(edit.key, ValueOf(edit.value));
    }
    for (const TomlEntry& entry : std::get<TomlTable>(table.value)) {
      if (edited.contains(entry.key)) continue;
      add(entry.key, text_.Slice(entry.value.place, entry.value.end));
    }
    text_.Replace(table.place, table.end, std::string("{").append(inside).append(" }"));
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

  void Remove(const TomlEntry& entry) {
    if (const auto* elements = std::get_if<TomlArray>(&entry.value.value)) {
      if (IsArrayOfTables(entry.value) && text_.CharAt(elements->front().place) == '[') {
        for (const TomlValue& element : *elements) RemoveTable(element);
        return;
      }
    }
    if (IsTable(entry.value) && text_.CharAt(entry.value.place) == '[') {
      return RemoveTable(entry.value);
    }
    text_.CommentOut(entry.place.line, LastLine(text_, entry.value));
  }

  // Comments out the table's own lines; lines between them may belong to another table.
  void RemoveTable(const TomlValue& table) {
    text_.CommentOut(table.place.line, table.place.line);
    for (const TomlEntry& entry : std::get<TomlTable>(table.value)) Remove(entry);
  }

  const TomlValue& organ_;
  TextEdits& text_;
};

void MoveNames(const TomlValue& value, const std::map<std::string, std::string>& names,
               TextEdits* text) {
  if (const auto* entries = std::get_if<TomlTable>(&value.value)) {
    static constexpr std::string_view kFileKeysOfScenes[] = {"mesh", "texture", "background",
                                                             "meshes", "file"};
    for (const TomlEntry& entry : *entries) {
      const bool names_files = std::find(std::begin(kFileKeysOfScenes), std::end(kFileKeysOfScenes),
                                         entry.key) != std::end(kFileKeysOfScenes);
      if (names_files || IsTable(entry.value) || IsArrayOfTables(entry.value)) {
        MoveNames(entry.value, names, text);
      }
    }
  } else if (const auto* elements = std::get_if<TomlArray>(&value.value)) {
    for (const TomlValue& element : *elements) MoveNames(element, names, text);
  } else if (const auto* name = std::get_if<std::string>(&value.value)) {
    const auto found = names.find(*name);
    if (found != names.end()) text->Replace(value.place, value.end, StringText(found->second));
  }
}

fs::path FolderOf(const fs::path& path) { return path.empty() ? fs::path(".") : path; }

}  // namespace

std::string EditedScene(const Scene& scene, const std::vector<OrganEdit>& edits) {
  const TomlDocument document = ParseToml(scene.source_text, scene.path);
  const TomlEntry* organs = FindEntry(document.root, "organ");
  TextEdits text(document);
  for (const OrganEdit& edit : edits) {
    const TomlValue& organ = std::get<TomlArray>(organs->value.value).at(edit.organ);
    OrganText(document, organ, &text).Apply(edit);
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

}  // namespace hpdm
