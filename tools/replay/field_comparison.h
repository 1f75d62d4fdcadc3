#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/snapshots.h"

namespace hpdm {

/// A field whose values in a log and its replay differ.
struct FieldDifference {
  bool in_step = false;      ///< True: field of a deformation step; false: of a haptic tick.
  std::uint64_t number = 0;  ///< Number of the tick or step.
  int tool = -1;             ///< -1: not a field of a tool.
  std::string field;         ///< Name as in engine/snapshots.h.
  std::string logged, replayed;
  double relative =
      0;  ///< Difference / the field's largest value in the log; infinite for integers.
};

/// Compares recorded values with replayed ones, field by field.
///
/// The difference of real numbers (a vector counts as one) is relative to the largest length of the
/// field in the log, so that round-off near zero stays small. Integers, flags and values that are
/// not finite must be equal. Measure all recorded values before comparing the first.
class FieldComparison {
 public:
  explicit FieldComparison(double tolerance) : tolerance_(tolerance) {}

  void Measure(const HapticSample& logged, bool with_output);
  void Measure(const StepSample& logged);

  /// `with_output`: true if the log has the tick's output, false if it has only its input.
  void Compare(const HapticSample& logged, const HapticSample& replayed, bool with_output);
  void Compare(const StepSample& logged, const StepSample& replayed);

  double tolerance() const { return tolerance_; }
  /// Returns the first difference of any size; nothing if all values are equal bit for bit.
  const std::optional<FieldDifference>& first() const { return first_; }
  /// Returns the first difference beyond the tolerance.
  const std::optional<FieldDifference>& first_beyond() const { return first_beyond_; }
  /// Returns the largest difference.
  const std::optional<FieldDifference>& largest() const { return largest_; }

 private:
  struct Place;
  struct Visitor;
  void Integer(const Place& at, const char* field, std::int64_t logged, std::int64_t replayed);
  void Real(const Place& at, const char* field, double peak, std::span<const double> logged,
            std::span<const double> replayed);
  void Note(FieldDifference difference);

  double tolerance_;
  std::vector<double> tick_peaks_, step_peaks_;  // by index in the order of the fields
  std::optional<FieldDifference> first_, first_beyond_, largest_;
};

}  // namespace hpdm
