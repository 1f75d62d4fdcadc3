#include "engine/statics/static_loads.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/base/error.h"
#include "engine/baselines/spring_rest.h"
#include "engine/contact/surface_kernel.h"
#include "engine/statics/static_newton.h"
#include "engine/tissue/support.h"

namespace hpdm {
namespace {

using UnknownMap = Eigen::Map<Eigen::VectorXd>;
using ConstUnknownMap = Eigen::Map<const Eigen::VectorXd>;

// Returns the elastic forces K U. U is (n + slots) x 3; `schur_complement` is nullptr without
// slots.
Eigen::VectorXd ElasticForce(const OrganModel& model, const SchurComplement* schur_complement,
                             const Points& U) {
  Eigen::VectorXd force(U.size());
  if (model.springs() != nullptr) {
    Eigen::Map<Points>(force.data(), U.rows(), 3) = model.springs()->RestoringForces(U);
    return force;
  }
  if (const auto* scalar = std::get_if<ScalarStiffness>(&model.stiffness())) {
    Eigen::Map<Points>(force.data(), U.rows(), 3) = *scalar * U;
    return force;
  }
  const auto& K = std::get<FullStiffness>(model.stiffness());
  const Eigen::Index own = U.size() - K.rows();
  const Eigen::Map<const Eigen::VectorXd> moved(U.data(), U.size());
  Eigen::VectorXd U_bar = moved.head(K.rows());
  if (schur_complement != nullptr) schur_complement->AddCoupling(1, moved.tail(own), U_bar);
  force.head(K.rows()) = K * U_bar;
  if (schur_complement == nullptr) return force;
  // K U_bar on U, and Y^T of that + Sigma V on V.
  force.tail(own) = -(schur_complement->stiffness() * moved.tail(own));
  schur_complement->Reduce(force.head(K.rows()), force.tail(own));
  force.tail(own) *= -1;
  return force;
}

std::unique_ptr<ComplianceSolver> MakeSolver(const OrganModel& model, int slots) {
  if (model.lattice_organ() == nullptr || model.finite_energy() != nullptr) return nullptr;
  if (model.refinement_basis() != nullptr)
    return MakeComplianceSolver(*model.refinement_basis(), slots);
  return std::visit([](const auto& K) { return MakeComplianceSolver(K); }, model.stiffness());
}

// Refuses an organ that a load would accelerate.
const OrganModel& RequireSupports(const OrganModel& model) {
  if (!model.options().free) return model;
  throw InputError("organ \"" + model.options().name +
                   "\": a free organ has no equilibrium under a load; give it an "
                   "[[organ.support]] instead of organ.free");
}

// m. A pressure's surface is split into parts with sides of this length.
double SampleSize(const OrganModel& model) {
  return model.lattice_organ() != nullptr
             ? ControlPointSpacing(model.lattice_organ()->lattice()) / 4
             : std::numeric_limits<double>::infinity();
}

// Sets columns 3 load + d to the row's weights along d.
void PutOnEachAxis(const Eigen::RowVectorXd& row, std::size_t load, Eigen::MatrixXd* columns) {
  for (Eigen::Index a = 0; a < row.size(); ++a) {
    for (int d = 0; d < 3; ++d) {
      (*columns)(3 * a + d, 3 * static_cast<Eigen::Index>(load) + d) = row[a];
    }
  }
}

}  // namespace

double StaticSolution::Compliance() const {
  if (load_forces.empty() || load_forces[0].norm() == 0) return 0;
  return load_displacements[0].dot(load_forces[0]) / load_forces[0].squaredNorm();
}

StaticLoads::StaticLoads(const OrganModel& model, const std::vector<LoadOptions>& loads)
    : model_(RequireSupports(model)),
      loads_(loads),
      active_(model.refinement_basis() != nullptr ? model.refinement_basis()->size() : 0,
              model.RefinementSlots(static_cast<int>(loads.size()))),
      solver_(MakeSolver(model, active_.slots())),
      rows_(Eigen::MatrixXd::Zero(3 * (model.control_points() + active_.slots()),
                                  3 * static_cast<Eigen::Index>(loads.size()))),
      pressures_(Eigen::VectorXd::Zero(rows_.rows())),
      pressure_force_(loads.size(), Vector3d::Zero()) {
  for (const LoadOptions& load : loads) {
    if (!load.pressure || (model.finite_energy() == nullptr && model.springs() == nullptr))
      continue;
    throw InputError("organ \"" + model.options().name +
                     "\": a pressure needs a constant stiffness; give a force, or take "
                     "strain = \"small\" and not mass_spring");
  }
  if (model.refinement_basis() != nullptr) {
    std::vector<Vector3d> centres;
    for (const LoadOptions& load : loads) {
      if (!load.pressure) centres.push_back(load.p_centre_W);
    }
    active_.ChooseNearest(model.refinement_basis()->centres(), centres,
                          LocalFunctionsOf(model.options()));
    schur_complement_.emplace(*model.refinement_basis(), active_.slots());
    schur_complement_->SetActiveFunctions(active_);
    if (solver_ != nullptr) solver_->SetActiveFunctions(active_);
  }
  if (model.options().model == OrganModelType::kContinuum) {
    surface_.emplace(std::get<ScalarStiffness>(model.stiffness()),
                     "organ \"" + model.options().name +
                         "\": nothing holds its surface; add an [[organ.support]]");
  }
  indentations_.resize(loads.size());
  for (std::size_t i = 0; i < loads.size(); ++i) {
    if (loads[i].pressure) {
      AddPressure(i);
    } else {
      AddPatch(i);
    }
  }
}

void StaticLoads::AddPatch(std::size_t load) {
  Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(rows_.rows() / 3);
  indentations_[load] =
      model_.AddLoadToRow(loads_[load].p_centre_W, loads_[load].radius, active_, row);
  PutOnEachAxis(row, load, &rows_);
}

void StaticLoads::AddPressure(std::size_t load) {
  const SurfaceMesh& rest = model_.rest();
  const std::vector<SurfaceSample> samples = SurfaceInRegion(
      rest, loads_[load].region, AxisAlignedBounds(rest.vertices), SampleSize(model_));
  Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(rows_.rows() / 3), row = mean;
  double area = 0;
  for (const SurfaceSample& sample : samples) {
    const auto corner = [&](int k) -> Vector3d {
      return rest.vertices.row(rest.triangles(sample.triangle, k));
    };
    const Vector3d normal = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
    const Vector3d force = -*loads_[load].pressure * sample.weight * normal;
    row.setZero();
    model_.AddToRow({sample.triangle, sample.barycentric}, 1, active_, row);
    mean += sample.weight * row;
    Eigen::Map<Points>(pressures_.data(), row.size(), 3) += row.transpose() * force.transpose();
    pressure_force_[load] += force;
    area += sample.weight;
  }
  // Around a whole body the resultant is only round-off.
  if (pressure_force_[load].norm() < 1e-9 * std::abs(*loads_[load].pressure) * area) {
    pressure_force_[load].setZero();
  }
  PutOnEachAxis(mean / area, load, &rows_);
}

// Solves columns of loads for displacements, in place.
void StaticLoads::Respond(Eigen::MatrixXd* columns) const {
  if (!surface_) return solver_->SolveLoads(*columns);
  for (Eigen::Index c = 0; c < columns->cols(); ++c) {
    surface_->Solve(Eigen::Map<Points>(columns->col(c).data(), columns->rows() / 3, 3));
  }
}

StaticSolution StaticLoads::SolveFinite() const {
  const std::size_t m = loads_.size();
  const Eigen::Index equations = rows_.cols();
  StaticLoadRows rows{rows_, Eigen::VectorXd::Zero(equations), Eigen::VectorXd::Zero(equations),
                      std::vector<bool>(3 * m, false), Eigen::MatrixXd::Zero(equations, equations)};
  for (std::size_t i = 0; i < m; ++i) {
    const auto at = static_cast<Eigen::Index>(3 * i);
    rows.local.block<3, 3>(at, at) += indentations_[i].Compliance();
    if (loads_[i].force_W.has_value()) rows.forces.segment<3>(at) = *loads_[i].force_W;
    if (!loads_[i].displacement_W.has_value()) continue;
    rows.moves.segment<3>(at) = *loads_[i].displacement_W;
    std::fill_n(rows.held.begin() + at, 3, true);
  }
  const std::unique_ptr<ElasticEnergy> energy = model_.finite_energy()->Clone();
  energy->SetActiveFunctions(active_);
  const StaticNewtonSolution found = SolveStaticLoads(rows, energy.get());

  StaticSolution solution;
  const Eigen::VectorXd moved =
      rows.rows.transpose() * ConstUnknownMap(found.U.data(), rows_.rows()) +
      rows.local * found.forces;
  solution.collapsed = energy->CollapsedShare(found.U);
  solution.control_displacements = found.U;
  solution.residual = found.residual;
  solution.share = found.share;
  solution.iterations = found.iterations;
  solution.vertex_displacements.resize(model_.rest().vertices.rows(), 3);
  model_.relocation().Displace(solution.control_displacements, &solution.vertex_displacements);
  model_.AddLocalDisplacements(active_, solution.control_displacements,
                               &solution.vertex_displacements);
  AddIndentations(found.forces, &solution);
  for (std::size_t i = 0; i < m; ++i) {
    const auto at = static_cast<Eigen::Index>(3 * i);
    solution.load_forces.emplace_back(found.forces.segment<3>(at));
    solution.load_displacements.emplace_back(moved.segment<3>(at));
  }
  return solution;
}

// Adds the state of fillings and layers; the vertices have no indentations yet.
void StaticLoads::AddSurfaceState(StaticSolution* solution) const {
  const LatticeOrgan* organ = model_.lattice_organ();
  if (organ == nullptr) return;
  const FillingsAndLayers& surface = organ->fillings_and_layers();
  for (const Lumen& lumen : surface.lumens()) {
    solution->lumen_pressures.push_back(-lumen.bulk_modulus *
                                        RelativeChange(lumen, solution->vertex_displacements));
  }
  solution->layer_tensions.resize(surface.tensions().layers());
  surface.tensions().FindLargest(model_.rest().vertices + solution->vertex_displacements,
                                 Matrix3d::Identity(), solution->layer_tensions);
}

void StaticLoads::AddIndentations(const Eigen::VectorXd& forces, StaticSolution* solution) const {
  for (std::size_t i = 0; i < loads_.size(); ++i) {
    if (loads_[i].pressure) continue;
    model_.AddIndentation(AppliedIndentation(indentations_[i], loads_[i].p_centre_W,
                                             forces.segment<3>(3 * static_cast<Eigen::Index>(i))),
                          &solution->vertex_displacements);
  }
}

// Returns the given forces and the forces that give the prescribed displacements. `free`:
// displacements of the patches without load.
Eigen::VectorXd StaticLoads::Forces(const Eigen::MatrixXd& compliance,
                                    const Eigen::VectorXd& free) const {
  const Eigen::Index m = static_cast<Eigen::Index>(loads_.size());
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
    const Eigen::VectorXd missing = wanted(held) - Eigen::VectorXd(free + compliance * force)(held);
    const Eigen::MatrixXd coupling = compliance(held, held);
    const Eigen::VectorXd found = coupling.ldlt().solve(missing);
    force(held) = found;
  }
  return force;
}

StaticSolution StaticLoads::Solve() const {
  if (model_.finite_energy() != nullptr) return SolveFinite();
  const Eigen::Index m = static_cast<Eigen::Index>(loads_.size());
  StaticSolution solution;
  solution.control_displacements.resize(rows_.rows() / 3, 3);
  UnknownMap U(solution.control_displacements.data(), rows_.rows());
  Eigen::VectorXd force, moved;
  if (model_.springs() != nullptr) {
    SpringRest at = RestUnderLoads(
        *model_.springs(), rows_,
        [this](const auto& compliance, const auto& free) { return Forces(compliance, free); },
        model_.options().name);
    U = Eigen::Map<const Eigen::VectorXd>(at.displacements.data(), U.size());
    force = std::move(at.forces);
    moved = rows_.transpose() * U;
  } else {
    Eigen::MatrixXd columns(rows_.rows(), 3 * m + 1);
    columns << rows_, pressures_;
    Respond(&columns);
    const Eigen::MatrixXd response = rows_.transpose() * columns;
    Eigen::MatrixXd compliance = response.leftCols(3 * m);  // 3m x 3m
    const Eigen::VectorXd pressed = response.col(3 * m);
    for (Eigen::Index i = 0; i < m; ++i) {
      compliance.block<3, 3>(3 * i, 3 * i) +=
          indentations_[static_cast<std::size_t>(i)].Compliance();
    }
    force = Forces(compliance, pressed);
    U = columns.leftCols(3 * m) * force + columns.col(3 * m);
    moved = compliance * force + pressed;
  }
  solution.vertex_displacements.resize(model_.rest().vertices.rows(), 3);
  model_.relocation().Displace(solution.control_displacements, &solution.vertex_displacements);
  model_.AddLocalDisplacements(active_, solution.control_displacements,
                               &solution.vertex_displacements);
  AddSurfaceState(&solution);
  AddIndentations(force, &solution);
  for (Eigen::Index i = 0; i < m; ++i) {
    solution.load_forces.emplace_back(force.segment<3>(3 * i) +
                                      pressure_force_[static_cast<std::size_t>(i)]);
    solution.load_displacements.emplace_back(moved.segment<3>(3 * i));
  }
  return solution;
}

double StaticLoads::Residual(const StaticSolution& solution) const {
  if (model_.finite_energy() != nullptr) return solution.residual;
  Eigen::VectorXd applied = pressures_;
  for (std::size_t i = 0; i < loads_.size(); ++i) {
    if (loads_[i].pressure) continue;
    applied += rows_.middleCols<3>(3 * static_cast<Eigen::Index>(i)) * solution.load_forces[i];
  }
  const double size = applied.norm();
  if (size == 0) return 0;
  return (ElasticForce(model_, schur_complement_ ? &*schur_complement_ : nullptr,
                       solution.control_displacements) -
          applied)
             .norm() /
         size;
}

}  // namespace hpdm
