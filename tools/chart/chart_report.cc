#include "tools/chart/chart_report.h"

#include <algorithm>
#include <cstdlib>

#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

constexpr int kComparedNodes = 4000;
constexpr int kFewFunctions = 200;  // including local functions

std::string Ratio(const std::optional<double>& ratio) {
  return ratio ? Format("%.2f", *ratio) : "-";
}

std::string Entry(const ChartPoint* point) {
  if (point == nullptr) return "none";
  return Format("**%.1f %%** (%s), %s: %s", 100 * point->error,
                Ratio(point->compliance_ratio).c_str(), Duration(point->StepMicroseconds()).c_str(),
                Describe(*point).c_str());
}

struct Tetrahedra {
  const char* model;
  const char* name;
};
constexpr Tetrahedra kTetrahedra[] = {{"linear_tetrahedra", "linear tetrahedra of one size"},
                                      {"linear_graded", "linear tetrahedra, graded"},
                                      {"quadratic_graded", "quadratic tetrahedra, graded"}};

const ChartPoint* Compared(const std::vector<ChartPoint>& points, const char* model) {
  const ChartPoint* best = nullptr;
  for (const ChartPoint& point : points) {
    if (point.model != model) continue;
    if (best == nullptr ||
        std::abs(point.unknowns - kComparedNodes) < std::abs(best->unknowns - kComparedNodes)) {
      best = &point;
    }
  }
  return best;
}

}  // namespace

std::vector<std::vector<ChartPoint>> ByCase(const std::vector<ChartPoint>& points) {
  std::vector<std::vector<ChartPoint>> cases;
  for (const ChartPoint& point : points) {
    const auto at = std::find_if(cases.begin(), cases.end(), [&](const auto& of_case) {
      return of_case[0].load_case == point.load_case;
    });
    if (at == cases.end()) {
      cases.push_back({point});
    } else {
      at->push_back(point);
    }
  }
  std::stable_partition(cases.begin(), cases.end(),
                        [](const auto& of_case) { return !of_case[0].hollow; });
  return cases;
}

std::string ChartMarkdown(const std::vector<ChartPoint>& points, const std::string& machine) {
  std::string text =
      "| case | best within 1 ms | best within 33 ms | best of at most 200 functions |";
  for (const Tetrahedra& kind : kTetrahedra) text += Format(" %s |", kind.name);
  text += "\n|---|---|---|---|---|---|---|\n";
  for (const std::vector<ChartPoint>& of_case : ByCase(points)) {
    text += Format("| `%s`%s |", of_case[0].load_case.c_str(), of_case[0].hollow ? ", hollow" : "");
    std::vector<ChartPoint> small;
    for (const ChartPoint& point : of_case) {
      const bool few = point.unknowns + point.local_functions <= kFewFunctions;
      if (point.model == "hpdm" && few) small.push_back(point);
    }
    const ChartPoint* tick = BestWithin(of_case, kTickBudgetUs);
    const ChartPoint* frame = BestWithin(of_case, kFrameBudgetUs);
    const ChartPoint* of_few = BestWithin(small, kFrameBudgetUs);
    text += Format(" %s | %s | %s |", Entry(tick).c_str(),
                   frame != nullptr && frame == tick ? "the same" : Entry(frame).c_str(),
                   Entry(of_few).c_str());
    for (const Tetrahedra& kind : kTetrahedra) {
      const ChartPoint* mesh = Compared(of_case, kind.model);
      text +=
          mesh ? Format(" %.1f %% (%s), %s nodes |", 100 * mesh->error,
                        Ratio(mesh->compliance_ratio).c_str(), WithCommas(mesh->unknowns).c_str())
               : " - |";
    }
    text += "\n";
  }
  return text +
         "\nError: area-weighted relative L2 of the surface displacement against fine quadratic "
         "tetrahedra; in brackets the compliance under the load over theirs. Graded meshes are "
         "finer at the load. Step: median; "
         "reposition, relax and relocate a surface of 30,000 triangles; " +
         machine + ".\n";
}

std::string ChartText(const std::vector<ChartPoint>& points) {
  std::string text;
  for (const std::vector<ChartPoint>& of_case : ByCase(points)) {
    text += of_case[0].load_case + (of_case[0].hollow ? " (hollow: the hard case)\n" : "\n");
    for (const double budget : {kTickBudgetUs, kFrameBudgetUs}) {
      const ChartPoint* best = BestWithin(of_case, budget);
      text += Format("  within %2.0f ms: ", budget / 1000);
      text += best == nullptr
                  ? std::string("none\n")
                  : Format("error %5.1f %%, compliance %s, step %8s: %s\n", 100 * best->error,
                           Ratio(best->compliance_ratio).c_str(),
                           Duration(best->StepMicroseconds()).c_str(), Describe(*best).c_str());
    }
    for (const Tetrahedra& kind : kTetrahedra) {
      const ChartPoint* mesh = Compared(of_case, kind.model);
      if (mesh == nullptr) continue;
      text += Format("  %s, %d nodes: error %5.1f %%, compliance %s\n", kind.name, mesh->unknowns,
                     100 * mesh->error, Ratio(mesh->compliance_ratio).c_str());
    }
  }
  return text;
}

}  // namespace hpdm
