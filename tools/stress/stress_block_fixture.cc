#include "tools/stress/stress_block_fixture.h"

#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "engine/baselines/surface_error.h"
#include "engine/organ.h"
#include "engine/reference_fem/tetra_fem.h"
#include "engine/statics/static_loads.h"
#include "engine/tissue/stiffness_regions.h"
#include "engine/tissue/support.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

TetraBody MakeBody(const StressBlockFixture& block, const SurfaceMesh& rest, TetraMesh mesh) {
  const Box bounds = AxisAlignedBounds(rest.vertices);
  Eigen::VectorXd stiffness(mesh.elements.rows());
  for (Eigen::Index e = 0; e < stiffness.size(); ++e) {
    Vector3d centre = Vector3d::Zero();
    for (int k = 0; k < 4; ++k) centre += mesh.nodes.row(mesh.elements(e, k)).transpose() / 4;
    stiffness[e] = YoungAt(block.organ, bounds, centre) / block.organ.material.young;
  }
  return {std::move(mesh), block.organ.material, TetraLaw::kSmallStrain, stiffness};
}

StressAnswer TetraRest(const StressBlockFixture& block, TetraMesh mesh) {
  const SurfaceMesh rest = BoxSurface(block.min, block.max, block.squares);
  const TetraBody body = MakeBody(block, rest, std::move(mesh));
  const TetraSolution solution =
      SolveTetra(body, MakeTetraProblem(body, rest, block.organ.supports, block.loads));
  StressAnswer answer;
  answer.displacements = ApplyRows(PointRows(body.mesh(), rest.vertices), solution.u);
  answer.compliance = solution.Compliance();
  answer.residual = solution.residual;
  return answer;
}

}  // namespace

SurfaceMesh BoxSurface(const Vector3d& min, const Vector3d& max,
                       const std::array<int, 3>& squares) {
  std::vector<Vector3d> vertices;
  std::vector<std::array<int, 3>> triangles;
  std::map<std::tuple<int, int, int>, int> numbers;
  const auto vertex = [&](const std::array<int, 3>& at) {
    const auto [it, added] = numbers.try_emplace({at[0], at[1], at[2]}, vertices.size());
    if (added) {
      Vector3d share;
      for (int d = 0; d < 3; ++d) share[d] = static_cast<double>(at[d]) / squares[d];
      vertices.emplace_back(min + share.cwiseProduct(max - min));
    }
    return it->second;
  };
  for (int d = 0; d < 3; ++d) {
    const int e = (d + 1) % 3, f = (d + 2) % 3;
    for (const int side : {0, squares[d]}) {
      for (int i = 0; i < squares[e]; ++i) {
        for (int j = 0; j < squares[f]; ++j) {
          std::array<std::array<int, 3>, 4> corner;
          for (int k = 0; k < 4; ++k) {
            corner[k][d] = side;
            corner[k][e] = i + (k == 1 || k == 2 ? 1 : 0);
            corner[k][f] = j + (k >= 2 ? 1 : 0);
          }
          std::array<int, 4> v;
          for (int k = 0; k < 4; ++k) v[k] = vertex(corner[k]);
          if (side == 0) std::swap(v[1], v[3]);
          triangles.push_back({v[0], v[1], v[2]});
          triangles.push_back({v[0], v[2], v[3]});
        }
      }
    }
  }
  SurfaceMesh mesh;
  mesh.vertices.resize(static_cast<Eigen::Index>(vertices.size()), 3);
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    mesh.vertices.row(static_cast<Eigen::Index>(v)) = vertices[v].transpose();
  }
  mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    mesh.triangles.row(static_cast<Eigen::Index>(t)) << triangles[t][0], triangles[t][1],
        triangles[t][2];
  }
  return mesh;
}

StressBlockFixture PressedBlock(bool quick) {
  StressBlockFixture block;
  block.max = Vector3d(0.1, 0.1, 0.06);
  block.squares = {20, 20, 12};
  block.bricks = quick ? std::array<int, 3>{10, 10, 6} : std::array<int, 3>{20, 20, 12};
  block.organ.name = "block";
  block.organ.lattice.cells = quick ? std::array<int, 3>{4, 4, 3} : std::array<int, 3>{6, 6, 4};
  block.organ.lattice.margin = 0.005;
  const MaterialOptions& material = block.organ.material;
  block.organ.energy.alpha = material.young / (2 * (1 + material.poisson));
  block.organ.energy.beta = 0;
  block.organ.supports = {{BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.2)}, {}}};
  LoadOptions press;
  press.organ = block.organ.name;
  press.p_centre_W = Vector3d(0.05, 0.05, 0.06);
  press.radius = 0.03;
  press.force_W = Vector3d(0, 0, -0.05);
  block.loads = {press};
  return block;
}

StressBlockFixture Cantilever(double length, double thickness) {
  StressBlockFixture beam;
  const double half = thickness / 2;
  beam.min = Vector3d(-2 * thickness, -half, -half);
  beam.max = Vector3d(length, half, half);
  beam.squares = {48, 2, 2};
  beam.bricks = {60, 7, 7};
  beam.organ.name = "cantilever";
  beam.organ.material.poisson = 0;
  beam.organ.energy.alpha = beam.organ.material.young / 2;
  beam.organ.energy.beta = 0;
  beam.organ.lattice.cells = {12, 2, 2};
  beam.organ.lattice.margin = thickness / 4;
  SupportOptions held;
  held.region =
      Box{Vector3d(-3 * thickness, -thickness, -thickness), Vector3d(0, thickness, thickness)};
  held.stiffness = {};
  beam.organ.supports = {held};
  LoadOptions load;
  load.organ = beam.organ.name;
  load.p_centre_W = Vector3d(length, 0, 0);
  load.radius = half;
  const double inertia = std::pow(thickness, 4) / 12;
  load.force_W =
      Vector3d(0, 0, 0.01 * length * 3 * beam.organ.material.young * inertia / std::pow(length, 3));
  beam.loads = {load};
  return beam;
}

StressAnswer Rest(const OrganOptions& organ, const SurfaceMesh& rest,
                  const std::vector<LoadOptions>& loads, StressModel model) {
  OrganOptions options = organ;
  Choose(model, &options);
  // Eq. 15's eta is a quarter of the shear modulus.
  if (model == StressModel::kMetricFinite) options.energy.alpha /= 4;
  const OrganModel built(options, rest);
  const StaticLoads statics(built, loads);
  const StaticSolution solution = statics.Solve();
  StressAnswer answer;
  answer.displacements = solution.vertex_displacements;
  answer.compliance = solution.Compliance();
  answer.share = solution.share;
  answer.residual = statics.Residual(solution);
  return answer;
}

StressAnswer Rest(const StressBlockFixture& block, StressModel model) {
  if (model == StressModel::kLinearTetrahedra) {
    return TetraRest(block, BoxTetraMesh(block.min, block.max, block.bricks));
  }
  return Rest(block.organ, BoxSurface(block.min, block.max, block.squares), block.loads, model);
}

StressAnswer QuadraticRest(const StressBlockFixture& block, const std::array<int, 3>& bricks) {
  return TetraRest(block, Quadratic(BoxTetraMesh(block.min, block.max, bricks)));
}

StressTrial JudgeAnswer(const SurfaceMesh& rest, const StressAnswer& answer, const Points& truth,
                        StressModel model, double degraded_from, double failed_from) {
  if (!answer.displacements.allFinite()) {
    StressTrial trial = Judge(std::nan(""), degraded_from, failed_from);
    trial.error.reset();
    trial.how = "not finite";
    if (IsOurs(model)) trial.harm = trial.how;
    return trial;
  }
  StressTrial trial =
      Judge(RelativeSurfaceError(rest, answer.displacements, truth), degraded_from, failed_from);
  if (answer.share < 1) {
    trial.fate = StressFate::kFailed;
    trial.how = Format("carries %.2g of the load", answer.share);
  }
  return trial;
}

const Points& Remembered::At(double value) {
  const auto found = known_.find(value);
  return found != known_.end() ? found->second
                               : known_.emplace(value, compute_(value)).first->second;
}

}  // namespace hpdm
