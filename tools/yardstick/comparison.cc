// hpdm_comparison SCENE... --out FOLDER: the engine's step beside those of tetrahedral solvers, on one
// core in one run, with the error of each against the case's reference.

#include <malloc.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>

#include "engine/base/error.h"
#include "engine/baselines/surface_error.h"
#include "engine/reference_fem/tetra_stepper.h"
#include "scenes/generator/meshing/obj_writer.h"
#include "tools/chart/fine_relocation.h"
#include "tools/chart/static_case_model.h"
#include "tools/shared/json_text.h"
#include "tools/shared/machine_facts.h"
#include "tools/shared/report_text.h"
#include "tools/shared/staged_file.h"
#include "tools/yardstick/case_mesh.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

/// One model on one case. The step includes the relocation of a surface of 30,000 triangles.
struct Row {
  std::string model;
  long unknowns = 0;  ///< Functions or nodes.
  double error = 0;   ///< Area-weighted relative L2 of the surface against the reference.
  Timing step;
  int rounds = 0;
  double way_ms = 0,
         longest_ms = 0;  ///< Steps of the way from rest, without relocation; mean, most.
  double setup_ms = 0;
  double memory_MB = 0;
  bool engine = false;
  bool converged = true;
};

struct ComparedCase {
  StaticCase load_case;
  CaseReference reference;
  Points fine_vertices;
  bool finite = false;
};

// Steps of the way from rest to the loads, in finite strain: 2 mm each in a lift by 40 mm.
constexpr int kWaySteps = 20;

double MemoryMB() {
  const struct mallinfo2 info = mallinfo2();
  return 1e-6 * static_cast<double>(info.uordblks + info.hblkhd);
}

// Measurements of one model: a slow step is repeated three times.
Timing TimeSteps(const std::function<void()>& step) {
  return Time(step, {.least = 3, .most = 100, .budget_ms = 300});
}

struct ComparedLattice {
  int cells = 0;  ///< Along each axis.
  int local = 0;
  int adaptive = 0;  ///< Functions with those of two finer levels, without a margin; 0: none.
};

Row MeasureEngine(const ComparedCase& c, const ComparedLattice& lattice) {
  OrganOptions options = c.load_case.organ;
  options.lattice.cells = {lattice.cells, lattice.cells, lattice.cells};
  options.lattice.local = {.functions = lattice.local, .refinement = 2};
  if (lattice.adaptive > 0) {
    options.lattice.adaptive = {lattice.adaptive, 2};
    options.lattice.margin = 0;
  }
  const double before = MemoryMB();
  StaticCaseModel model(c.load_case, options);
  Row row;
  row.engine = true;
  row.memory_MB = MemoryMB() - before;
  row.setup_ms = model.setup_ms();
  if (c.finite) {
    const StaticCaseModel::WayTimes way = model.TimeWay(kWaySteps);
    row.way_ms = way.mean_ms;
    row.longest_ms = way.most_ms;
  }
  row.converged = model.Balance();
  const StaticCaseModel::StepTimes times = model.TimeSteps();
  row.converged = row.converged && times.last.converged;
  row.rounds = times.last.iterations;
  row.unknowns = model.unknowns() + model.local_functions();
  row.model = Format("HPDM, %d^3 + %d", lattice.cells,
                     lattice.adaptive > 0 ? lattice.adaptive : model.local_functions());
  if (lattice.adaptive > 0) row.model += " adaptive in all";
  row.error = RelativeSurfaceError(c.load_case.rest, model.VertexDisplacements(),
                                   c.reference.displacements);
  row.step = Sum(times.response, TimeFineRelocation(model, c.fine_vertices, times.indentations,
                                                    c.load_case.rest.vertices.rows()));
  return row;
}

// The weights of surface points on the nodes, as the lattice has them on its control points.
WeightMatrix WeightsOf(const std::vector<TetraRow>& rows, Eigen::Index nodes) {
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (const auto& [node, weight] : rows[r]) {
      entries.emplace_back(static_cast<int>(r), node, weight);
    }
  }
  WeightMatrix weights(static_cast<Eigen::Index>(rows.size()), nodes);
  weights.setFromTriplets(entries.begin(), entries.end());
  return weights;
}

/// A body of tetrahedra in one case, with what its solvers share.
class TetraCase {
 public:
  TetraCase(const ComparedCase& c, TetraMesh mesh, std::string name)
      : c_(c),
        name_(std::move(name)),
        body_(std::move(mesh), c.load_case.organ.material,
              c.finite ? TetraLaw::kNeoHookean : TetraLaw::kSmallStrain),
        problem_(MakeTetraProblem(body_, c.load_case.rest, c.load_case.organ.supports,
                                  c.load_case.scene.loads)),
        rows_(PointRows(body_.mesh(), c.load_case.rest.vertices)) {
    for (const TetraLoad& load : problem_.loads) patches_.push_back(load.patch);
    relocation_ = TimeRelocation(c.fine_vertices,
                                 WeightsOf(PointRows(body_.mesh(), c.fine_vertices), nodes()));
  }

  const TetraBody& body() const { return body_; }

  /// Steps `stepped` between 0.95 of the loads' displacements and all of them.
  Row Measure(const SteppedBody& stepped, StepMethod method, const std::string& solver,
              int most_rounds = 200) const {
    Row row = Named(solver);
    const double before = MemoryMB();
    const TimingClock::time_point start = TimingClock::now();
    TetraStepper stepper(stepped, problem_.springs, method, most_rounds);
    row.setup_ms = MillisecondsSince(start);
    row.memory_MB = MemoryMB() - before;
    const Points full = Displacements(stepper);
    const int steps = c_.finite ? kWaySteps : 1;
    for (int step = 1; step <= steps; ++step) {
      const double began = ThreadMilliseconds();
      row.converged = stepper.MoveTo(patches_, static_cast<double>(step) / steps * full).converged;
      if (!c_.finite) continue;
      const double ms = ThreadMilliseconds() - began;
      row.way_ms += ms / steps;
      row.longest_ms = std::max(row.longest_ms, ms);
    }
    row.error = ErrorOf(stepper.u());
    bool all = false;
    TetraStepper::Result last;
    row.step = Sum(TimeSteps([&] {
                     last = stepper.MoveTo(patches_, (all ? 1.0 : 0.95) * full);
                     all = !all;
                   }),
                   relocation_);
    row.rounds = last.rounds;
    row.converged = (row.converged && last.converged) || most_rounds == 1;
    return row;
  }

  /// The surface's inverse stiffness, computed once (Bro-Nielsen, Cotin 1996). Only the columns that
  /// this case's steps read are computed and timed. The whole matrix's time and memory follow from
  /// them.
  Row MeasureCondensed() const {
    Row row = Named("condensed to the surface");
    const TimingClock::time_point start = TimingClock::now();
    const TetraStepper stepper(Stepped(body_), problem_.springs, StepMethod::kQuasiNewton);
    const double factor_ms = MillisecondsSince(start);
    std::vector<int> surface = SurfaceNodes();
    const auto size = static_cast<Eigen::Index>(3 * surface.size());
    std::vector<int> read;
    for (const TetraRow& patch : patches_) {
      for (const auto& [node, weight] : patch) read.push_back(node);
    }
    Eigen::MatrixXd columns(size, static_cast<Eigen::Index>(3 * read.size()));
    const TimingClock::time_point solving = TimingClock::now();
    for (Eigen::Index j = 0; j < columns.cols(); ++j) {
      Points unit = Points::Zero(nodes(), 3);
      unit(read[static_cast<std::size_t>(j / 3)], j % 3) = 1;
      const Points u = stepper.SolveAtRest(unit);
      for (std::size_t s = 0; s < surface.size(); ++s) {
        columns.block<3, 1>(static_cast<Eigen::Index>(3 * s), j) = u.row(surface[s]).transpose();
      }
    }
    const double solve_ms = MillisecondsSince(solving) / static_cast<double>(columns.cols());
    row.setup_ms = factor_ms + solve_ms * static_cast<double>(size);
    row.memory_MB = 8e-6 * static_cast<double>(size) * static_cast<double>(size);
    TetraStepper whole(Stepped(body_), problem_.springs, StepMethod::kQuasiNewton);
    whole.MoveTo(patches_, Displacements(whole));
    row.error = ErrorOf(whole.u());
    // A step multiplies the columns of the patches' nodes by their forces.
    Eigen::VectorXd forces = Eigen::VectorXd::Random(columns.cols()), moved(size);
    row.step = Sum(TimeSteps([&] { moved.noalias() = columns * forces; }), relocation_);
    row.rounds = 1;
    return row;
  }

 private:
  Eigen::Index nodes() const { return body_.mesh().nodes.rows(); }
  Row Named(const std::string& solver) const {
    Row row;
    row.model = name_ + ", " + solver;
    row.unknowns = nodes();
    return row;
  }
  double ErrorOf(const Points& u) const {
    return RelativeSurfaceError(c_.load_case.rest, ApplyRows(rows_, u), c_.reference.displacements);
  }
  // The displacements at which the patches have the loads' forces. Small strain, or given.
  Points Displacements(const TetraStepper& stepper) const {
    Points displacements = Points::Zero(static_cast<Eigen::Index>(patches_.size()), 3);
    Points forces = Points::Zero(nodes(), 3);
    for (std::size_t l = 0; l < patches_.size(); ++l) {
      const TetraLoad& load = problem_.loads[l];
      if (load.displacement) {
        displacements.row(static_cast<Eigen::Index>(l)) = load.displacement->transpose();
        continue;
      }
      for (const auto& [node, weight] : load.patch) {
        forces.row(node) += weight * load.force->transpose();
      }
    }
    if (forces.isZero(0)) return displacements;
    if (c_.finite || !displacements.isZero(0)) {
      throw InputError(CaseName(c_.load_case) +
                       ": forces in finite strain, or beside displacements, are not compared; "
                       "give displacements");
    }
    return ApplyRows(patches_, stepper.SolveAtRest(forces));
  }
  // Nodes of faces that belong to one element only. Linear elements.
  std::vector<int> SurfaceNodes() const {
    std::map<std::array<int, 3>, int> faces;
    const Tetrahedra& elements = body_.mesh().elements;
    for (Eigen::Index e = 0; e < elements.rows(); ++e) {
      for (int out = 0; out < 4; ++out) {
        std::array<int, 3> face{};
        for (int k = 0, i = 0; k < 4; ++k) {
          if (k != out) face[static_cast<std::size_t>(i++)] = elements(e, k);
        }
        std::sort(face.begin(), face.end());
        ++faces[face];
      }
    }
    std::vector<int> nodes;
    for (const auto& [face, count] : faces) {
      if (count == 1) nodes.insert(nodes.end(), face.begin(), face.end());
    }
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    return nodes;
  }

  const ComparedCase& c_;
  std::string name_;
  TetraBody body_;
  TetraProblem problem_;
  std::vector<TetraRow> rows_;
  std::vector<TetraRow> patches_;
  Timing relocation_;
};

Json ToJson(const std::string& load_case, const Row& row) {
  return {{"case", load_case},
          {"model", row.model},
          {"unknowns", row.unknowns},
          {"error", row.error},
          {"step_us", row.step.median_us},
          {"step_min_us", row.step.minimum_us},
          {"rounds", row.rounds},
          {"way_ms", row.way_ms},
          {"longest_ms", row.longest_ms},
          {"setup_ms", row.setup_ms},
          {"memory_MB", row.memory_MB},
          {"converged", row.converged}};
}

std::string Markdown(const ComparedCase& c, const std::vector<Row>& rows) {
  std::string text;
  for (const Row& row : rows) {
    const std::string way = c.finite
                                ? Duration(1e3 * row.way_ms) + ", " + Duration(1e3 * row.longest_ms)
                                : std::string("-");
    text += Format("| `%s` | %s | %s | %s%.1f %% | %s | %s | %d | %s | %s MB |\n",
                   CaseName(c.load_case).c_str(), row.model.c_str(),
                   WithCommas(row.unknowns).c_str(), row.converged ? "" : "not converged, ",
                   100 * row.error, way.c_str(), Duration(row.step.median_us).c_str(), row.rounds,
                   Duration(1e3 * row.setup_ms).c_str(), Format("%.3g", row.memory_MB).c_str());
  }
  return text;
}

double StepUs(const ComparedCase& c, const Row& row) {
  return c.finite ? 1e3 * row.way_ms : row.step.median_us;
}

// For each of the engine's models: how much longer the fastest tetrahedra take that err no more.
std::string Ratios(const ComparedCase& c, const std::vector<Row>& rows) {
  std::string text;
  for (const Row& engine : rows) {
    if (!engine.engine || !engine.converged) continue;
    const Row* last = nullptr;
    for (const char* kind : {"corotational", "condensed", ""}) {
      const Row* best = nullptr;
      for (const Row& row : rows) {
        const bool is_kind =
            row.model.find(*kind != '\0' ? kind : "tetrahedra") != std::string::npos;
        const bool other = *kind == '\0' && row.model.find("condensed") != std::string::npos;
        if (row.engine || !is_kind || other || !row.converged || row.error > engine.error) continue;
        if (best == nullptr || StepUs(c, row) < StepUs(c, *best)) best = &row;
      }
      if (best == nullptr || best == last) continue;
      last = best;
      text += Format("- `%s`, %s (%.1f %%): %s takes %.3g times as long for %.1f %%.\n",
                     CaseName(c.load_case).c_str(), engine.model.c_str(), 100 * engine.error,
                     best->model.c_str(), StepUs(c, *best) / StepUs(c, engine), 100 * best->error);
    }
  }
  return text;
}

// Nodes up to which tangents are factorised: with 4,000 a factor takes half a second.
constexpr int kMostFactored = 1500;

std::vector<Row> Compare(const ComparedCase& c, const std::vector<int>& nodes, bool quick) {
  std::vector<Row> rows;
  const auto add = [&](Row row) {
    std::fprintf(stderr, "%s: %s: %ld unknowns, %.2f %%, %s, %d rounds, set-up %s, %.3g MB%s\n",
                 CaseName(c.load_case).c_str(), row.model.c_str(), row.unknowns, 100 * row.error,
                 Duration(row.step.median_us).c_str(), row.rounds,
                 Duration(1e3 * row.setup_ms).c_str(), row.memory_MB,
                 row.converged ? "" : ", not converged");
    rows.push_back(std::move(row));
  };
  const std::vector<ComparedLattice> lattices =
      c.finite ? std::vector<ComparedLattice>{{4}, {4, 22}, {4, 0, 240}, {5, 0, 300}, {8}}
               : std::vector<ComparedLattice>{{4, 18}, {6, 64}, {8, 64}, {10, 64}};
  for (const ComparedLattice& lattice : lattices) {
    if (!quick || lattice.cells < 8) add(MeasureEngine(c, lattice));
  }
  struct Kind {
    const char* name;
    Grading grading;
    bool quadratic;
  };
  for (const Kind& kind : {Kind{"linear tetrahedra of one size", Grading::kEven, false},
                           Kind{"linear tetrahedra, graded", Grading::kLoads, false},
                           Kind{"quadratic tetrahedra, graded", Grading::kLoads, true}}) {
    for (const int wanted : nodes) {
      // A quadratic mesh has about seven nodes a corner.
      const TetraMesh linear =
          MeshOf(c.load_case, kind.quadratic ? wanted / 7 : wanted, kind.grading, 0.03);
      const TetraMesh mesh = kind.quadratic ? Quadratic(linear) : linear;
      const TetraCase tetra(c, mesh, kind.name);
      if (!c.finite) {
        add(tetra.Measure(Stepped(tetra.body()), StepMethod::kQuasiNewton, "one factor"));
        if (!kind.quadratic) add(tetra.MeasureCondensed());
        continue;
      }
      add(tetra.Measure(Stepped(tetra.body()), StepMethod::kQuasiNewton,
                        "Neo-Hookean, one factor and L-BFGS"));
      add(tetra.Measure(Stepped(tetra.body()), StepMethod::kConjugateGradients,
                        "Neo-Hookean, conjugate gradients"));
      if (kind.quadratic) continue;
      const CorotationalBody rotated(mesh, c.load_case.organ.material);
      if (wanted <= kMostFactored) {
        add(tetra.Measure(Stepped(rotated), StepMethod::kNewton, "corotational, a factor a round"));
      }
      add(tetra.Measure(Stepped(rotated), StepMethod::kConjugateGradients,
                        "corotational, conjugate gradients"));
      add(tetra.Measure(Stepped(rotated), StepMethod::kConjugateGradients,
                        "corotational, conjugate gradients, one round", 1));
    }
  }
  return rows;
}

void Run(const std::vector<std::string>& scenes, const std::string& references,
         const std::string& out, const std::vector<int>& nodes, bool quick) {
  std::vector<ComparedCase> cases;
  for (const std::string& scene : scenes) {
    ComparedCase c;
    c.load_case = LoadStaticCase(scene);
    c.reference = LoadCaseReference(c.load_case, references);
    c.fine_vertices = FineVertices(c.load_case.rest);
    c.finite = c.load_case.organ.energy.strain == StrainMeasure::kFinite;
    cases.push_back(std::move(c));
  }
  MakeOutFolder(out);
  const MachineFacts machine = ThisMachine();
  std::string table =
      "| case | model | unknowns | error | step on the way: mean, longest | step to and fro | "
      "rounds | set-up | memory |\n"
      "|---|---|---|---|---|---|---|---|---|\n";
  std::string ratios;
  Json report = {{"machine", ToJson(machine)}, {"rows", Json::array()}};
  for (const ComparedCase& c : cases) {
    const std::vector<Row> rows = Compare(c, nodes, quick);
    table += Markdown(c, rows);
    ratios += Ratios(c, rows);
    for (const Row& row : rows) report["rows"].push_back(ToJson(CaseName(c.load_case), row));
    const std::filesystem::path folder(out);  // after each case: the next takes minutes
    WriteTextFile(folder / "comparison.md",
                  table + "\n" + ratios + "\nMedians; " + ToText(machine) + ".\n");
    WriteTextFile(folder / "comparison.json", JsonText(report) + "\n");
  }
  std::cout << table << "\n" << ratios << out << ": comparison.md, comparison.json\n";
}

}  // namespace
}  // namespace hpdm

int main(int argc, char** argv) {
  CLI::App app("Compares the engine's step with those of tetrahedral solvers");
  std::vector<std::string> scenes;
  std::string references = "tests/reference", out;
  std::vector<int> nodes = {1000, 2000, 4000, 8000};
  bool quick = false;
  app.add_option("scenes", scenes, "Cases (TOML)")->required();
  app.add_option("--references", references, "Folder of CASE.csv and CASE.json");
  app.add_option("--out", out, "Folder of comparison.md and comparison.json")->required();
  app.add_option("--nodes", nodes, "Nodes of the tetrahedral meshes")->delimiter(',');
  app.add_flag("--quick", quick, "Leave out lattices of eight cells and more");
  CLI11_PARSE(app, argc, argv);
  try {
    hpdm::Run(scenes, references, out, nodes, quick);
  } catch (const hpdm::InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
  return 0;
}
