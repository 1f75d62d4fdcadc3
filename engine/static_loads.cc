#include "engine/static_loads.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

#include "engine/static_newton.h"
#include "engine/surface_kernel.h"

namespace hpdm {
namespace {

using UnknownMap = Eigen::Map<Eigen::VectorXd>;

// What holds U in place: the stiffness times U; U is (n + slots) x 3.
Eigen::VectorXd ElasticForce(const OrganModel& model, const ActiveFunctions& active,
                             const Points& U) {
  Eigen::VectorXd force(U.size());
  if (const auto* scalar = std::get_if<ScalarStiffness>(&model.stiffness())) {
    Eigen::Map<Points>(force.data(), U.rows(), 3) = *scalar * U;
    return force;
  }
  const auto& K = std::get<FullStiffness>(model.stiffness());
  // With X = K^-1 C: K U + C V = K (U + X V), and C^T U + D V = X^T of that + S V.
  const auto displacement = [&U](Eigen::Index a) { return U.row(a).transpose(); };
  Eigen::VectorXd moved = Eigen::Map<const Eigen::VectorXd>(U.data(), K.rows());
  const Eigen::Index n = K.rows() / 3;
  for (int s = 0; s < active.slots(); ++s) {
    if (active.Function(s) < 0) continue;
    moved += model.local()->Coupling(active.Function(s)) * displacement(n + s);
  }
  force.setZero();
  force.head(K.rows()) = K * moved;
  for (int s = 0; s < active.slots(); ++s) {
    if (active.Function(s) < 0) continue;
    auto own = force.segment<3>(K.rows() + 3 * s);
    own = model.local()->Coupling(active.Function(s)).transpose() * force.head(K.rows());
    for (int t = 0; t < active.slots(); ++t) {
      if (active.Function(t) < 0) continue;
      own += model.local()->ReducedStiffness(active.Function(s), active.Function(t)) *
             displacement(n + t);
    }
  }
  return force;
}

std::unique_ptr<LatticeResponse> MakeResponse(const OrganModel& model, int slots) {
  if (model.finite_energy() != nullptr) return nullptr;
  if (model.local() != nullptr) return MakeLatticeResponse(*model.local(), slots);
  return std::visit([](const auto& K) { return MakeLatticeResponse(K); }, model.stiffness());
}

}  // namespace

double StaticSolution::Compliance() const {
  if (load_forces.empty() || load_forces[0].norm() == 0) return 0;
  return load_displacements[0].dot(load_forces[0]) / load_forces[0].squaredNorm();
}

StaticLoads::StaticLoads(const OrganModel& model, const std::vector<LoadOptions>& loads)
    : model_(model),
      loads_(loads),
      active_(model.local() != nullptr ? model.local()->size() : 0,
              model.LocalSlots(static_cast<int>(loads.size()))),
      response_(MakeResponse(model, active_.slots())),
      rows_(Eigen::MatrixXd::Zero(3 * (model.lattice().size() + active_.slots()),
                                  3 * static_cast<Eigen::Index>(loads.size()))) {
  if (model.local() != nullptr) {
    std::vector<Vector3d> centres;
    for (const LoadOptions& load : loads) centres.push_back(load.p_centre_W);
    active_.Follow(model.local()->centres(), centres, model.options().lattice.local.functions);
    response_->Follow(active_);
  }
  Eigen::RowVectorXd row(rows_.rows() / 3);
  for (std::size_t i = 0; i < loads.size(); ++i) {
    const SurfacePoint at = NearestSurfacePoint(model.rest(), loads[i].p_centre_W);
    dents_.push_back(model.Dent(at, loads[i].radius));
    row.setZero();
    for (const SurfaceSample& sample : SurfaceKernel(model.rest(), loads[i].p_centre_W,
                                                     model.ResolvedRadius(at, loads[i].radius))) {
      model.AddToRow(AtSample(sample, model.rest().triangles, model.rest().vertices), sample.weight,
                     active_, row);
    }
    for (Eigen::Index a = 0; a < row.size(); ++a) {
      for (int d = 0; d < 3; ++d) {
        rows_(3 * a + d, 3 * static_cast<Eigen::Index>(i) + d) = row[a];
      }
    }
  }
}

int StaticLoads::local_functions() const {
  int count = 0;
  for (int s = 0; s < active_.slots(); ++s) count += active_.Function(s) >= 0;
  return count;
}

StaticSolution StaticLoads::SolveFinite() const {
  const std::size_t m = loads_.size();
  const Eigen::Index equations = rows_.cols();
  StaticLoadRows rows{rows_, Eigen::VectorXd::Zero(equations), Eigen::VectorXd::Zero(equations),
                      std::vector<bool>(3 * m, false), Eigen::MatrixXd::Zero(equations, equations)};
  for (std::size_t i = 0; i < m; ++i) {
    const auto at = static_cast<Eigen::Index>(3 * i);
    rows.local.block<3, 3>(at, at) = dents_[i].Compliance();
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
      rows_.transpose() * UnknownMap(solution.control_displacements.data(), rows_.rows()) +
      rows.local * found.forces;
  for (std::size_t i = 0; i < m; ++i) {
    const auto at = static_cast<Eigen::Index>(3 * i);
    solution.load_forces.emplace_back(found.forces.segment<3>(at));
    solution.load_displacements.emplace_back(moved.segment<3>(at));
  }
  AddDents(&solution);
  return solution;
}

void StaticLoads::AddDents(StaticSolution* solution) const {
  for (std::size_t i = 0; i < loads_.size(); ++i) {
    model_.AddDent(dents_[i], loads_[i].p_centre_W, solution->load_forces[i],
                   &solution->vertex_displacements);
  }
}

StaticSolution StaticLoads::Solve() const {
  if (response_ == nullptr) return SolveFinite();
  const Eigen::Index m = static_cast<Eigen::Index>(loads_.size());
  Eigen::MatrixXd columns = rows_;
  response_->Solve(columns);
  Eigen::MatrixXd compliance = rows_.transpose() * columns;  // 3m x 3m
  for (Eigen::Index i = 0; i < m; ++i) {
    compliance.block<3, 3>(3 * i, 3 * i) += dents_[static_cast<std::size_t>(i)].Compliance();
  }

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
  solution.control_displacements.resize(rows_.rows() / 3, 3);
  UnknownMap U(solution.control_displacements.data(), rows_.rows());
  U = columns * force;
  solution.vertex_displacements =
      model_.weights() * solution.control_displacements.topRows(model_.lattice().size());
  model_.AddLocalDisplacements(active_, solution.control_displacements,
                               &solution.vertex_displacements);
  const Eigen::VectorXd moved = compliance * force;
  for (Eigen::Index i = 0; i < m; ++i) {
    solution.load_forces.emplace_back(force.segment<3>(3 * i));
    solution.load_displacements.emplace_back(moved.segment<3>(3 * i));
  }
  AddDents(&solution);
  return solution;
}

double StaticLoads::Residual(const StaticSolution& solution) const {
  if (response_ == nullptr) return solution.residual;
  Eigen::VectorXd applied = Eigen::VectorXd::Zero(rows_.rows());
  for (std::size_t i = 0; i < loads_.size(); ++i) {
    applied += rows_.middleCols<3>(3 * static_cast<Eigen::Index>(i)) * solution.load_forces[i];
  }
  const double size = applied.norm();
  if (size == 0) return 0;
  return (ElasticForce(model_, active_, solution.control_displacements) - applied).norm() / size;
}

}  // namespace hpdm
