#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/snapshots.h"

namespace hpdm {

/// One field that a log and its replay have differently.
struct FieldDifference {
  bool in_step = false;      ///< Of a deformation step, else of a haptic tick.
  std::uint64_t number = 0;  ///< Of the tick or of the step.
  int tool = -1;             ///< -1: the field is not a tool's.
  std::string field;         ///< As in engine/snapshots.h.
  std::string logged, replayed;
  double relative = 0;  ///< Of the field's largest value in the log; infinite for whole numbers.
};

/// Compares recorded values with replayed ones, field by field. A difference of a field of real
/// numbers (a vector counts as one) is taken relative to the largest length that the field has
/// anywhere in the log, so that round-off near zero stays what it is; whole numbers, flags and
/// values that are not finite must be equal. All recorded values are measured before the first is
/// compared.
class FieldComparison {
 public:
  explicit FieldComparison(double tolerance) : tolerance_(tolerance) {}

  void Measure(const HapticSample& logged, bool with_output);
  void Measure(const StepSample& logged);

  /// `with_output`: whether the log has what the tick gave, or its input only.
  void Compare(const HapticSample& logged, const HapticSample& replayed, bool with_output);
  void Compare(const StepSample& logged, const StepSample& replayed);

  double tolerance() const { return tolerance_; }
  /// The first difference of any size: absent when all is the same bit for bit.
  const std::optional<FieldDifference>& first() const { return first_; }
  /// The first beyond the tolerance.
  const std::optional<FieldDifference>& first_beyond() const { return first_beyond_; }
  /// The largest.
  const std::optional<FieldDifference>& largest() const { return largest_; }

 private:
  struct Place;
  struct Visitor;
  void Integer(const Place& at, const char* field, std::int64_t logged, std::int64_t replayed);
  void Real(const Place& at, const char* field, double peak, std::span<const double> logged,
            std::span<const double> replayed);
  void Note(FieldDifference difference);

  double tolerance_;
  std::vector<double> tick_peaks_, step_peaks_;  // by place in the order of the fields
  std::optional<FieldDifference> first_, first_beyond_, largest_;
};

}  // namespace hpdm
