#include "engine/static_loads.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

#include "engine/static_newton.h"
#include "engine/surface_kernel.h"

namespace hpdm {
namespace {

using UnknownMap = Eigen::Map<Eigen::VectorXd>;

// K U for either form of the stiffness; U is n x 3.
Points ElasticForce(const LatticeStiffness& stiffness, const Points& U) {
  Points force = Points::Zero(U.rows(), 3);
  if (const auto* scalar = std::get_if<ScalarStiffness>(&stiffness)) {
    force = *scalar * U;
  } else {
    UnknownMap(force.data(), force.size()) =
        std::get<FullStiffness>(stiffness) * Eigen::Map<const Eigen::VectorXd>(U.data(), U.size());
  }
  return force;
}

}  // namespace

double StaticSolution::Compliance() const {
  if (load_forces.empty() || load_forces[0].norm() == 0) return 0;
  return load_displacements[0].dot(load_forces[0]) / load_forces[0].squaredNorm();
}

StaticLoads::StaticLoads(const OrganModel& model, const std::vector<LoadOptions>& loads)
    : model_(model),
      loads_(loads),
      response_(
          model.finite_energy() == nullptr
              ? std::visit([](const auto& K) { return MakeLatticeResponse(K); }, model.stiffness())
              : nullptr),
      rows_(Eigen::MatrixXd::Zero(3 * model.lattice().size(),
                                  3 * static_cast<Eigen::Index>(loads.size()))) {
  Eigen::RowVectorXd row(model.lattice().size());
  for (std::size_t i = 0; i < loads.size(); ++i) {
    for (const SurfaceSample& sample :
         SurfaceKernel(model.rest(), loads[i].p_centre_W, loads[i].radius)) {
      model.LatticeRow({sample.triangle, sample.barycentric}, row);
      for (Eigen::Index a = 0; a < row.size(); ++a) {
        for (int d = 0; d < 3; ++d) {
          rows_(3 * a + d, 3 * static_cast<Eigen::Index>(i) + d) += sample.weight * row[a];
        }
      }
    }
  }
}

StaticSolution StaticLoads::SolveFinite() const {
  const std::size_t m = loads_.size();
  const Eigen::Index equations = rows_.cols();
  StaticLoadRows rows{rows_, Eigen::VectorXd::Zero(equations), Eigen::VectorXd::Zero(equations),
                      std::vector<bool>(3 * m, false)};
  for (std::size_t i = 0; i < m; ++i) {
    const auto at = static_cast<Eigen::Index>(3 * i);
    if (loads_[i].force_W.has_value()) rows.forces.segment<3>(at) = *loads_[i].force_W;
    if (!loads_[i].displacement_W.has_value()) continue;
    rows.moves.segment<3>(at) = *loads_[i].displacement_W;
    std::fill_n(rows.held.begin() + at, 3, true);
  }
  const std::unique_ptr<ElasticEnergy> energy = model_.finite_energy()->Clone();
  StaticNewtonSolution found = SolveStaticLoads(rows, energy.get());

  StaticSolution solution;
  solution.control_displacements = std::move(found.U);
  solution.vertex_displacements = model_.weights() * solution.control_displacements;
  solution.residual = found.residual;
  solution.share = found.share;
  solution.iterations = found.iterations;
  solution.collapsed = energy->CollapsedShare(solution.control_displacements);
  const Eigen::VectorXd moved =
      rows_.transpose() * UnknownMap(solution.control_displacements.data(), rows_.rows());
  for (std::size_t i = 0; i < m; ++i) {
    const auto at = static_cast<Eigen::Index>(3 * i);
    solution.load_forces.emplace_back(found.forces.segment<3>(at));
    solution.load_displacements.emplace_back(moved.segment<3>(at));
  }
  return solution;
}

StaticSolution StaticLoads::Solve() const {
  if (response_ == nullptr) return SolveFinite();
  const Eigen::Index m = static_cast<Eigen::Index>(loads_.size());
  Eigen::MatrixXd columns = rows_;
  response_->Solve(columns);
  const Eigen::MatrixXd compliance = rows_.transpose() * columns;  // 3m x 3m

  // Given forces first, then those that make the prescribed displacements.
  Eigen::VectorXd force = Eigen::VectorXd::Zero(3 * m);
  Eigen::VectorXd wanted = Eigen::VectorXd::Zero(3 * m);
  std::vector<Eigen::Index> held;
  for (Eigen::Index i = 0; i < m; ++i) {
    const LoadOptions& load = loads_[static_cast<std::size_t>(i)];
    if (load.force_W.has_value()) force.segment<3>(3 * i) = *load.force_W;
    if (!load.displacement_W.has_value()) continue;
    wanted.segment<3>(3 * i) = *load.displacement_W;
    for (int d = 0; d < 3; ++d) held.push_back(3 * i + d);
  }
  if (!held.empty()) {
    const Eigen::VectorXd missing = wanted(held) - Eigen::VectorXd(compliance * force)(held);
    const Eigen::MatrixXd coupling = compliance(held, held);
    const Eigen::VectorXd found = coupling.ldlt().solve(missing);
    force(held) = found;
  }

  StaticSolution solution;
  solution.control_displacements.resize(model_.lattice().size(), 3);
  UnknownMap U(solution.control_displacements.data(), rows_.rows());
  U = columns * force;
  solution.vertex_displacements = model_.weights() * solution.control_displacements;
  const Eigen::VectorXd moved = compliance * force;
  for (Eigen::Index i = 0; i < m; ++i) {
    solution.load_forces.emplace_back(force.segment<3>(3 * i));
    solution.load_displacements.emplace_back(moved.segment<3>(3 * i));
  }
  const Points elastic = ElasticForce(model_.stiffness(), solution.control_displacements);
  const Eigen::VectorXd applied = rows_ * force;
  const double size = applied.norm();
  if (size > 0) {
    solution.residual =
        (Eigen::Map<const Eigen::VectorXd>(elastic.data(), elastic.size()) - applied).norm() / size;
  }
  return solution;
}

}  // namespace hpdm
