#include "tools/replay/field_comparison.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

#include "lcmtypes/wire/sample_fields.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

template <typename Vector>
std::span<const double> Numbers(const Vector& vector) {
  return {vector.data(), static_cast<std::size_t>(vector.size())};
}
std::span<const double> Numbers(const double& number) { return {&number, 1}; }
std::span<const double> Numbers(const Isometry3d& transform) { return Numbers(transform.matrix()); }

template <typename Value>
constexpr bool kIsReal = std::is_same_v<Value, double> || std::is_class_v<Value>;

// Returns the length of the vector's finite components.
double Length(std::span<const double> numbers) {
  double sum = 0;
  for (const double x : numbers) sum += std::isfinite(x) ? x * x : 0;
  return std::sqrt(sum);
}

/// Keeps the largest length of each real field, in the order of the fields.
struct PeakVisitor {
  std::vector<double>* peaks;
  std::size_t place = 0;

  template <typename Value>
  void operator()(int, const FieldInfo& field, const Value& logged) {
    if constexpr (kIsReal<Value>) {
      if (field.use != FieldUse::kCompared) return;
      if (place == peaks->size()) peaks->push_back(0);
      double& peak = (*peaks)[place++];
      peak = std::max(peak, Length(Numbers(logged)));
    }
  }
};

std::string Text(std::span<const double> numbers) {
  std::string text = numbers.size() == 1 ? "" : "[";
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    text += Format("%s%.17g", i == 0 ? "" : ", ", numbers[i]);
  }
  return numbers.size() == 1 ? text : text + "]";
}

}  // namespace

struct FieldComparison::Place {
  bool in_step;
  std::uint64_t number;
  int tool;
};

struct FieldComparison::Visitor {
  FieldComparison* out;
  bool in_step;
  std::uint64_t number;
  const std::vector<double>* peaks;
  std::size_t place = 0;

  template <typename Value>
  void operator()(int tool, const FieldInfo& field, const Value& a, const Value& b) {
    if (field.use == FieldUse::kNotCompared) return;
    const Place at{in_step, number, tool};
    if constexpr (kIsReal<Value>) {
      const double peak = field.use == FieldUse::kRelative ? 1 : (*peaks)[place++];
      out->Real(at, field.name, peak, Numbers(a), Numbers(b));
    } else {
      out->Integer(at, field.name, static_cast<std::int64_t>(a), static_cast<std::int64_t>(b));
    }
  }
};

void FieldComparison::Measure(const HapticSample& logged, bool with_output) {
  PeakVisitor visitor{&tick_peaks_};
  VisitInput(visitor, logged);
  if (with_output) VisitOutput(visitor, logged);
}

void FieldComparison::Measure(const StepSample& logged) {
  VisitStep(PeakVisitor{&step_peaks_}, logged);
}

void FieldComparison::Compare(const HapticSample& logged, const HapticSample& replayed,
                              bool with_output) {
  Visitor visitor{this, false, logged.tick, &tick_peaks_};
  VisitInput(visitor, logged, replayed);
  if (with_output) VisitOutput(visitor, logged, replayed);
}

void FieldComparison::Compare(const StepSample& logged, const StepSample& replayed) {
  Visitor visitor{this, true, logged.step.number, &step_peaks_};
  visitor(-1, {"organ_count"}, logged.organ_count, replayed.organ_count);
  VisitStep(visitor, logged, replayed);
}

void FieldComparison::Integer(const Place& at, const char* field, std::int64_t logged,
                              std::int64_t replayed) {
  if (logged == replayed) return;
  Note({at.in_step, at.number, at.tool, field, std::to_string(logged), std::to_string(replayed),
        std::numeric_limits<double>::infinity()});
}

void FieldComparison::Real(const Place& at, const char* field, double peak,
                           std::span<const double> logged, std::span<const double> replayed) {
  double sum = 0;
  bool same = true;
  for (std::size_t i = 0; i < logged.size(); ++i) {
    if (std::bit_cast<std::uint64_t>(logged[i]) == std::bit_cast<std::uint64_t>(replayed[i])) {
      continue;
    }
    same = false;
    const double difference = logged[i] - replayed[i];
    // A value that is not finite on one side only is infinitely different.
    sum += std::isfinite(difference) ? difference * difference
                                     : std::numeric_limits<double>::infinity();
  }
  if (same) return;
  const double relative = sum == 0   ? 0
                          : peak > 0 ? std::sqrt(sum) / peak
                                     : std::numeric_limits<double>::infinity();
  Note({at.in_step, at.number, at.tool, field, Text(logged), Text(replayed), relative});
}

void FieldComparison::Note(FieldDifference difference) {
  if (!largest_ || difference.relative > largest_->relative) largest_ = difference;
  if (!first_beyond_ && difference.relative > tolerance_) first_beyond_ = difference;
  if (!first_) first_ = std::move(difference);
}

}  // namespace hpdm
