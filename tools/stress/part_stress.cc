#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <utility>

#include "tools/shared/report_text.h"
#include "tools/stress/part_cases.h"
#include "tools/stress/stress_cases.h"

namespace hpdm {

StressCase PartCase(const std::string& name, const std::string& title,
                    const StressParameter& parameter, const std::string& truth,
                    std::function<StressTrial(double value)> run) {
  StressCase stress_case;
  stress_case.name = name;
  stress_case.group = "parts";
  stress_case.title = title;
  stress_case.truth = truth;
  stress_case.parameter = parameter;
  stress_case.models = {StressModel::kStrainSmall};
  stress_case.run = [run = std::move(run)](StressModel, double value) { return run(value); };
  return stress_case;
}

StressTrial JudgePart(double error, bool finite, double stays, const std::string& how) {
  StressTrial trial = Judge(finite ? error : HUGE_VAL, kPartDegraded, kPartFailed);
  if (!how.empty()) {
    trial.fate = StressFate::kFailed;
    trial.how = how;
  }
  if (!(stays <= kPartAtRest)) {
    trial.fate = StressFate::kFailed;
    trial.how = trial.harm = Format("%.2g mm stay", 1e3 * stays);
  }
  if (!finite) trial.how = trial.harm = "not finite";
  return trial;
}

void MovePartTo(double share, OrganBench* bench) {
  bench->StayAt(kPartHalf * std::acos(1 - 2 * std::clamp(share, 0.0, 1.0)) / std::numbers::pi);
}

void MovePart(double from, double to, int steps, OrganBench* bench) {
  for (int step = 1; step <= steps; ++step) {
    MovePartTo(from + (to - from) * step / steps, bench);
    bench->Step();
  }
}

double OffRest(const OrganBench& bench, int organ) {
  return (bench.organ(organ).vertices - bench.model(organ).rest().vertices)
      .rowwise()
      .norm()
      .maxCoeff();
}

bool ShapesFinite(const OrganBench& bench) {
  for (int o = 0; o < bench.organs(); ++o) {
    if (!bench.organ(o).vertices.allFinite()) return false;
  }
  return true;
}

AttachmentOptions PartLayer(const std::string& a, const std::string& b) {
  AttachmentOptions layer;
  layer.a = a;
  layer.b = b;
  layer.region = Box{Vector3d(-1, -1, -1), Vector3d(1, 1, 1)};
  layer.young = 20000;
  layer.thickness = 0.001;
  layer.strength = 10000;
  layer.toughness = 45;
  layer.reach = 0.001;
  return layer;
}

std::vector<StressCase> PartStress(bool quick) {
  std::vector<StressCase> all;
  for (std::vector<StressCase> of_part : {AttachmentStress(quick), DuctStress(quick),
                                          LayerAndLumenStress(quick), FreeOrganStress()}) {
    std::move(of_part.begin(), of_part.end(), std::back_inserter(all));
  }
  return all;
}

}  // namespace hpdm
