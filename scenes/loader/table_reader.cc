#include "scenes/loader/table_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "engine/base/check.h"
#include "scenes/loader/scene_files.h"

namespace hpdm {
namespace {

constexpr std::size_t kMaxNameBytes = 64;

/// Levenshtein's distance: the number of insertions, deletions and replacements from a to b.
std::size_t EditDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row[b.size()];
}

/// Returns the nearest known key within an edit distance of a third of its letters, or "".
std::string_view Nearest(std::string_view key, TableReader::Keys known) {
  std::string_view nearest;
  std::size_t least = std::numeric_limits<std::size_t>::max();
  for (const std::string_view candidate : known) {
    const std::size_t allowed = std::max<std::size_t>(1, candidate.size() / 3);
    if (key.size() > candidate.size() + allowed) continue;
    const std::size_t distance = EditDistance(key, candidate);
    if (distance <= allowed && distance < least) {
      least = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

std::string Listed(TableReader::Keys names, std::string_view quote) {
  std::string list;
  for (const std::string_view name : names) {
    if (!list.empty()) list += ", ";
    list.append(quote).append(name).append(quote);
  }
  return list;
}

std::string Text(double number) { return ValueText({{}, number}); }

std::string Text(const Interval& range) {
  std::string text;
  if (std::isfinite(range.min))
    text += (range.above_min ? "above " : "at least ") + Text(range.min);
  if (std::isfinite(range.max)) {
    if (!text.empty()) text += " and ";
    text += (range.below_max ? "below " : "at most ") + Text(range.max);
  }
  if (!range.unit.empty()) text.append(", in ").append(range.unit);
  return text;
}

std::string_view KindOf(const TomlValue& value) {
  static constexpr std::string_view kKinds[] = {"an integer", "a number", "a boolean", "a string",
                                                "a date",     "an array", "a table"};
  return kKinds[value.value.index()];
}

}  // namespace

TableReader::TableReader(const TomlDocument& document, Keys known, SceneFiles* files)
    : TableReader(document, document.root, "", known, files) {}

TableReader::TableReader(const TomlDocument& document, const TomlValue& table, std::string path,
                         Keys known, SceneFiles* files)
    : document_(&document), table_(&table), path_(std::move(path)), known_(known), files_(files) {
  for (const TomlEntry& entry : std::get<TomlTable>(table.value)) {
    if (std::ranges::find(known_, entry.key) != known_.end()) continue;
    const std::string_view nearest = Nearest(entry.key, known_);
    const std::string remedy = nearest.empty() ? "known keys: " + Listed(known_, "")
                                               : "did you mean " + std::string(nearest) + "?";
    // A key may be any text: Quoted cuts a long one.
    const std::string quoted = Quoted(entry.key);
    FailAt(document, entry.place, PathOf(quoted.substr(1, quoted.size() - 2)),
           "is not a known key; " + remedy);
  }
}

const TomlEntry* TableReader::Find(std::string_view key) const {
  HPDM_CHECK(std::ranges::find(known_, key) != known_.end());
  for (const TomlEntry& entry : std::get<TomlTable>(table_->value)) {
    if (entry.key == key) return &entry;
  }
  return nullptr;
}

std::string TableReader::PathOf(std::string_view key) const {
  return path_.empty() ? std::string(key) : path_ + "." + std::string(key);
}

void TableReader::Fail(std::string_view key, std::string_view what, std::string_view remedy) const {
  const TomlEntry* entry = Find(key);
  std::string message(what);
  if (entry != nullptr) message += " (" + ValueText(entry->value) + ")";
  message.append("; ").append(remedy);
  FailAt(*document_, entry != nullptr ? entry->value.place : table_->place, PathOf(key), message);
}

void TableReader::Fail(std::string_view what, std::string_view remedy) const {
  std::string message(what);
  message.append("; ").append(remedy);
  FailAt(*document_, table_->place, path_.empty() ? "scene file" : path_, message);
}

void TableReader::FailType(std::string_view key, const TomlValue& value,
                           std::string_view wanted) const {
  std::string message = "is " + std::string(KindOf(value));
  const bool has_text = !std::holds_alternative<TomlTable>(value.value) &&
                        !std::holds_alternative<TomlDate>(value.value);
  if (has_text) message += " (" + ValueText(value) + ")";
  message.append("; give ").append(wanted);
  FailAt(*document_, value.place, PathOf(key), message);
}

void TableReader::FailChoice(std::string_view key, Keys names) const {
  Fail(key, "is not a known value", "give one of " + Listed(names, "\""));
}

bool TableReader::HasString(std::string_view key) const {
  const TomlEntry* entry = Find(key);
  return entry != nullptr && std::holds_alternative<std::string>(entry->value.value);
}

void TableReader::Require(std::string_view key, std::string_view remedy) const {
  if (!Has(key)) Fail(key, "is missing", remedy);
}

void TableReader::RefuseBoth(std::string_view a, std::string_view b) const {
  if (!Has(a) || !Has(b)) return;
  Fail(b, "cannot be combined with " + std::string(a), "keep one of the two");
}

double TableReader::CheckedNumber(std::string_view key, const TomlValue& value,
                                  const Interval& range) const {
  double number = 0;
  if (const auto* real = std::get_if<double>(&value.value)) {
    number = *real;
  } else if (const auto* integer = std::get_if<std::int64_t>(&value.value)) {
    number = static_cast<double>(*integer);
  } else {
    FailType(key, value, "a number " + Text(range));
  }
  if (!std::isfinite(number) || !range.Contains(number)) {
    const std::string what = std::isfinite(number) ? "is out of range" : "is not finite";
    FailAt(*document_, value.place, PathOf(key),
           what + " (" + ValueText(value) + "); give a number " + Text(range));
  }
  return number;
}

std::int64_t TableReader::CheckedInteger(std::string_view key, const TomlValue& value,
                                         std::int64_t min, std::int64_t max) const {
  const std::string wanted =
      "an integer from " + std::to_string(min) + " to " + std::to_string(max);
  const auto* integer = std::get_if<std::int64_t>(&value.value);
  if (integer == nullptr) FailType(key, value, wanted);
  if (*integer < min || *integer > max) {
    FailAt(*document_, value.place, PathOf(key),
           "is out of range (" + ValueText(value) + "); give " + wanted);
  }
  return *integer;
}

std::optional<std::int64_t> TableReader::Integer(std::string_view key, std::int64_t min,
                                                 std::int64_t max) const {
  const TomlEntry* entry = Find(key);
  if (entry == nullptr) return std::nullopt;
  return CheckedInteger(key, entry->value, min, max);
}

bool TableReader::ReadNumber(std::string_view key, const Interval& range, double* out) const {
  const TomlEntry* entry = Find(key);
  if (entry == nullptr) return false;
  *out = CheckedNumber(key, entry->value, range);
  return true;
}

bool TableReader::ReadVector(std::string_view key, const Interval& range, Vector3d* out) const {
  const TomlEntry* entry = Find(key);
  if (entry == nullptr) return false;
  const auto* elements = std::get_if<TomlArray>(&entry->value.value);
  if (elements == nullptr) FailType(key, entry->value, "three numbers, [x, y, z]");
  if (elements->size() != 3) {
    Fail(key, "has " + std::to_string(elements->size()) + " elements",
         "give three numbers, [x, y, z]");
  }
  for (int i = 0; i < 3; ++i) {
    (*out)[i] = CheckedNumber(key, (*elements)[static_cast<std::size_t>(i)], range);
  }
  return true;
}

bool TableReader::ReadIntegers(std::string_view key, int min, int max,
                               std::array<int, 3>* out) const {
  const TomlEntry* entry = Find(key);
  if (entry == nullptr) return false;
  const auto* elements = std::get_if<TomlArray>(&entry->value.value);
  if (elements == nullptr && std::holds_alternative<std::int64_t>(entry->value.value)) {
    out->fill(static_cast<int>(CheckedInteger(key, entry->value, min, max)));
    return true;
  }
  if (elements == nullptr) FailType(key, entry->value, "one integer or three, [l, m, n]");
  if (elements->size() != 3) {
    Fail(key, "has " + std::to_string(elements->size()) + " elements",
         "give one integer or three, [l, m, n]");
  }
  for (std::size_t i = 0; i < 3; ++i) {
    (*out)[i] = static_cast<int>(CheckedInteger(key, (*elements)[i], min, max));
  }
  return true;
}

bool TableReader::ReadBoolean(std::string_view key, bool* out) const {
  const TomlEntry* entry = Find(key);
  if (entry == nullptr) return false;
  const auto* boolean = std::get_if<bool>(&entry->value.value);
  if (boolean == nullptr) FailType(key, entry->value, "true or false");
  *out = *boolean;
  return true;
}

bool TableReader::ReadString(std::string_view key, std::string* out) const {
  const TomlEntry* entry = Find(key);
  if (entry == nullptr) return false;
  const auto* text = std::get_if<std::string>(&entry->value.value);
  if (text == nullptr) FailType(key, entry->value, "a string in quotes");
  for (const char c : *text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      Fail(key, "contains a control character", "remove it");
    }
  }
  *out = *text;
  return true;
}

bool TableReader::ReadName(std::string_view key, std::string* out) const {
  if (!ReadString(key, out)) return false;
  if (out->size() > kMaxNameBytes || out->find_first_not_of(' ') == std::string::npos) {
    Fail(key, "is not a name", "give 1 to " + std::to_string(kMaxNameBytes) + " characters");
  }
  return true;
}

// Fails at the key unless the file exists.
std::string TableReader::FileAt(std::string_view key, const std::string& text) const {
  std::string path;
  if (const auto fault = files_->Find(text, &path)) Fail(key, fault->what, fault->remedy);
  return path;
}

bool TableReader::ReadFile(std::string_view key, std::string* out) const {
  std::string text;
  if (!ReadString(key, &text)) return false;
  *out = FileAt(key, text);
  return true;
}

bool TableReader::ReadFiles(std::string_view key, std::size_t most,
                            std::vector<std::string>* out) const {
  const TomlEntry* entry = Find(key);
  if (entry == nullptr) return false;
  const std::string wanted = "an array of 1 to " + std::to_string(most) + " file names in quotes";
  const auto* names = std::get_if<TomlArray>(&entry->value.value);
  if (names == nullptr) FailType(key, entry->value, wanted);
  if (names->empty() || names->size() > most) {
    Fail(key, "has " + std::to_string(names->size()) + " values", "give " + wanted);
  }
  out->clear();
  for (const TomlValue& name : *names) {
    const auto* text = std::get_if<std::string>(&name.value);
    if (text == nullptr) FailType(key, name, wanted);
    out->push_back(FileAt(key, *text));
  }
  return true;
}

std::optional<TableReader> TableReader::Table(std::string_view key, Keys known) const {
  const TomlEntry* entry = Find(key);
  if (entry == nullptr) return std::nullopt;
  if (!std::holds_alternative<TomlTable>(entry->value.value)) {
    FailType(key, entry->value, "one table, [...] in single brackets");
  }
  return TableReader(*document_, entry->value, PathOf(key), known, files_);
}

std::vector<TableReader> TableReader::Tables(std::string_view key, Keys known) const {
  std::vector<TableReader> tables;
  const TomlEntry* entry = Find(key);
  if (entry == nullptr) return tables;
  const auto* elements = std::get_if<TomlArray>(&entry->value.value);
  if (elements == nullptr) FailType(key, entry->value, "tables in double brackets, [[...]]");
  for (const TomlValue& element : *elements) {
    if (!std::holds_alternative<TomlTable>(element.value)) {
      FailType(key, element, "tables in double brackets, [[...]]");
    }
    tables.push_back(TableReader(*document_, element,
                                 PathOf(key) + "[" + std::to_string(tables.size()) + "]", known,
                                 files_));
  }
  return tables;
}

}  // namespace hpdm
