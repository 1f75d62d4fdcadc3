#include "tools/chart/chart_point.h"

#include <cmath>
#include <limits>
#include <numeric>

#include "tools/shared/json_rows.h"
#include "tools/shared/pareto_front.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

std::string Cells(const ChartPoint& point, const std::string& times, const std::string& cubed) {
  const auto& [l, m, n] = point.cells;
  if (l == m && m == n) return std::to_string(l) + cubed;
  return std::to_string(l) + times + std::to_string(m) + times + std::to_string(n);
}

template <typename T>
Json OrNull(const std::optional<T>& value) {
  return value.has_value() ? Json(*value) : Json();
}

void Add(const std::string& name, const std::optional<Timing>& timing, Json* json) {
  (*json)[name + "_us"] = timing ? Json(timing->median_us) : Json();
  (*json)[name + "_min_us"] = timing ? Json(timing->minimum_us) : Json();
}

// True if the point can take part in a comparison.
bool Counts(const ChartPoint& point) {
  return point.converged && std::isfinite(point.error) && std::isfinite(point.StepMicroseconds());
}

double Sum(const ChartPoint& point, double Timing::*which) {
  if (!point.response) return std::numeric_limits<double>::infinity();
  return (*point.response).*which + (point.relocation_30k ? (*point.relocation_30k).*which : 0);
}

}  // namespace

double ChartPoint::StepMicroseconds() const { return Sum(*this, &Timing::median_us); }
double ChartPoint::StepMinimumMicroseconds() const { return Sum(*this, &Timing::minimum_us); }

Json ToJson(const ChartPoint& point) {
  Json json = {{"case", point.load_case},
               {"hollow", point.hollow ? 1 : 0},
               {"model", point.model},
               {"energy", point.energy},
               {"strain", point.strain},
               {"basis", point.basis},
               {"degree", point.degree},
               {"cells", Cells(point, "x", "")},
               {"unknowns", point.unknowns},
               {"solver", point.solver},
               {"local_functions", point.local_functions},
               {"local_refinement", point.local_refinement},
               {"error", std::isfinite(point.error) ? Json(point.error) : Json()},
               {"compliance_ratio", OrNull(point.compliance_ratio)},
               {"fitted", point.fitted ? 1 : 0},
               {"iterations", OrNull(point.iterations)},
               {"residual", OrNull(point.residual)},
               {"converged", point.converged ? 1 : 0},
               {"setup_ms", OrNull(point.setup_ms)}};
  Add("response", point.response, &json);
  Add("relocation", point.relocation, &json);
  Add("relocation_30k", point.relocation_30k, &json);
  json["step_us"] = point.response ? Json(point.StepMicroseconds()) : Json();
  json["step_min_us"] = point.response ? Json(point.StepMinimumMicroseconds()) : Json();
  json["adaptive_levels"] = point.adaptive_levels;
  return json;
}

std::string ChartCsv(const std::vector<ChartPoint>& points,
                     const std::vector<std::string>& header) {
  std::string text;
  for (const std::string& line : header) text += "# " + line + "\n";
  text += CsvNames(ToJson(ChartPoint()));
  for (const ChartPoint& point : points) text += CsvValues(ToJson(point));
  return text;
}

std::vector<std::size_t> ParetoFront(const std::vector<ChartPoint>& points) {
  std::vector<CostAndError> costs;
  for (const ChartPoint& point : points) {
    costs.push_back({Counts(point), point.StepMicroseconds(), point.error});
  }
  return ParetoFront(costs);
}

const ChartPoint* BestWithin(const std::vector<ChartPoint>& points, double budget_us) {
  const ChartPoint* best = nullptr;
  for (const std::size_t i : ParetoFront(points)) {
    if (points[i].StepMicroseconds() <= budget_us) best = &points[i];
  }
  return best;
}

std::string Describe(const ChartPoint& point) {
  if (point.model != "hpdm") return point.model;
  static const char* const kDegrees[] = {"", "linear ", "quadratic ", "cubic "};
  std::string text = point.energy;
  if (point.energy == "metric" || point.strain == "finite") text += " (" + point.strain + ")";
  if (point.basis == "bspline") {
    text += std::string(", ") + kDegrees[point.degree] + "B-spline " + Cells(point, " x ", "^3");
  } else {
    text += ", Bernstein of degree " + std::to_string(point.degree);
  }
  if (point.local_functions > 0) {
    text += " + " + std::to_string(point.local_functions) + " local (1/" +
            std::to_string(point.local_refinement) + ")";
  }
  if (point.adaptive_levels > 0) {
    text += " + " + std::to_string(point.adaptive_levels) +
            (point.adaptive_levels > 1 ? " adaptive levels" : " adaptive level");
  }
  text += ", n " + std::to_string(point.unknowns);
  if (point.solver == "gauss_seidel") text += ", Gauss-Seidel";
  return text;
}

}  // namespace hpdm
