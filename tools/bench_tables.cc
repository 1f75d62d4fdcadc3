#include <algorithm>
#include <functional>

#include "engine/check.h"
#include "engine/deformation_loop.h"
#include "scenes/instrument_mesh.h"
#include "tools/bench_figures.h"
#include "tools/pressed_body.h"

namespace hpdm {
namespace {

RepeatOptions Repeats(bool quick) {
  return quick ? RepeatOptions{2, 200, 50} : RepeatOptions{5, 2000, 1500};
}

EnergyOptions Metric(SolverType solver) {
  EnergyOptions energy;
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

// Times of two things in turn, us a step. A cycle of two steps, deeper and back, is taken together:
// iterative solvers need more sweeps for one than for the other.
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

// One lattice against the continuum in each way of stepping it, on all organs together.
void Compare(const LatticeRow& lattice, const std::vector<ContinuumRow>& continuum_rows,
             std::vector<BenchOrgan> organs, const RepeatOptions& repeats,
             std::vector<ModelComparison>* rows) {
  std::vector<PressedBody> lattices;
  for (BenchOrgan& organ : organs) {
    Configure(lattice, &organ);
    lattices.emplace_back(organ);
  }
  const auto step = [](std::vector<PressedBody>* bodies) {
    return [bodies] {
      for (PressedBody& body : *bodies) body.Step();
    };
  };
  const auto residual = [](const std::vector<PressedBody>& bodies) {
    double largest = 0;
    for (const PressedBody& body : bodies) largest = std::max(largest, body.StaticResidual());
    return largest;
  };
  for (const ContinuumRow& continuum : continuum_rows) {
    std::vector<PressedBody> continua;
    for (const BenchOrgan& organ : organs) continua.emplace_back(organ, continuum.step);
    const auto times = TimeCycles(step(&lattices), step(&continua), repeats);
    rows->push_back({lattice.name, continuum.name, organs.size() > 1, Summary(times[0]),
                     Summary(times[1]), residual(lattices), residual(continua),
                     RatioOf(times[1], times[0])});
  }
}

// A session's deformation loop under instruments that press in front, without devices or threads.
class PressedScene {
 public:
  PressedScene(const BenchOrgan& organ, int instruments)
      : probe_(ProbeMesh()),
        organs_(Organs(organ)),
        render_(SizedSnapshot(organs_, instruments, true)),
        telemetry_(SizedSnapshot(organs_, instruments, false)),
        loop_(organs_, std::vector<ToolOptions>(static_cast<std::size_t>(instruments)),
              {tool_states_, patches_, render_, telemetry_}) {
    tools_.tool_count = instruments;
    for (int i = 0; i < instruments; ++i) {
      const SurfaceMesh& rest = organs_[0].rest();
      const SurfacePoint at = FrontPoint(rest, i == 0 ? -0.04 : 0.05);
      const Vector3d p = at.Position(rest.vertices, rest.triangles);
      entry_[i] = p;
      tools_.tools[i].p_trocar_W = p + Vector3d(0, 0, 0.15);
      tools_.tools[i].X_WT.translation() = p + Vector3d(0, 0, 0.02);
    }
    posed_.assign(static_cast<std::size_t>(instruments), probe_.vertices);
    loop_.Step(tools_, 0);  // outside, so that the tips enter with the next one
  }

  void Step() {
    deep_ = !deep_;
    for (int i = 0; i < tools_.tool_count; ++i) {
      Isometry3d& X_WT = tools_.tools[i].X_WT;
      X_WT.translation() = entry_[i] - Vector3d(0, 0, deep_ ? 0.006 : 0.005);
      // What an eye sees of the instrument; collisions take its capsule and the tip's ball.
      Points& posed = posed_[static_cast<std::size_t>(i)];
      posed.noalias() = probe_.vertices * X_WT.linear().transpose();
      posed.rowwise() += X_WT.translation().transpose();
    }
    now_ns_ += kNanosecondsPerSecond / 30;
    loop_.Step(tools_, now_ns_);
  }

  bool AllPress() const {
    int pressing = 0;
    const OrganState& state = loop_.organ(0);
    for (int i = 0; i < state.contacts.size(); ++i) {
      pressing += !state.contacts[i].shaft && state.contacts[i].force_W.norm() > 0;
    }
    return pressing == tools_.tool_count;
  }
  int polygons() const { return tools_.tool_count * static_cast<int>(probe_.triangles.rows()); }

 private:
  static std::vector<OrganModel> Organs(const BenchOrgan& organ) {
    std::vector<OrganModel> organs;
    organs.emplace_back(organ.options, organ.rest);
    return organs;
  }

  SurfaceMesh probe_;
  std::vector<OrganModel> organs_;
  TripleBuffer<ToolState> tool_states_;
  TripleBuffer<ContactPatch> patches_;
  TripleBuffer<SceneSnapshot> render_, telemetry_;
  DeformationLoop loop_;
  ToolState tools_;
  std::array<Vector3d, kMaxInstruments> entry_;
  std::vector<Points> posed_;
  Nanoseconds now_ns_ = 0;
  bool deep_ = false;
};

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
      PressedScene coarse_scene(coarse, instruments), fine_scene(fine, instruments);
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
