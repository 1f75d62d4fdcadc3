#pragma once

#include <cstddef>
#include <limits>
#include <string_view>
#include <vector>

namespace hpdm {

/// The numbers that a key accepts, in `unit` (empty for a pure number).
struct Interval {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  std::string_view unit = {};
  bool above_min = false;  ///< `min` itself is refused.
  bool below_max = false;  ///< `max` itself is refused.

  /// Above 0, up to `max`.
  static constexpr Interval Positive(double max, std::string_view unit) {
    return {.min = 0, .max = max, .unit = unit, .above_min = true};
  }
  /// From 0 to `max`.
  static constexpr Interval NotNegative(double max, std::string_view unit) {
    return {.min = 0, .max = max, .unit = unit};
  }
  /// From -magnitude to magnitude.
  static constexpr Interval Within(double magnitude, std::string_view unit) {
    return {.min = -magnitude, .max = magnitude, .unit = unit};
  }
  bool Contains(double x) const {
    return (above_min ? x > min : x >= min) && (below_max ? x < max : x <= max);
  }
};

/// The values that a TableReader accepts for a key.
struct KeyForm {
  enum class Type {
    kNumber,
    kVector,  ///< Three numbers.
    kPoints,  ///< An array of 2 to `max_size` points, [x, y, z].
    kEdges,   ///< An array of 2 to `max_size` pairs of points, [[x, y, z], [x, y, z]].
    kInteger,
    kIntegers,  ///< One integer or three.
    kBoolean,
    kString,
    kName,   ///< A string of 1 to `max_size` bytes that is not blank.
    kFiles,  ///< An array of 1 to `max_size` strings.
    kChoice,
    kTable,
    kTables
  };
  Type type = Type::kString;
  Interval range = {};                         ///< Of each number or integer.
  std::vector<std::string_view> choices = {};  ///< Of kChoice.
  std::size_t max_size = 0;                    ///< Of kTables: 0 is any number.
  std::vector<double> only = {};  ///< If any: the only numbers that are accepted; 1 is true.
};

/// Is informed of what a TableReader asks of its table, whether or not the table has the key.
/// `table` is the reader's path, such as "organ[0].lattice"; empty for the document.
class KeyObserver {
 public:
  virtual ~KeyObserver() = default;
  virtual void OnTable(std::string_view table) = 0;
  virtual void OnKey(std::string_view table, std::string_view key, const KeyForm& form) = 0;
  /// The key accepts the numbers in `values` and no others; 1 stands for true.
  virtual void OnValues(std::string_view table, std::string_view key,
                        const std::vector<double>& values) = 0;
  /// The table must have the key.
  virtual void OnRequired(std::string_view table, std::string_view key) = 0;
  /// The table must not have both keys.
  virtual void OnExclusive(std::string_view table, std::string_view a, std::string_view b) = 0;
};

}  // namespace hpdm
