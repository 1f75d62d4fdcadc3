#include "tools/plan/plan_families.h"

#include <algorithm>
#include <cmath>

#include "engine/lattice/lattice.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

constexpr double kTightMargin = 0.01;  // share of the longest side
constexpr double kMarginStep = 1e-4;   // m: the precision of a scene's text

std::array<int, 3> Cubes(const OrganOptions& organ, const SurfaceMesh& rest, double margin,
                         int size) {
  const Vector3d lengths = BoundingLatticeBox(rest.vertices, organ.X_WO.linear(), margin).lengths;
  std::array<int, 3> cells;
  for (int d = 0; d < 3; ++d) {
    cells[d] = std::max(1, static_cast<int>(std::lround(size * lengths[d] / lengths.maxCoeff())));
  }
  return cells;
}

double TightMargin(const OrganOptions& organ, const SurfaceMesh& rest) {
  const double longest =
      BoundingLatticeBox(rest.vertices, organ.X_WO.linear(), 0).lengths.maxCoeff();
  return kMarginStep * std::ceil(kTightMargin * longest / kMarginStep);
}

}  // namespace

std::vector<PlanFamily> PlanFamilies(bool finite) {
  using enum PlanFamily::Cells;
  std::vector<PlanFamily> families = {
      {.name = "quadratic", .sizes = {3, 4, 5, 6, 7, 8, 9, 10, 12}},
      {.name = "quadratic + 27 local", .local = {27, 2}, .sizes = {4, 5, 6, 8, 10}},
      {.name = "quadratic + 64 local", .local = {64, 2}, .sizes = {4, 6, 8, 10, 12}},
      {.name = "quadratic + 27 local (1/3)", .local = {27, 3}, .sizes = {4, 6, 8}},
      {.name = "quadratic + 64 local (1/3)", .local = {64, 3}, .sizes = {4, 6, 8}},
      {.name = "quadratic + 160 local", .local = {160, 2}, .sizes = {8, 10, 12}},
      {.name = "quadratic, author's margin, equal counts",
       .cells = kEqual,
       .tight = false,
       .sizes = {4, 6, 8, 10}},
      {.name = "linear", .degree = 1, .sizes = {4, 8, 12}},
      {.name = "cubic", .degree = 3, .sizes = {3, 4, 5, 6, 8}},
      {.name = "Bernstein", .cells = kDegree, .sizes = {3, 4, 5, 6}},
      {.name = "quadratic, Gauss-Seidel", .solver = SolverType::kGaussSeidel, .sizes = {3}},
      {.name = "metric", .energy = EnergyType::kMetric, .sizes = {4, 6}},
  };
  if (!finite) return families;
  using enum StrainMeasure;
  families.push_back({.name = "quadratic, finite", .strain = kFinite, .sizes = {2, 3, 4, 5, 6}});
  families.push_back({.name = "quadratic + 27 local, finite",
                      .local = {27, 2},
                      .strain = kFinite,
                      .sizes = {3, 4, 5, 6}});
  families.push_back({.name = "quadratic + 27 local, adaptive",
                      .local = {27, 2},
                      .strain = kAdaptive,
                      .sizes = {3, 4, 5, 6}});
  return families;
}

OrganOptions MemberOf(const PlanFamily& family, int size, const OrganOptions& organ,
                      const SurfaceMesh& rest) {
  OrganOptions options = organ;
  options.model = OrganModelType::kHpdm;
  options.energy.type = family.energy;
  options.energy.strain = family.strain;
  options.energy.solver = family.solver;
  options.lattice = LatticeOptions();
  options.lattice.margin = family.tight ? TightMargin(organ, rest) : organ.lattice.margin;
  options.lattice.degree = {family.degree, family.degree, family.degree};
  options.lattice.local = family.local;
  switch (family.cells) {
    case PlanFamily::Cells::kCubes:
      options.lattice.cells = Cubes(organ, rest, options.lattice.margin, size);
      break;
    case PlanFamily::Cells::kEqual:
      options.lattice.cells = {size, size, size};
      break;
    case PlanFamily::Cells::kDegree:
      options.lattice.basis = BasisType::kBernstein;
      options.lattice.cells = {1, 1, 1};
      options.lattice.degree = {size, size, size};
      break;
  }
  return options;
}

const char* StrainName(StrainMeasure strain) {
  switch (strain) {
    case StrainMeasure::kSmall:
      return "small";
    case StrainMeasure::kFinite:
      return "finite";
    case StrainMeasure::kAdaptive:
      return "adaptive";
  }
  return "";
}

std::string DescribeModel(const OrganOptions& organ) {
  static const char* const kDegrees[] = {"", "linear", "quadratic", "cubic"};
  const LatticeOptions& lattice = organ.lattice;
  std::string text = organ.energy.type == EnergyType::kMetric ? "metric, " : "";
  if (organ.energy.strain != StrainMeasure::kSmall) {
    text += std::string(StrainName(organ.energy.strain)) + " strain, ";
  }
  if (lattice.basis == BasisType::kBSpline) {
    text += Format("%s B-spline %d x %d x %d", kDegrees[lattice.degree[0]], lattice.cells[0],
                   lattice.cells[1], lattice.cells[2]);
  } else {
    text += Format("Bernstein of degree %d", lattice.degree[0]);
  }
  if (const int functions = LocalFunctionsOf(organ); functions > 0) {
    text += Format(" + %d local (1/%d)", functions, lattice.local.refinement);
  }
  text += Format(", margin %.3g mm", 1000 * lattice.margin);
  if (organ.energy.solver == SolverType::kGaussSeidel) text += ", Gauss-Seidel";
  return text;
}

double SetupWork(const OrganOptions& organ) {
  double functions = 1, finer = 1;
  for (int d = 0; d < 3; ++d) {
    functions *= organ.lattice.cells[d] + organ.lattice.degree[d];
    finer *= organ.lattice.local.refinement * organ.lattice.cells[d] + organ.lattice.degree[d];
  }
  const double unknowns = 3 * functions;
  const double newton = organ.energy.strain != StrainMeasure::kSmall ? 30 : 1;
  return newton * unknowns * unknowns * unknowns +
         (LocalFunctionsOf(organ) > 0 ? 100 * unknowns * finer : 0);
}

}  // namespace hpdm
