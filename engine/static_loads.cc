#include "engine/static_loads.h"

#include <Eigen/Cholesky>

#include "engine/error.h"
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
          std::visit([](const auto& K) { return MakeLatticeResponse(K); }, model.stiffness())),
      rows_(Eigen::MatrixXd::Zero(3 * model.lattice().size(),
                                  3 * static_cast<Eigen::Index>(loads.size()))) {
  if (model.options().energy.type == EnergyType::kStrain &&
      model.options().energy.strain == StrainMeasure::kFinite) {
    throw InputError("organ \"" + model.options().name +
                     "\": static loads are solved for small strain only in this version; set "
                     "energy.strain = \"small\"");
  }
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

StaticSolution StaticLoads::Solve() const {
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
