#pragma once

#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/haptics/contact_trials.h"

/// Tables of contacts whose answer is known, each with a target. The contacts run in the deformation
/// step and the tick (contact_trials.h, bonded_disc.h).
namespace hpdm {

/// A measured number and the range that it must be in, ends included.
struct JudgedValue {
  static constexpr double kUnbounded = std::numeric_limits<double>::infinity();

  double value = 0;
  double least = 0;
  double most = 0;

  /// True outside the range and for NaN.
  bool Missed() const { return !(value >= least && value <= most); }
};
inline JudgedValue AtMost(double value, double most) { return {value, 0, most}; }
inline JudgedValue Near(double ratio, double error) { return {ratio, 1 - error, 1 + error}; }
inline JudgedValue NotJudged(double value) {
  return {value, -JudgedValue::kUnbounded, JudgedValue::kUnbounded};
}

struct ContactTable {
  struct Column {
    std::string title;  ///< With the unit.
    std::string key;    ///< In JSON, with the unit.
    int decimals = 3;
  };
  struct Row {
    std::string name;
    std::vector<JudgedValue> values;  ///< One a column.
  };

  std::string name;    ///< In JSON.
  std::string title;   ///< A sentence: what is measured.
  std::string target;  ///< A sentence.
  std::vector<Column> columns;
  std::vector<Row> rows;

  int Missed() const;  ///< Number of values out of range.
};

/// The least and the largest ratio of measured forces to a law's.
struct RatioRange {
  double low = 0;
  double high = 0;
};
/// Returns the range over the step and both ticks of the presses from `from` to `to` (m). NaN if
/// there is none or a force is not finite.
RatioRange ForceOverLaw(const std::vector<BallPress>& presses,
                        const std::function<double(double depth)>& law, double from, double to);

/// Measure one table each. `quick`: fewer cases.
ContactTable MeasureBalls(bool quick);
ContactTable MeasureDiscs(bool quick);
ContactTable MeasureGrasps(bool quick);
ContactTable MeasureGraspTurns(bool quick);
ContactTable MeasureStillness(bool quick);
ContactTable MeasureApproaches(bool quick);
ContactTable MeasureOrganSlides(bool quick);

/// Measures all; `done` gets each table as soon as it is measured.
std::vector<ContactTable> MeasureContacts(bool quick,
                                          const std::function<void(const ContactTable&)>& done);

/// Returns the table as text for a terminal, with a * at each value that misses its target.
std::string TableText(const ContactTable& table);
/// Returns the same in Markdown, missed values in bold.
std::string TableMarkdown(const ContactTable& table);
/// Returns [{"name", "target", "missed", "rows": [{"case", key: value, ..., "missed": [key, ...]}]}].
nlohmann::ordered_json TablesJson(const std::vector<ContactTable>& tables);

}  // namespace hpdm
