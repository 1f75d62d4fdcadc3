#include <algorithm>
#include <functional>

#include "engine/base/check.h"
#include "tools/bench/bench_results.h"
#include "tools/bench/bench_scene.h"

namespace hpdm {
namespace {

RepeatOptions Repeats(bool quick) {
  return quick ? RepeatOptions{2, 200, 50} : RepeatOptions{5, 2000, 1500};
}

EnergyOptions Metric(SolverType solver) {
  EnergyOptions energy;
  energy.type = EnergyType::kMetric;
  energy.solver = solver;
  return energy;
}

EnergyOptions Strain() {
  EnergyOptions energy;
  energy.type = EnergyType::kStrain;
  return energy;
}

struct LatticeRow {
  const char* name;
  EnergyOptions energy;
  int cells;
  int local_functions = 0;
};
struct ContinuumRow {
  const char* name;
  ContinuumStep step;
};

void Configure(const LatticeRow& row, BenchOrgan* organ) {
  organ->options.energy = row.energy;
  organ->options.lattice.cells = {row.cells, row.cells, row.cells};
  organ->options.lattice.local.functions = row.local_functions;
}

// Returns the times of two things run in turn, us a step. A cycle of two steps, in and out, is
// timed as one: iterative solvers need more sweeps for one than for the other.
std::vector<std::vector<double>> TimeCycles(const std::function<void()>& first,
                                            const std::function<void()>& second,
                                            const RepeatOptions& repeats) {
  const auto cycle = [](const std::function<void()>& step) {
    return [&step] {
      step();
      step();
    };
  };
  auto times = TimeInTurn({cycle(first), cycle(second)}, repeats);
  for (std::vector<double>& of_one : times) {
    for (double& time : of_one) time /= 2;
  }
  return times;
}

// Compares one lattice with the continuum in each way of stepping it, summed over all organs.
void Compare(const LatticeRow& lattice, const std::vector<ContinuumRow>& continuum_rows,
             std::vector<BenchOrgan> organs, const RepeatOptions& repeats,
             std::vector<ModelComparison>* rows) {
  std::vector<BenchModel> lattices;
  for (BenchOrgan& organ : organs) {
    Configure(lattice, &organ);
    lattices.emplace_back(organ);
  }
  const auto step = [](std::vector<BenchModel>* bodies) {
    return [bodies] {
      for (BenchModel& body : *bodies) body.Step();
    };
  };
  const auto residual = [](const std::vector<BenchModel>& bodies) {
    double largest = 0;
    for (const BenchModel& body : bodies) largest = std::max(largest, body.StaticResidual());
    return largest;
  };
  for (const ContinuumRow& continuum : continuum_rows) {
    std::vector<BenchModel> continua;
    for (const BenchOrgan& organ : organs) continua.emplace_back(organ, continuum.step);
    const auto times = TimeCycles(step(&lattices), step(&continua), repeats);
    rows->push_back({lattice.name, continuum.name, organs.size() > 1, Summary(times[0]),
                     Summary(times[1]), residual(lattices), residual(continua),
                     RatioOf(times[1], times[0])});
  }
}

}  // namespace

std::vector<ModelComparison> CompareModels(bool quick) {
  const LatticeRow tissue = {"strain, 6^3 cells, Cholesky", Strain(), 6};
  const LatticeRow local = {"strain, 6^3 cells + 64 local, Cholesky", Strain(), 6, 64};
  const LatticeRow paper = {"metric, 4^3 cells, Cholesky", Metric(SolverType::kCholesky), 4};
  const LatticeRow iterative = {"metric, 4^3 cells, Gauss-Seidel", Metric(SolverType::kGaussSeidel),
                                4};
  const ContinuumRow prefactored = {"Cholesky, factorised once", ContinuumStep::kPrefactored};
  const ContinuumRow anew = {"Cholesky, factorised every step", ContinuumStep::kFactorisedAnew};
  const ContinuumRow sweeps = {"Gauss-Seidel", ContinuumStep::kGaussSeidel};
  const BenchOrgan liver = MakeBenchOrgan("liver_1332");
  const BenchOrgan stomach = MakeBenchOrgan("stomach_2132");
  std::vector<ModelComparison> rows;
  for (const bool second : {false, true}) {
    std::vector<BenchOrgan> organs = {liver};
    if (second) organs.push_back(stomach);
    Compare(paper, {prefactored, anew}, organs, Repeats(quick), &rows);
    if (!quick) Compare(tissue, {prefactored, anew}, organs, Repeats(quick), &rows);
    if (!quick) Compare(local, {prefactored, anew}, organs, Repeats(quick), &rows);
    if (!quick || !second) Compare(iterative, {sweeps}, organs, Repeats(quick), &rows);
  }
  return rows;
}

std::vector<MeshComparison> CompareMeshes(bool quick) {
  std::vector<LatticeRow> lattices = {{"metric, 4^3 cells", Metric(SolverType::kCholesky), 4}};
  if (!quick) {
    lattices.push_back({"strain, 6^3 cells", Strain(), 6});
    lattices.push_back({"strain, 6^3 cells + 64 local", Strain(), 6, 64});
  }
  std::vector<MeshComparison> rows;
  for (const LatticeRow& lattice : lattices) {
    for (const int instruments : {0, 2}) {
      BenchOrgan coarse = MakeBenchOrgan("liver_274"), fine = MakeBenchOrgan("liver_1332");
      Configure(lattice, &coarse);
      Configure(lattice, &fine);
      BenchScene coarse_scene({coarse}, instruments), fine_scene({fine}, instruments);
      const auto times =
          TimeCycles([&] { coarse_scene.Step(); }, [&] { fine_scene.Step(); }, Repeats(quick));
      HPDM_CHECK(coarse_scene.AllPress() && fine_scene.AllPress());
      rows.push_back({lattice.name, instruments, fine_scene.polygons(), Summary(times[0]),
                      Summary(times[1]), static_cast<int>(coarse.rest.triangles.rows()),
                      static_cast<int>(fine.rest.triangles.rows()), RatioOf(times[1], times[0])});
    }
  }
  return rows;
}

}  // namespace hpdm
