#include "tools/stress/stress_case.h"

#include <array>
#include <cmath>

#include "engine/base/check.h"
#include "engine/base/error.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

struct ModelFacts {
  const char* name;
  const char* title;
};
constexpr std::array<ModelFacts, kStressModels> kModels = {{
    {"strain_small", "strain, small"},
    {"strain_finite", "strain, finite"},
    {"metric_small", "metric, small"},
    {"metric_finite", "metric, finite"},
    {"continuum", "surface continuum"},
    {"mass_spring", "mass-spring"},
    {"linear_tetrahedra", "linear tetrahedra"},
    {"point_proxy", "point proxy"},
}};

}  // namespace

std::string Name(StressModel model) { return kModels[static_cast<std::size_t>(model)].name; }

std::string Title(StressModel model) { return kModels[static_cast<std::size_t>(model)].title; }

bool IsOurs(StressModel model) { return model <= StressModel::kMetricFinite; }

void Choose(StressModel model, OrganOptions* options) {
  HPDM_CHECK(model < StressModel::kLinearTetrahedra);
  if (model == StressModel::kContinuum || model == StressModel::kMassSpring) {
    options->model =
        model == StressModel::kContinuum ? OrganModelType::kContinuum : OrganModelType::kMassSpring;
    return;
  }
  const bool strain = model == StressModel::kStrainSmall || model == StressModel::kStrainFinite;
  const bool small = model == StressModel::kStrainSmall || model == StressModel::kMetricSmall;
  options->energy.type = strain ? EnergyType::kStrain : EnergyType::kMetric;
  options->lattice.local.functions = 0;
  options->energy.strain = small ? StrainMeasure::kSmall : StrainMeasure::kFinite;
}

StressTrial Judge(double error, double degraded_from, double failed_from) {
  StressTrial trial;
  trial.error = error;
  if (!(error < failed_from)) {
    trial.fate = StressFate::kFailed;
  } else if (error >= degraded_from) {
    trial.fate = StressFate::kDegraded;
  }
  return trial;
}

double Between(const StressParameter& parameter, double a, double b, double share) {
  if (!parameter.logarithmic) return a + share * (b - a);
  return a * std::pow(b / a, share);
}

StressResult Examine(const StressCase& stress_case, StressModel model, int rounds) {
  const StressParameter& parameter = stress_case.parameter;
  StressResult result;
  result.model = model;
  const auto run = [&](double value) {
    StressTrial trial;
    try {
      trial = stress_case.run(model, value);
    } catch (const InputError& refused) {
      trial.fate = StressFate::kFailed;
      trial.how = std::string("refused: ") + refused.what();
    }
    ++result.trials;
    if (IsOurs(model) && result.harm.empty() && !trial.harm.empty()) {
      result.harm = trial.harm + Format(" at %.4g %s", value, parameter.unit.c_str());
    }
    if (trial.fate == StressFate::kFailed) {
      result.fails_from = value;
      result.fails_how = trial.how;
    } else {
      result.holds_to = value;
    }
    return trial;
  };
  result.asked = run(parameter.asked);
  const double other = result.fails_from ? parameter.easy : parameter.utmost;
  if (other != parameter.asked) run(other);
  for (int round = 0; round < rounds && result.holds_to && result.fails_from; ++round) {
    run(Between(parameter, *result.holds_to, *result.fails_from, 0.5));
  }
  return result;
}

}  // namespace hpdm
