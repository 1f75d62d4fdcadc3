#include "tools/chart/chart_sweep.h"

#include <algorithm>
#include <utility>

#include "engine/base/error.h"
#include "engine/baselines/surface_error.h"
#include "tools/chart/chart_measure.h"
#include "tools/chart/fine_relocation.h"
#include "tools/chart/static_case_model.h"

namespace hpdm {
namespace {

// Finer models are skipped beyond a step of three frames (33 ms each) or half a minute of set-up.
constexpr double kSlowestStep = 100e3;  // us
constexpr double kSlowestSetup = 30e3;  // ms

// Values of LatticeOptions::local in the sweep.
constexpr LocalFunctionOptions kLocalFunctions[] = {{27, 2}, {27, 3}, {27, 4},
                                                    {64, 2}, {64, 3}, {64, 4}};

EnergyOptions Strain(StrainMeasure strain, SolverType solver) {
  EnergyOptions energy;
  energy.type = EnergyType::kStrain;
  energy.strain = strain;
  energy.solver = solver;
  return energy;
}

EnergyOptions Metric(EnergyDomain domain, SolverType solver) {
  EnergyOptions energy;
  energy.type = EnergyType::kMetric;
  energy.domain = domain;
  energy.solver = solver;
  return energy;
}

LatticeOptions BSpline(int degree, const LocalFunctionOptions& local = {.functions = 0}) {
  LatticeOptions lattice;
  lattice.degree = {degree, degree, degree};
  lattice.local = local;
  return lattice;
}

LatticeOptions Adaptive(int functions, int levels) {
  LatticeOptions lattice = BSpline(2);
  lattice.adaptive = {functions, levels};
  return lattice;
}

LatticeOptions Bernstein() {
  LatticeOptions lattice;
  lattice.basis = BasisType::kBernstein;
  lattice.local.functions = 0;
  return lattice;
}

OrganOptions OrganOf(const ChartFamily& family, int size, const OrganOptions& organ) {
  OrganOptions options = organ;
  const double margin = organ.lattice.margin;
  options.model = family.model;
  options.energy = family.energy;
  options.energy.law = organ.energy.law;
  options.lattice = family.lattice;
  options.lattice.margin = margin;
  if (family.lattice.basis == BasisType::kBSpline) {
    options.lattice.cells = {size, size, size};
  } else {
    options.lattice.cells = {1, 1, 1};
    options.lattice.degree = {size, size, size};
  }
  return options;
}

// True if the case's author chose a lattice that no family has.
bool HasCellsOfItsOwn(const OrganOptions& options) {
  const auto& [l, m, n] = options.lattice.cells;
  return options.model == OrganModelType::kHpdm && (l != m || m != n);
}

ChartPoint Measure(const StaticCase& load_case, const CaseReference& reference,
                   const Points& fine_vertices, const OrganOptions& options, bool hollow) {
  ChartPoint point = Labelled(CaseName(load_case), hollow, options);
  StaticCaseModel body(load_case, options);
  point.unknowns = body.unknowns();
  point.setup_ms = body.setup_ms();
  point.fitted = !HasModulus(options);
  const bool balanced =
      TakeToRest(load_case.rest, load_case.scene.loads, reference.displacements, options, &body);
  const StaticCaseModel::StepTimes times = body.TimeSteps();
  point.response = times.response;
  point.iterations = times.last.iterations;
  point.residual = times.last.residual;
  point.converged = balanced && times.last.converged;
  point.error =
      RelativeSurfaceError(load_case.rest, body.VertexDisplacements(), reference.displacements);
  if (!point.fitted) point.compliance_ratio = body.Compliance() / reference.compliance;
  if (body.lattice_organ()) {
    point.local_functions = body.local_functions();
    point.relocation = Sum(times.relocation, times.indentations);
    point.relocation_30k =
        TimeFineRelocation(body, fine_vertices, times.indentations, load_case.rest.vertices.rows());
  }
  return point;
}

void AddTetrahedra(const StaticCase& load_case, const CaseReference& reference, bool hollow,
                   std::vector<ChartPoint>* points) {
  for (const ComparedTetrahedra& mesh : reference.compared) {
    ChartPoint point;
    point.load_case = CaseName(load_case);
    point.hollow = hollow;
    point.model = mesh.quadratic ? "quadratic_graded"
                  : mesh.graded  ? "linear_graded"
                                 : "linear_tetrahedra";
    point.unknowns = mesh.nodes;
    point.error = mesh.error;
    point.compliance_ratio = mesh.compliance_ratio;
    points->push_back(point);
  }
}

}  // namespace

const std::vector<std::string>& ChartGroups() {
  static const std::vector<std::string> groups = {"uniform",   "local",       "adaptive", "finite",
                                                  "metric",    "surface",     "linear",   "cubic",
                                                  "bernstein", "gauss-seidel"};
  return groups;
}

std::vector<ChartFamily> ChartFamilies(bool quick, const std::set<std::string>& only) {
  using enum SolverType;
  const EnergyOptions small = Strain(StrainMeasure::kSmall, kCholesky);
  std::vector<ChartFamily> families;
  const auto add = [&](const char* group, const EnergyOptions& energy,
                       const LatticeOptions& lattice, std::vector<int> sizes) {
    if (quick) sizes = {2, 4};
    families.push_back({group, OrganModelType::kHpdm, energy, lattice, std::move(sizes)});
  };
  add("uniform", small, BSpline(2), {2, 3, 4, 5, 6, 7, 8, 9, 10});
  for (const LocalFunctionOptions& local : kLocalFunctions) {
    if (quick && (local.functions < 64 || local.refinement > 2)) continue;
    add("local", small, BSpline(2, local), {4, 6});
  }
  add("finite", Strain(StrainMeasure::kFinite, kCholesky), BSpline(2), {2, 3, 4});
  add("metric", Metric(EnergyDomain::kOrgan, kCholesky), BSpline(2), {2, 4, 6, 8, 10});
  families.push_back({"surface", OrganModelType::kContinuum, {}, {}, {1}});
  families.push_back({"surface", OrganModelType::kMassSpring, {}, {}, {1}});
  if (!quick) {
    add("local", small, BSpline(2, kLocalFunctions[3]), {2, 3, 8});
    add("local", small, BSpline(2, {18, 2}), {4});  // about 200 functions together
    add("adaptive", small, Adaptive(180, 2), {3});
    add("adaptive", small, Adaptive(480, 2), {4, 6});
    add("linear", small, BSpline(1), {2, 4, 6, 8, 10});
    add("cubic", small, BSpline(3), {2, 3, 4, 5, 6, 8});
    add("bernstein", small, Bernstein(), {2, 3, 4, 5, 6});
    add("gauss-seidel", Strain(StrainMeasure::kSmall, kGaussSeidel), BSpline(2), {2, 3, 4, 6});
    add("gauss-seidel", Metric(EnergyDomain::kOrgan, kGaussSeidel), BSpline(2), {2, 4, 6});
    add("metric", Metric(EnergyDomain::kBox, kCholesky), BSpline(2), {2, 4, 6, 8});
    // The paper's own.
    add("gauss-seidel", Metric(EnergyDomain::kBox, kGaussSeidel), Bernstein(), {2, 3, 4, 6});
  }
  if (!only.empty()) {
    std::erase_if(families,
                  [&](const ChartFamily& family) { return !only.contains(family.group); });
  }
  return families;
}

ChartSweep SweepCase(const StaticCase& load_case, const CaseReference& reference,
                     const std::vector<ChartFamily>& families,
                     const std::function<void(const ChartPoint&)>& progress) {
  ChartSweep sweep;
  const bool hollow = IsHollow(load_case.rest);
  const Points fine_vertices = FineVertices(load_case.rest);
  for (const ChartFamily& family : families) {
    for (const int size : family.sizes) {
      const OrganOptions options = OrganOf(family, size, load_case.organ);
      try {
        sweep.points.push_back(Measure(load_case, reference, fine_vertices, options, hollow));
      } catch (const InputError& error) {
        const ChartPoint point = Labelled(CaseName(load_case), hollow, options);
        sweep.remarks.push_back(point.load_case + ": " + Describe(point) +
                                " and finer is left out: " + error.what());
        break;
      }
      const ChartPoint& point = sweep.points.back();
      progress(point);
      if (point.StepMicroseconds() > kSlowestStep || *point.setup_ms > kSlowestSetup) {
        sweep.remarks.push_back(point.load_case + ": finer than " + Describe(point) +
                                " is left out: too slow");
        break;
      }
    }
  }
  if (HasCellsOfItsOwn(load_case.organ)) {
    sweep.points.push_back(Measure(load_case, reference, fine_vertices, load_case.organ, hollow));
    progress(sweep.points.back());
  }
  AddTetrahedra(load_case, reference, hollow, &sweep.points);
  return sweep;
}

}  // namespace hpdm
