#include "scenes/loader/table_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "engine/base/check.h"
#include "engine/base/nearest_word.h"
#include "engine/base/quoted_token.h"
#include "engine/base/text_list.h"
#include "scenes/loader/scene_files.h"

namespace hpdm {
namespace {

constexpr std::size_t kMaxNameBytes = 64;

std::string Listed(TableReader::Keys names, std::string_view quote) {
  std::string list;
  for (const std::string_view name : names) {
    AppendToList(std::string(quote).append(name).append(quote), &list);
  }
  return list;
}

std::string NumberText(double number) { return ValueText(toml::value<double>(number)); }

std::string IntervalText(const Interval& range) {
  std::string text;
  if (std::isfinite(range.min))
    text += (range.above_min ? "above " : "at least ") + NumberText(range.min);
  if (std::isfinite(range.max)) {
    if (!text.empty()) text += " and ";
    text += (range.below_max ? "below " : "at most ") + NumberText(range.max);
  }
  if (!range.unit.empty()) text.append(", in ").append(range.unit);
  return text;
}

/// Returns a value of the wrong type. A number of type float keeps its decimal point: 4.0.
std::string WrongValueText(const toml::node& value) {
  const std::string text = ValueText(value);
  const bool looks_whole = text.find_first_not_of("-0123456789") == std::string::npos;
  return value.is_floating_point() && looks_whole ? text + ".0" : text;
}

std::string_view KindOf(const toml::node& value) {
  // In the order of toml::node_type.
  static constexpr std::string_view kKinds[] = {"empty",      "a table",  "an array",  "a string",
                                                "an integer", "a number", "a boolean", "a date",
                                                "a date",     "a date"};
  return kKinds[static_cast<std::size_t>(value.type())];
}

}  // namespace

TableReader::TableReader(const TomlDocument& document, Keys known, SceneFiles* files,
                         KeyObserver* observer)
    : TableReader(document, document.root, "", known, files, observer) {}

TableReader::TableReader(const TomlDocument& document, const toml::table& table, std::string path,
                         Keys known, SceneFiles* files, KeyObserver* observer)
    : document_(&document),
      table_(&table),
      path_(std::move(path)),
      known_(known),
      files_(files),
      observer_(observer) {
  if (observer_ != nullptr) observer_->OnTable(path_);
  for (const auto& [key, value] : table) {
    if (std::ranges::find(known_, key.str()) != known_.end()) continue;
    const std::string_view nearest = NearestWord(key, known_);
    const std::string remedy = nearest.empty() ? "known keys: " + Listed(known_, "")
                                               : "did you mean " + std::string(nearest) + "?";
    // A key may be any text: Quoted cuts a long one.
    const std::string quoted = Quoted(key);
    FailAt(document, key.source().begin, PathOf(quoted.substr(1, quoted.size() - 2)),
           "is not a known key; " + remedy);
  }
}

void TableReader::Note(std::string_view key, const KeyForm& form) const {
  if (observer_ != nullptr) observer_->OnKey(path_, key, form);
}

const toml::node* TableReader::Find(std::string_view key) const {
  HPDM_CHECK(std::ranges::find(known_, key) != known_.end());
  return table_->get(key);
}

std::string TableReader::PathOf(std::string_view key) const {
  return path_.empty() ? std::string(key) : path_ + "." + std::string(key);
}

void TableReader::Fail(std::string_view key, std::string_view what, std::string_view remedy) const {
  const toml::node* value = Find(key);
  std::string message(what);
  if (value != nullptr) message += " (" + ValueText(*value) + ")";
  message.append("; ").append(remedy);
  const toml::node& at = value != nullptr ? *value : *table_;
  FailAt(*document_, at.source().begin, PathOf(key), message);
}

void TableReader::Fail(std::string_view what, std::string_view remedy) const {
  FailAt(*document_, table_->source().begin, path_.empty() ? "scene file" : path_,
         std::string(what).append("; ").append(remedy));
}

void TableReader::FailType(std::string_view key, const toml::node& value,
                           std::string_view wanted) const {
  std::string message = "is " + std::string(KindOf(value));
  const bool date_or_time = value.is_date() || value.is_time() || value.is_date_time();
  if (!value.is_table() && !date_or_time) message += " (" + WrongValueText(value) + ")";
  message.append("; give ").append(wanted);
  FailAt(*document_, value.source().begin, PathOf(key), message);
}

std::optional<std::size_t> TableReader::Choice(std::string_view key, Keys names,
                                               std::string_view remedy) const {
  Note(key, {.type = KeyForm::Type::kChoice, .choices = {names.begin(), names.end()}});
  const std::optional<std::string> text = Text(key);
  if (!text) return std::nullopt;
  const auto chosen = std::ranges::find(names, *text);
  if (chosen != names.end()) return static_cast<std::size_t>(chosen - names.begin());
  const std::string listed = "give one of " + Listed(names, "\"");
  Fail(key, "is not a known value", remedy.empty() ? listed : remedy);
}

bool TableReader::HasString(std::string_view key) const {
  const toml::node* value = Find(key);
  return value != nullptr && value->is_string();
}

void TableReader::Require(std::string_view key, std::string_view remedy) const {
  if (observer_ != nullptr) observer_->OnRequired(path_, key);
  if (!Has(key)) Fail(key, "is missing", remedy);
}

void TableReader::RefuseBoth(std::string_view a, std::string_view b) const {
  if (observer_ != nullptr) observer_->OnExclusive(path_, a, b);
  if (!Has(a) || !Has(b)) return;
  Fail(b, "cannot be combined with " + std::string(a), "keep one of the two");
}

void TableReader::RefuseOthers(std::string_view key, const std::vector<double>& values,
                               std::string_view what, std::string_view remedy) const {
  if (observer_ != nullptr) observer_->OnValues(path_, key, values);
  const auto accepted = [&values](const toml::node& value) {
    const double number =
        value.is_boolean() ? (*value.value<bool>() ? 1 : 0) : value.value<double>().value_or(0);
    return std::ranges::find(values, number) != values.end();
  };
  const toml::node* value = Find(key);
  if (value == nullptr) return;
  const auto* elements = value->as_array();
  if (elements != nullptr ? std::ranges::all_of(*elements, accepted) : accepted(*value)) return;
  Fail(key, what, remedy);
}

double TableReader::CheckedNumber(std::string_view key, const toml::node& value,
                                  const Interval& range) const {
  double number = 0;
  if (const auto* real = value.as_floating_point()) {
    number = real->get();
  } else if (const auto* integer = value.as_integer()) {
    number = static_cast<double>(integer->get());
  } else {
    FailType(key, value, "a number " + IntervalText(range));
  }
  if (!std::isfinite(number) || !range.Contains(number)) {
    const std::string what = std::isfinite(number) ? "is out of range" : "is not finite";
    FailAt(*document_, value.source().begin, PathOf(key),
           what + " (" + ValueText(value) + "); give a number " + IntervalText(range));
  }
  return number;
}

std::int64_t TableReader::CheckedInteger(std::string_view key, const toml::node& value,
                                         std::int64_t min, std::int64_t max) const {
  const std::string wanted =
      "an integer from " + std::to_string(min) + " to " + std::to_string(max);
  const auto* integer = value.as_integer();
  if (integer == nullptr) FailType(key, value, wanted);
  if (integer->get() < min || integer->get() > max) {
    FailAt(*document_, value.source().begin, PathOf(key),
           "is out of range (" + ValueText(value) + "); give " + wanted);
  }
  return integer->get();
}

std::optional<std::int64_t> TableReader::Integer(std::string_view key, std::int64_t min,
                                                 std::int64_t max) const {
  Note(key, {.type = KeyForm::Type::kInteger,
             .range = {.min = static_cast<double>(min), .max = static_cast<double>(max)}});
  const toml::node* value = Find(key);
  if (value == nullptr) return std::nullopt;
  return CheckedInteger(key, *value, min, max);
}

bool TableReader::ReadNumber(std::string_view key, const Interval& range, double* out) const {
  Note(key, {.type = KeyForm::Type::kNumber, .range = range});
  const toml::node* value = Find(key);
  if (value == nullptr) return false;
  *out = CheckedNumber(key, *value, range);
  return true;
}

bool TableReader::ReadVector(std::string_view key, const Interval& range, Vector3d* out) const {
  Note(key, {.type = KeyForm::Type::kVector, .range = range});
  const toml::node* value = Find(key);
  if (value == nullptr) return false;
  const auto* elements = value->as_array();
  if (elements == nullptr) FailType(key, *value, "three numbers, [x, y, z]");
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
  Note(key, {.type = KeyForm::Type::kIntegers,
             .range = {.min = static_cast<double>(min), .max = static_cast<double>(max)}});
  const toml::node* value = Find(key);
  if (value == nullptr) return false;
  const auto* elements = value->as_array();
  if (elements == nullptr && value->is_integer()) {
    out->fill(static_cast<int>(CheckedInteger(key, *value, min, max)));
    return true;
  }
  if (elements == nullptr) FailType(key, *value, "one integer or three, [l, m, n]");
  if (elements->size() != 3) {
    Fail(key, "has " + std::to_string(elements->size()) + " elements",
         "give one integer or three, [l, m, n]");
  }
  for (std::size_t i = 0; i < 3; ++i) {
    (*out)[i] = static_cast<int>(CheckedInteger(key, (*elements)[i], min, max));
  }
  return true;
}

bool TableReader::ReadPoints(std::string_view key, const Interval& range, std::size_t most,
                             std::vector<Vector3d>* out) const {
  Note(key, {.type = KeyForm::Type::kPoints, .range = range, .max_size = most});
  const toml::node* value = Find(key);
  if (value == nullptr) return false;
  constexpr std::string_view kForm = "a list of points, [[x, y, z], ...]";
  const auto* points = value->as_array();
  if (points == nullptr) FailType(key, *value, kForm);
  if (points->size() < 2 || points->size() > most) {
    FailAt(*document_, value->source().begin, PathOf(key),
           "has " + std::to_string(points->size()) + " points; give 2 to " + std::to_string(most));
  }
  out->clear();
  for (const toml::node& node : *points) {
    const auto* point = node.as_array();
    if (point == nullptr || point->size() != 3) FailType(key, node, kForm);
    Vector3d read;
    for (std::size_t d = 0; d < 3; ++d) {
      read[static_cast<Eigen::Index>(d)] = CheckedNumber(key, (*point)[d], range);
    }
    if (!out->empty() && read == out->back()) {
      FailAt(*document_, node.source().begin, PathOf(key),
             "has the same point twice in a row (" + ValueText(node) + "); remove one of them");
    }
    out->push_back(read);
  }
  return true;
}

bool TableReader::ReadEdges(std::string_view key, const Interval& range, std::size_t most,
                            std::vector<std::array<Vector3d, 2>>* out) const {
  Note(key, {.type = KeyForm::Type::kEdges, .range = range, .max_size = most});
  const toml::node* value = Find(key);
  if (value == nullptr) return false;
  constexpr std::string_view kForm = "a list of edges, [[[x, y, z], [x, y, z]], ...]";
  const auto* edges = value->as_array();
  if (edges == nullptr) FailType(key, *value, kForm);
  if (edges->size() < 2 || edges->size() > most) {
    FailAt(*document_, value->source().begin, PathOf(key),
           "has " + std::to_string(edges->size()) + " edges; give 2 to " + std::to_string(most));
  }
  out->clear();
  for (const toml::node& edge : *edges) {
    const auto* ends = edge.as_array();
    std::array<Vector3d, 2>& read = out->emplace_back();
    for (std::size_t end = 0; end < 2; ++end) {
      const auto* point = ends != nullptr && ends->size() == 2 ? (*ends)[end].as_array() : nullptr;
      if (point == nullptr || point->size() != 3) FailType(key, edge, kForm);
      for (std::size_t d = 0; d < 3; ++d) {
        read[end][static_cast<Eigen::Index>(d)] = CheckedNumber(key, (*point)[d], range);
      }
    }
    if (read[0] != read[1]) continue;
    FailAt(*document_, edge.source().begin, PathOf(key),
           "has an edge of zero length (" + ValueText(edge) + "); give two different points");
  }
  return true;
}

bool TableReader::ReadBoolean(std::string_view key, bool* out) const {
  Note(key, {.type = KeyForm::Type::kBoolean});
  const toml::node* value = Find(key);
  if (value == nullptr) return false;
  const auto* boolean = value->as_boolean();
  if (boolean == nullptr) FailType(key, *value, "true or false");
  *out = boolean->get();
  return true;
}

std::optional<std::string> TableReader::Text(std::string_view key) const {
  const toml::node* value = Find(key);
  if (value == nullptr) return std::nullopt;
  const auto* text = value->as_string();
  if (text == nullptr) FailType(key, *value, "a string in quotes");
  for (const char c : text->get()) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      Fail(key, "contains a control character", "remove it");
    }
  }
  return text->get();
}

bool TableReader::ReadString(std::string_view key, std::string* out) const {
  Note(key, {.type = KeyForm::Type::kString});
  const std::optional<std::string> text = Text(key);
  if (text) *out = *text;
  return text.has_value();
}

bool TableReader::ReadName(std::string_view key, std::string* out) const {
  Note(key, {.type = KeyForm::Type::kName, .max_size = kMaxNameBytes});
  const std::optional<std::string> text = Text(key);
  if (!text) return false;
  if (text->size() > kMaxNameBytes || text->find_first_not_of(' ') == std::string::npos) {
    Fail(key, "is not a name", "give 1 to " + std::to_string(kMaxNameBytes) + " characters");
  }
  *out = *text;
  return true;
}

// Fails at the key unless the file exists.
std::string TableReader::FileAt(std::string_view key, const std::string& text) const {
  if (observer_ != nullptr) return text;
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
  Note(key, {.type = KeyForm::Type::kFiles, .max_size = most});
  const toml::node* value = Find(key);
  if (value == nullptr) return false;
  const std::string wanted = "an array of 1 to " + std::to_string(most) + " file names in quotes";
  const auto* names = value->as_array();
  if (names == nullptr) FailType(key, *value, wanted);
  if (names->empty() || names->size() > most) {
    Fail(key, "has " + std::to_string(names->size()) + " values", "give " + wanted);
  }
  out->clear();
  for (const toml::node& name : *names) {
    const auto* text = name.as_string();
    if (text == nullptr) FailType(key, name, wanted);
    out->push_back(FileAt(key, text->get()));
  }
  return true;
}

std::optional<TableReader> TableReader::Table(std::string_view key, Keys known) const {
  Note(key, {.type = KeyForm::Type::kTable});
  const toml::node* value = Find(key);
  if (value == nullptr) return std::nullopt;
  const auto* table = value->as_table();
  if (table == nullptr) FailType(key, *value, "one table, [...] in single brackets");
  return TableReader(*document_, *table, PathOf(key), known, files_, observer_);
}

std::vector<TableReader> TableReader::Tables(std::string_view key, Keys known,
                                             std::size_t most) const {
  Note(key, {.type = KeyForm::Type::kTables, .max_size = most});
  std::vector<TableReader> tables;
  const toml::node* value = Find(key);
  if (value == nullptr) return tables;
  const auto* elements = value->as_array();
  if (elements == nullptr) FailType(key, *value, "tables in double brackets, [[...]]");
  for (const toml::node& element : *elements) {
    const auto* table = element.as_table();
    if (table == nullptr) FailType(key, element, "tables in double brackets, [[...]]");
    const std::string path = PathOf(key) + "[" + std::to_string(tables.size()) + "]";
    if (most > 0 && tables.size() == most) {
      FailAt(*document_, table->source().begin, path,
             "is one too many; give at most " + std::to_string(most));
    }
    tables.push_back(TableReader(*document_, *table, path, known, files_, observer_));
  }
  return tables;
}

}  // namespace hpdm
