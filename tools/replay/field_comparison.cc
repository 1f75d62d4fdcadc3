#include "tools/replay/field_comparison.h"

#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

template <typename Vector>
std::span<const double> Numbers(const Vector& vector) {
  return {vector.data(), static_cast<std::size_t>(vector.size())};
}
std::span<const double> Numbers(const double& number) { return {&number, 1}; }

// Calls visit.Integer(tool, field, a, b) and visit.Real(tool, field, a, b) for every field, in the
// same order each time.
template <typename Visit>
void VisitFields(const HapticSample& a, const HapticSample& b, bool with_output, Visit&& visit) {
  visit.Integer(-1, "device_time_ns", a.device_time_ns, b.device_time_ns);
  visit.Integer(-1, "paused", a.paused, b.paused);
  for (int t = 0; t < a.tool_count; ++t) {
    const ToolSample &x = a.tools[t], &y = b.tools[t];
    visit.Integer(t, "instrument_index", x.instrument_index, y.instrument_index);
    visit.Real(t, "joints", Numbers(x.joints), Numbers(y.joints));
    visit.Real(t, "p_tip_W", Numbers(x.p_tip_W), Numbers(y.p_tip_W));
    visit.Real(t, "v_tip_W", Numbers(x.v_tip_W), Numbers(y.v_tip_W));
    visit.Integer(t, "device_time_ns", x.device_time_ns, y.device_time_ns);
    visit.Integer(t, "device_valid", x.device_valid, y.device_valid);
    visit.Integer(t, "force_on", x.force_on, y.force_on);
  }
  if (!with_output) return;
  visit.Integer(-1, "patch_number", static_cast<std::int64_t>(a.patch_number),
                static_cast<std::int64_t>(b.patch_number));
  visit.Integer(-1, "patch_age_ns", a.patch_age_ns, b.patch_age_ns);
  for (int t = 0; t < a.tool_count; ++t) {
    const ToolSample &x = a.tools[t], &y = b.tools[t];
    visit.Integer(t, "organ", x.organ, y.organ);
    visit.Integer(t, "kind", static_cast<int>(x.kind), static_cast<int>(y.kind));
    visit.Real(t, "depth", Numbers(x.depth), Numbers(y.depth));
    visit.Real(t, "reaction_W", Numbers(x.reaction_W), Numbers(y.reaction_W));
    visit.Integer(t, "guard_flags", x.guard_flags, y.guard_flags);
    visit.Real(t, "energy", Numbers(x.energy), Numbers(y.energy));
    visit.Real(t, "damping", Numbers(x.damping), Numbers(y.damping));
    visit.Real(t, "force_W", Numbers(x.force_W), Numbers(y.force_W));
    visit.Real(t, "effort", Numbers(x.effort), Numbers(y.effort));
  }
}

template <typename Visit>
void VisitFields(const StepSample& a, const StepSample& b, Visit&& visit) {
  visit.Integer(-1, "number", static_cast<std::int64_t>(a.step.number),
                static_cast<std::int64_t>(b.step.number));
  visit.Integer(-1, "input_tick", static_cast<std::int64_t>(a.step.input_tick),
                static_cast<std::int64_t>(b.step.input_tick));
  visit.Integer(-1, "time_ns", a.step.time_ns, b.step.time_ns);
  visit.Integer(-1, "device_time_ns", a.step.device_time_ns, b.step.device_time_ns);
  visit.Integer(-1, "iterations", a.step.iterations, b.step.iterations);
  visit.Integer(-1, "flags", a.step.flags, b.step.flags);
  visit.Integer(-1, "shed_level", a.step.shed_level, b.step.shed_level);
  visit.Integer(-1, "organ_count", a.organ_count, b.organ_count);
  for (int o = 0; o < a.organ_count; ++o) {
    visit.Integer(-1, "organs.iterations", a.organs[o].iterations, b.organs[o].iterations);
    visit.Integer(-1, "organs.out_of_time", a.organs[o].out_of_time, b.organs[o].out_of_time);
    visit.Real(-1, "organs.finite_strain_blend", Numbers(a.organs[o].finite_strain_blend),
               Numbers(b.organs[o].finite_strain_blend));
    visit.Real(-1, "organs.refinement_weight", Numbers(a.organs[o].refinement_weight),
               Numbers(b.organs[o].refinement_weight));
  }
  for (int t = 0; t < a.tool_count; ++t) {
    const ToolPose &p = a.tools[t], &q = b.tools[t];
    visit.Real(t, "X_WT", Numbers(p.X_WT.matrix()), Numbers(q.X_WT.matrix()));
    visit.Real(t, "p_trocar_W", Numbers(p.p_trocar_W), Numbers(q.p_trocar_W));
    visit.Real(t, "v_tip_W", Numbers(p.v_tip_W), Numbers(q.v_tip_W));
    visit.Real(t, "jaw", Numbers(p.jaw), Numbers(q.jaw));
    visit.Integer(t, "instrument_index", p.instrument_index, q.instrument_index);
    const SolvedContact &x = a.contacts[t], &y = b.contacts[t];
    visit.Integer(t, "organ", x.organ, y.organ);
    visit.Integer(t, "kind", static_cast<int>(x.kind), static_cast<int>(y.kind));
    visit.Integer(t, "reaction", static_cast<int>(x.reaction), static_cast<int>(y.reaction));
    visit.Integer(t, "shaft_contact", x.shaft_contact, y.shaft_contact);
    visit.Real(t, "contact_W", Numbers(x.contact_W), Numbers(y.contact_W));
    visit.Real(t, "force_on_tissue_W", Numbers(x.force_on_tissue_W), Numbers(y.force_on_tissue_W));
    visit.Real(t, "p_original_W", Numbers(x.p_original_W), Numbers(y.p_original_W));
    visit.Real(t, "normal_W", Numbers(x.normal_W), Numbers(y.normal_W));
    visit.Real(t, "compliance_W", Numbers(x.compliance_W), Numbers(y.compliance_W));
    visit.Real(t, "coupling_W", Numbers(x.coupling_W), Numbers(y.coupling_W));
    visit.Real(t, "kernel_radius", Numbers(x.kernel_radius), Numbers(y.kernel_radius));
  }
  // The residual of a converged iteration consists of rounding errors.
  visit.Residual(a.step.residual, b.step.residual);
}

// Returns the length of the vector's finite components.
double Length(std::span<const double> numbers) {
  double sum = 0;
  for (const double x : numbers) sum += std::isfinite(x) ? x * x : 0;
  return std::sqrt(sum);
}

struct PeakVisitor {
  std::vector<double>* peaks;
  std::size_t place = 0;

  void Integer(int, const char*, std::int64_t, std::int64_t) {}
  void Real(int, const char*, std::span<const double> a, std::span<const double>) {
    if (place == peaks->size()) peaks->push_back(0);
    double& peak = (*peaks)[place++];
    peak = std::max(peak, Length(a));
  }
  void Residual(double, double) {}
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

void FieldComparison::Measure(const HapticSample& logged, bool with_output) {
  VisitFields(logged, logged, with_output, PeakVisitor{&tick_peaks_});
}

void FieldComparison::Measure(const StepSample& logged) {
  VisitFields(logged, logged, PeakVisitor{&step_peaks_});
}

struct FieldComparison::Visitor {
  FieldComparison* out;
  bool in_step;
  std::uint64_t number;
  const std::vector<double>* peaks;
  std::size_t place = 0;

  void Integer(int tool, const char* field, std::int64_t a, std::int64_t b) {
    out->Integer({in_step, number, tool}, field, a, b);
  }
  void Real(int tool, const char* field, std::span<const double> a, std::span<const double> b) {
    out->Real({in_step, number, tool}, field, (*peaks)[place++], a, b);
  }
  // The residual is relative already.
  void Residual(double a, double b) {
    out->Real({in_step, number, -1}, "residual", 1, {&a, 1}, {&b, 1});
  }
};

void FieldComparison::Compare(const HapticSample& logged, const HapticSample& replayed,
                              bool with_output) {
  VisitFields(logged, replayed, with_output, Visitor{this, false, logged.tick, &tick_peaks_});
}

void FieldComparison::Compare(const StepSample& logged, const StepSample& replayed) {
  VisitFields(logged, replayed, Visitor{this, true, logged.step.number, &step_peaks_});
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
