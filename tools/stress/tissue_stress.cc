#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "engine/baselines/surface_error.h"
#include "engine/organ.h"
#include "tools/shared/report_text.h"
#include "tools/stress/hollow_box.h"
#include "tools/stress/material_cases.h"
#include "tools/stress/stress_block_fixture.h"

namespace hpdm {
namespace {

constexpr int kMaxSubsteps = 1000;

SurfaceMesh SurfaceOf(const StressBlockFixture& block) {
  return BoxSurface(block.min, block.max, block.squares);
}

// Splits edges (a, b) near a, so that each of the two triangles of an edge loses a sliver of
// `ratio` of its area. Every triangle is split at most once. Old vertices keep their numbers.
SurfaceMesh WithSlivers(const SurfaceMesh& mesh, double ratio) {
  std::map<std::pair<int, int>, std::pair<int, int>> at;  // directed edge: triangle, corner
  const auto corner = [&mesh](int t, int k) { return mesh.triangles(t, k % 3); };
  const int count = static_cast<int>(mesh.triangles.rows());
  for (int t = 0; t < count; ++t) {
    for (int k = 0; k < 3; ++k) at[{corner(t, k), corner(t, k + 1)}] = {t, k};
  }
  std::vector<Vector3d> added;
  std::vector<std::array<int, 3>> triangles;
  std::vector<bool> used(static_cast<std::size_t>(count), false);
  const auto split = [&](int t, int k, int middle) {
    triangles.push_back({corner(t, k), middle, corner(t, k + 2)});
    triangles.push_back({middle, corner(t, k + 1), corner(t, k + 2)});
    used[static_cast<std::size_t>(t)] = true;
  };
  for (const auto& [edge, place] : at) {
    const auto [t, k] = place;
    const auto other = at.find({edge.second, edge.first});
    if (used[static_cast<std::size_t>(t)] || other == at.end()) continue;
    const auto [s, l] = other->second;
    if (used[static_cast<std::size_t>(s)]) continue;
    const Vector3d a = mesh.vertices.row(edge.first), b = mesh.vertices.row(edge.second);
    const int middle = static_cast<int>(mesh.vertices.rows() + static_cast<long>(added.size()));
    added.emplace_back(a + ratio * (b - a));
    split(t, k, middle);
    split(s, l, middle);
  }
  for (int t = 0; t < count; ++t) {
    if (!used[static_cast<std::size_t>(t)]) {
      triangles.push_back({corner(t, 0), corner(t, 1), corner(t, 2)});
    }
  }
  SurfaceMesh slivered;
  slivered.vertices.resize(mesh.vertices.rows() + static_cast<Eigen::Index>(added.size()), 3);
  slivered.vertices.topRows(mesh.vertices.rows()) = mesh.vertices;
  for (std::size_t v = 0; v < added.size(); ++v) {
    slivered.vertices.row(mesh.vertices.rows() + static_cast<Eigen::Index>(v)) =
        added[v].transpose();
  }
  slivered.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    slivered.triangles.row(static_cast<Eigen::Index>(t)) << triangles[t][0], triangles[t][1],
        triangles[t][2];
  }
  return slivered;
}

// Judges against quadratic tetrahedra of the same block; `at` makes the block for a value of the
// parameter.
StressCase AgainstQuadratic(StressCase stress_case, std::function<StressBlockFixture(double)> at,
                            const std::array<int, 3>& bricks, double degraded_from,
                            double failed_from) {
  const auto truth = std::make_shared<Remembered>(
      [at, bricks](double value) { return QuadraticRest(at(value), bricks).displacements; });
  stress_case.run = [=](StressModel model, double value) {
    const StressBlockFixture block = at(value);
    return JudgeAnswer(SurfaceOf(block), Rest(block, model), truth->At(value), model, degraded_from,
                       failed_from);
  };
  return stress_case;
}

}  // namespace

StressCase NearlyIncompressible(bool quick) {
  StressCase stress_case;
  stress_case.name = "nearly_incompressible";
  stress_case.title = "Block pressed, Poisson's ratio near 1/2";
  stress_case.truth =
      "quadratic tetrahedra, surface displacement; degraded from 15 %, failed from 40 %";
  stress_case.parameter = {"1/2 - nu", "", 0.2, 1e-4, 1e-4, true};
  stress_case.models = kAllModels;
  const auto at = [quick](double gap) {
    StressBlockFixture block = PressedBlock(quick);
    block.organ.lattice.cells = {6, 6, 4};
    block.organ.material.poisson = 0.5 - gap;
    block.organ.energy.alpha = block.organ.material.young / (2 * (1.5 - gap));
    return block;
  };
  return AgainstQuadratic(std::move(stress_case), at, PressedBlock(true).bricks, 0.15, 0.4);
}

StressCase StiffnessContrast(bool quick) {
  StressCase stress_case;
  stress_case.name = "stiffness_contrast";
  stress_case.title = "Block pressed over a hard tumour of 40 x 40 x 20 mm, 20 mm deep";
  stress_case.truth =
      "quadratic tetrahedra, surface displacement; degraded from 15 %, failed from 40 %. The "
      "bricks of the tetrahedra end at the tumour's faces, the lattice's cells of 18 mm do not";
  stress_case.parameter = {"stiffness contrast", "", 1, 1000, 1e4, true};
  stress_case.models = {StressModel::kStrainSmall, StressModel::kStrainFinite,
                        StressModel::kMetricSmall, StressModel::kMetricFinite,
                        StressModel::kLinearTetrahedra};
  const auto at = [quick](double contrast) {
    StressBlockFixture block = PressedBlock(quick);
    block.organ.lattice.cells = {6, 6, 4};
    block.organ.regions = {{Box{Vector3d(0.03, 0.03, 0.02), Vector3d(0.07, 0.07, 0.04)},
                            contrast * block.organ.material.young}};
    return block;
  };
  return AgainstQuadratic(std::move(stress_case), at, PressedBlock(true).bricks, 0.15, 0.4);
}

StressCase ThinWall(bool quick) {
  StressCase stress_case;
  stress_case.name = "thin_wall";
  const int cells = quick ? 4 : 6;
  stress_case.title =
      Format("Hollow organ of 80 mm pressed, lattice cells of %.3g mm", 90. / cells);
  stress_case.truth =
      "quadratic tetrahedra, surface displacement; degraded from 15 %, failed from 30 %";
  stress_case.parameter = {"wall", "mm", 30, 3, 1, true};
  stress_case.models = kAllModels;
  const auto at = [cells](double wall_mm) { return HollowBox(0.08, 1e-3 * wall_mm, cells); };
  const auto truth = std::make_shared<Remembered>(
      [at](double wall_mm) { return TetraRest(at(wall_mm), true).displacements; });
  stress_case.run = [at, truth](StressModel model, double wall_mm) {
    const HollowBody body = at(wall_mm);
    const StressAnswer answer = model == StressModel::kLinearTetrahedra
                                    ? TetraRest(body, false)
                                    : Rest(body.organ, body.rest, body.loads, model);
    return JudgeAnswer(body.rest, answer, truth->At(wall_mm), model, 0.15, 0.3);
  };
  return stress_case;
}

StressCase Slivers(bool /*quick*/) {
  StressCase stress_case;
  stress_case.name = "slivers";
  stress_case.title = "Block pressed, slivers along every other edge of its surface";
  stress_case.truth =
      "the same model without slivers, surface displacement; degraded from 1 %, failed from 10 % "
      "or with more than 1,000 explicit substeps in a step of 33 ms";
  stress_case.parameter = {"area of a sliver over a triangle's", "", 0.5, 1e-6, 1e-12, true};
  stress_case.models = {StressModel::kStrainSmall, StressModel::kStrainFinite,
                        StressModel::kMetricSmall, StressModel::kMetricFinite,
                        StressModel::kContinuum,   StressModel::kMassSpring};
  StressBlockFixture block = PressedBlock(true);
  block.squares = {6, 6, 4};
  const SurfaceMesh clean = SurfaceOf(block);
  std::map<StressModel, Points> without;
  stress_case.run = [=](StressModel model, double ratio) mutable {
    if (!without.contains(model)) {
      without[model] = Rest(block.organ, clean, block.loads, model).displacements;
    }
    const SurfaceMesh slivered = WithSlivers(clean, ratio);
    StressAnswer answer = Rest(block.organ, slivered, block.loads, model);
    const Points kept = answer.displacements.topRows(clean.vertices.rows());
    answer.displacements = kept;
    StressTrial trial = JudgeAnswer(clean, answer, without[model], model, 0.01, 0.1);
    if (model == StressModel::kMassSpring) {
      OrganOptions springs = block.organ;
      Choose(model, &springs);
      const int substeps = OrganModel(springs, slivered).springs()->substeps();
      trial.how = Format("%d substeps a step", substeps);
      if (substeps > kMaxSubsteps) trial.fate = StressFate::kFailed;
    }
    return trial;
  };
  return stress_case;
}

StressCase NothingHolds(bool quick) {
  StressCase stress_case;
  stress_case.name = "no_support";
  stress_case.title = "Free block, pulled at its top";
  stress_case.truth =
      "the mean displacement from the weak spring to rest, force / (1e-3 E / L^2 x "
      "volume); degraded from 5 %, failed from 50 %";
  stress_case.parameter = {"force", "N", 0.001, 0.1, 10, true};
  stress_case.models = kAllModels;
  stress_case.run = [quick](StressModel model, double force) {
    StressBlockFixture block = PressedBlock(quick);
    block.organ.supports.clear();
    block.loads[0].force_W = Vector3d(0, 0, force);
    const SurfaceMesh rest = SurfaceOf(block);
    const StressAnswer answer = Rest(block, model);
    // Volume of the lattice's box and of the tissue in it.
    const Vector3d size = block.max - block.min;
    const double length = size.mean() + 2 * block.organ.lattice.margin;
    const bool metric = model == StressModel::kMetricSmall || model == StressModel::kMetricFinite;
    double modulus = metric ? block.organ.energy.alpha : block.organ.material.young;
    if (model == StressModel::kMetricFinite) modulus /= 4;
    const double moved = force * length * length / (1e-3 * modulus * size.prod());
    Points truth = Points::Zero(rest.vertices.rows(), 3);
    truth.col(2).setConstant(moved);
    StressTrial trial = JudgeAnswer(rest, answer, truth, model, 0.05, 0.5);
    if (model == StressModel::kMassSpring) trial.how = "its springs to rest hold it";
    if (model == StressModel::kLinearTetrahedra) trial.how = "drifts away";
    return trial;
  };
  return stress_case;
}

}  // namespace hpdm
