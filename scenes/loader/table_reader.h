#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/types.h"
#include "scenes/loader/key_form.h"
#include "scenes/loader/toml_document.h"

namespace hpdm {

class SceneFiles;

/// Typed and checked access to one table of a document. Every failure throws an InputError of one
/// line: `FILE:LINE:COLUMN: key.path: problem (value); remedy`.
///
/// If the key is absent, a Read function returns false and leaves *out unchanged, so that the
/// caller's initial value is the default. The document must outlive the reader.
class TableReader {
 public:
  using Keys = std::span<const std::string_view>;

  /// Reads the whole document. Fails at the first key that is not in `known` and names the nearest
  /// known key, or all of them if none is near. Table and Tables check their keys the same way.
  /// `files` finds the files that values name; the reader keeps the pointer. An `observer` learns
  /// what this reader and those of its tables ask for; files are then not looked for.
  TableReader(const TomlDocument& document, Keys known, SceneFiles* files,
              KeyObserver* observer = nullptr);

  bool Has(std::string_view key) const { return Find(key) != nullptr; }
  /// True if the key is given and its value is a string.
  bool HasString(std::string_view key) const;
  /// Fails when the key is absent.
  void Require(std::string_view key, std::string_view remedy) const;
  /// Fails when both keys are given.
  void RefuseBoth(std::string_view a, std::string_view b) const;

  /// Fails with the message when the key is given and its number, a number of its vector, or its
  /// boolean (true: 1) is none of `values`. To be called after the key's Read function.
  void RefuseOthers(std::string_view key, const std::vector<double>& values, std::string_view what,
                    std::string_view remedy) const;

  bool ReadNumber(std::string_view key, const Interval& range, double* out) const;
  /// Reads an array of three numbers.
  bool ReadVector(std::string_view key, const Interval& range, Vector3d* out) const;
  /// Reads an array of 2 to `most` points, each another than the one before.
  bool ReadPoints(std::string_view key, const Interval& range, std::size_t most,
                  std::vector<Vector3d>* out) const;
  /// Reads an array of 2 to `most` pairs of different points.
  bool ReadEdges(std::string_view key, const Interval& range, std::size_t most,
                 std::vector<std::array<Vector3d, 2>>* out) const;
  bool ReadBoolean(std::string_view key, bool* out) const;
  /// Reads a string without control characters.
  bool ReadString(std::string_view key, std::string* out) const;
  /// Reads a string of 1 to 64 bytes that is not blank.
  bool ReadName(std::string_view key, std::string* out) const;
  /// Reads the name of an existing file (SceneFiles). *out is absolute or relative to the working
  /// folder, as the document's own path is.
  bool ReadFile(std::string_view key, std::string* out) const;

  /// Reads an array of 1 to `most` file names.
  bool ReadFiles(std::string_view key, std::size_t most, std::vector<std::string>* out) const;

  template <std::integral Int>
  bool ReadInteger(std::string_view key, Int min, Int max, Int* out) const {
    const std::optional<std::int64_t> value = Integer(key, min, max);
    if (value) *out = static_cast<Int>(*value);
    return value.has_value();
  }

  /// Reads an array of three integers, or one integer for all three.
  bool ReadIntegers(std::string_view key, int min, int max, std::array<int, 3>* out) const;

  /// Reads one of the choices' strings. The default remedy lists them.
  template <typename Enum, std::size_t N>
  bool ReadChoice(std::string_view key, const std::pair<std::string_view, Enum> (&choices)[N],
                  Enum* out, std::string_view remedy = {}) const {
    std::array<std::string_view, N> names;
    for (std::size_t i = 0; i < N; ++i) names[i] = choices[i].first;
    const std::optional<std::size_t> chosen = Choice(key, names, remedy);
    if (chosen) *out = choices[*chosen].second;
    return chosen.has_value();
  }

  /// Returns a table inside this one, [key] or key = {...}.
  std::optional<TableReader> Table(std::string_view key, Keys known) const;
  /// Returns the array of tables [[key]]; empty when absent. Fails if there are more than `most`,
  /// unless that is 0.
  std::vector<TableReader> Tables(std::string_view key, Keys known, std::size_t most = 0) const;

  /// Fails at the key's value, or at the table when the key is absent.
  [[noreturn]] void Fail(std::string_view key, std::string_view what,
                         std::string_view remedy) const;
  /// Fails at the table itself.
  [[noreturn]] void Fail(std::string_view what, std::string_view remedy) const;

 private:
  TableReader(const TomlDocument& document, const toml::table& table, std::string path, Keys known,
              SceneFiles* files, KeyObserver* observer);

  void Note(std::string_view key, const KeyForm& form) const;
  const toml::node* Find(std::string_view key) const;
  std::string PathOf(std::string_view key) const;
  std::string FileAt(std::string_view key, const std::string& text) const;
  [[noreturn]] void FailType(std::string_view key, const toml::node& value,
                             std::string_view wanted) const;
  std::optional<std::string> Text(std::string_view key) const;
  std::optional<std::size_t> Choice(std::string_view key, Keys names,
                                    std::string_view remedy) const;
  std::optional<std::int64_t> Integer(std::string_view key, std::int64_t min,
                                      std::int64_t max) const;
  std::int64_t CheckedInteger(std::string_view key, const toml::node& value, std::int64_t min,
                              std::int64_t max) const;
  double CheckedNumber(std::string_view key, const toml::node& value, const Interval& range) const;

  const TomlDocument* document_;
  const toml::table* table_;
  std::string path_;  ///< Such as "organ[0].lattice"; empty for the document.
  Keys known_;
  SceneFiles* files_;
  KeyObserver* observer_;  ///< Null: none.
};

}  // namespace hpdm
