#include "tools/chart/static_case_model.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/check.h"
#include "engine/base/error.h"
#include "engine/baselines/mass_spring.h"
#include "engine/baselines/press_volume.h"
#include "engine/baselines/surface_continuum.h"
#include "engine/contact/surface_kernel.h"

namespace hpdm {
namespace {

// A body is at rest when a step moves its vertices by less than this, relative. The iterative
// models use it as tolerance.
constexpr double kAtRest = 1e-6;
constexpr int kMaxSteps = 20;
constexpr int kMaxDynamicSteps = 300;  // ten seconds of simulated time for the mass-spring model
constexpr double kTolerance = 1e-4;    // relative to the loads

std::unique_ptr<Relaxation> MakeSurfaceModel(const OrganOptions& options, const SurfaceMesh& rest) {
  const double alpha = options.energy.alpha;
  const Eigen::VectorXd ground =
      GroundSprings(rest, MeasureSkin(rest, options.name), options.supports, alpha, options.name);
  if (options.model == OrganModelType::kContinuum) {
    SurfaceContinuumOptions continuum;
    continuum.alpha = alpha;
    // One step gives the static answer. A session does not compute the residual.
    continuum.time_step = std::numeric_limits<double>::infinity();
    continuum.report_residual = false;
    return std::make_unique<SurfaceContinuum>(rest, ground, continuum, options.name);
  }
  if (options.model == OrganModelType::kMassSpring) {
    MassSpringOptions springs;
    springs.alpha = alpha;
    return std::make_unique<MassSpring>(rest, ground, springs, options.name);
  }
  throw InputError("organ \"" + options.name +
                   "\": a rigid organ does not deform; use model = \"hpdm\"");
}

}  // namespace

StaticCaseModel::StaticCaseModel(const SurfaceMesh& rest, const std::vector<LoadOptions>& loads,
                                 const OrganOptions& options)
    : rest_(rest), loads_(loads), options_(options), contacts_(0), vertices_(rest.vertices) {
  const TimingClock::time_point start = TimingClock::now();
  if (options.model == OrganModelType::kHpdm) {
    organ_.emplace(options, rest);
    weights_ = organ_->weights();
    slots_ = organ_->RefinementSlots(static_cast<int>(loads.size()));
    relaxation_ = organ_->MakeRelaxation(slots_);
  } else {
    weights_ = VertexWeights(rest.vertices.rows());
    relaxation_ = MakeSurfaceModel(options, rest);
  }
  setup_ms_ = MillisecondsSince(start);
  AddPatches();
}

void StaticCaseModel::Reload(const std::vector<LoadOptions>& loads) {
  loads_ = loads;
  indentations_.clear();
  AddPatches();
  start_ = U_;
}

void StaticCaseModel::AddPatches() {
  if (loads_.size() > kMaxToolRows) {
    throw InputError("organ \"" + options_.name + "\": has more than " +
                     std::to_string(kMaxToolRows) + " loads; leave some out");
  }
  contacts_ =
      ContactConstraints(unknowns(), slots_ > 0 ? organ_->refinement_basis()->size() : 0, slots_);
  if (slots_ > 0) {
    HPDM_CHECK(organ_->RefinementSlots(static_cast<int>(loads_.size())) <= slots_);
    std::vector<Vector3d> centres;
    for (const LoadOptions& load : loads_) centres.push_back(load.p_centre_W);
    contacts_.refinement.ChooseNearest(organ_->refinement_basis()->centres(), centres,
                                       LocalFunctionsOf(options_));
  }
  U_ = Points::Zero(unknowns() + slots_, 3);
  patches_ = ContactWeights::Zero(static_cast<Eigen::Index>(loads_.size()), rest_.vertices.rows());
  for (std::size_t i = 0; i < loads_.size(); ++i) {
    auto patch = patches_.row(static_cast<Eigen::Index>(i));
    for (const SurfaceSample& sample :
         SurfaceKernel(rest_, loads_[i].p_centre_W, loads_[i].radius)) {
      for (int k = 0; k < 3; ++k) {
        patch[rest_.triangles(sample.triangle, k)] += sample.weight * sample.barycentric[k];
      }
    }
    ContactConstraints::Row* row = contacts_.Add();
    row->kind = ContactConstraints::RowKind::kGrasp;
    row->p_rest_W = (patch * rest_.vertices).transpose();
    row->target_W = row->p_rest_W;
    if (organ_) {
      AddLatticeRow(i);
    } else {
      contacts_.WeightRow(contacts_.size() - 1) = patch;
      indentations_.emplace_back();
    }
  }
  moved_ = Eigen::VectorXd::Zero(3 * contacts_.size());
}

void StaticCaseModel::AddLatticeRow(std::size_t load) {
  const LoadOptions& options = loads_[load];
  indentations_.push_back(organ_->AddLoadToRow(options.p_centre_W, options.radius,
                                               contacts_.refinement,
                                               contacts_.WeightRow(static_cast<int>(load))));
}

int StaticCaseModel::local_functions() const { return contacts_.refinement.used(); }

void StaticCaseModel::AddIndentations(Points* vertices) const {
  organ_->AddLocalDisplacements(contacts_.refinement, U_, vertices);
  for (int i = 0; i < contacts_.size(); ++i) {
    const auto load = static_cast<std::size_t>(i);
    organ_->AddIndentation(
        AppliedIndentation(indentations_[load], loads_[load].p_centre_W, contacts_[i].force_W),
        vertices);
  }
}

Points StaticCaseModel::VertexDisplacements() const {
  Points u = weights_ * U_.topRows(weights_.cols());
  if (organ_) AddIndentations(&u);
  return u;
}

RelaxationResult StaticCaseModel::Step(const Eigen::VectorXd& displacements) {
  for (int i = 0; i < contacts_.size(); ++i) {
    contacts_[i].target_W = contacts_[i].p_rest_W + displacements.segment<3>(3 * i);
  }
  if (organ_) {  // stage A; the surface models move in other ways
    Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor, kMaxToolRows, 3> change(
        contacts_.size(), 3);
    for (int i = 0; i < contacts_.size(); ++i) {
      change.row(i) = displacements.segment<3>(3 * i).transpose() - contacts_.Weights().row(i) * U_;
    }
    MoveDirectly(contacts_.Weights(), change, U_);
  }
  const RelaxationResult result =
      relaxation_->Relax(&contacts_, &U_, {.start = start_ ? &*start_ : nullptr});
  start_.reset();
  return result;
}

void StaticCaseModel::Settle(const Eigen::VectorXd& displacements) {
  Points last;
  const int most = options_.model == OrganModelType::kMassSpring ? kMaxDynamicSteps : kMaxSteps;
  for (int step = 0; step < most; ++step) {
    last = U_;
    Step(displacements);
    if (step > 0 && (U_ - last).norm() <= kAtRest * U_.norm()) return;
  }
}

Eigen::VectorXd StaticCaseModel::Forces() const {
  Eigen::VectorXd forces(3 * contacts_.size());
  for (int i = 0; i < contacts_.size(); ++i) forces.segment<3>(3 * i) = contacts_[i].force_W;
  return forces;
}

void StaticCaseModel::MoveTo(const Points& u) {
  for (int i = 0; i < contacts_.size(); ++i) {
    moved_.segment<3>(3 * i) = (patches_.row(i) * u).transpose();
  }
  Settle(moved_);
}

bool StaticCaseModel::Balance() {
  const Eigen::Index size = moved_.size();
  Eigen::VectorXd force = Eigen::VectorXd::Zero(size);  // demanded, for loads given as force
  Eigen::VectorXd depth = Eigen::VectorXd::Zero(size);  // demanded, for the other loads
  Eigen::MatrixXd indentation = Eigen::MatrixXd::Zero(size, size);
  for (int i = 0; i < contacts_.size(); ++i) {
    const LoadOptions& load = loads_[static_cast<std::size_t>(i)];
    if (load.force_W.has_value()) force.segment<3>(3 * i) = *load.force_W;
    if (load.displacement_W.has_value()) depth.segment<3>(3 * i) = *load.displacement_W;
    indentation.block<3, 3>(3 * i, 3 * i) = indentations_[static_cast<std::size_t>(i)].Compliance();
  }
  moved_ = depth;
  const bool only_depths = force.isZero(0) && indentation.isZero(0);
  if (only_depths) {
    Settle(moved_);
    return true;
  }

  // f(x) is the patches' force at the displacements x. S is its tangent, first by differences at
  // rest.
  const double probe = 1e-5;  // m: small strain, well above round-off
  Eigen::MatrixXd S(size, size);
  for (Eigen::Index j = 0; j < size; ++j) {
    Settle(probe * Eigen::VectorXd::Unit(size, j));
    S.col(j) = Forces() / probe;
  }
  // The demand: f = force for loads given as force, x + indentation f = depth for the others.
  const auto missing = [&](const Eigen::VectorXd& x, const Eigen::VectorXd& f) {
    Eigen::VectorXd r = force - f;
    for (Eigen::Index j = 0; j < size; ++j) {
      if (IsDepth(j)) r[j] = depth[j] - x[j] - indentation.row(j).dot(f);
    }
    return r;
  };
  Eigen::VectorXd x = Eigen::VectorXd::Zero(size), f = x;
  for (int iteration = 0; iteration < 30; ++iteration) {
    Eigen::MatrixXd tangent = S;
    for (Eigen::Index j = 0; j < size; ++j) {
      if (IsDepth(j)) tangent.row(j) = Eigen::RowVectorXd::Unit(size, j) + indentation.row(j) * S;
    }
    const Eigen::VectorXd change = tangent.fullPivLu().solve(missing(x, f));
    x += change;
    Settle(x);
    const Eigen::VectorXd found = Forces();
    if (!found.allFinite()) return false;
    moved_ = x;
    const Eigen::VectorXd r = missing(x, found);
    bool met = true;
    for (Eigen::Index j = 0; j < size; ++j) {
      met &= std::abs(r[j]) <= kTolerance * (IsDepth(j) ? depth : force).norm();
    }
    if (met) return true;
    S += (found - f - S * change) * change.transpose() / change.squaredNorm();
    f = found;
  }
  return false;
}

bool StaticCaseModel::IsDepth(Eigen::Index component) const {
  return loads_[static_cast<std::size_t>(component / 3)].displacement_W.has_value();
}

void StaticCaseModel::StartFrom(const StaticCaseModel& other) {
  HPDM_CHECK(other.U_.rows() == U_.rows() && other.moved_.size() == moved_.size());
  U_ = other.U_;
  moved_ = other.moved_;
}

StaticCaseModel::StepTimes StaticCaseModel::TimeSteps() {
  StepTimes times;
  bool all = false;
  times.response = Time([&] {
    times.last = Step((all ? 1.0 : 0.95) * moved_);
    all = !all;
  });
  if (organ_) {
    times.relocation = Time([&] { organ_->relocation().Relocate(U_, &vertices_); });
    times.indentations = Time([&] { AddIndentations(&vertices_); });
  }
  Settle(moved_);
  return times;
}

StaticCaseModel::WayTimes StaticCaseModel::TimeWay(int steps) {
  std::unique_ptr<Relaxation> fresh = relaxation_->Clone();
  Eigen::VectorXd all = Eigen::VectorXd::Zero(moved_.size());
  for (int i = 0; i < contacts_.size(); ++i) {
    const auto& displacement = loads_[static_cast<std::size_t>(i)].displacement_W;
    if (!displacement) throw InputError(options_.name + ": a way needs displacements; no forces");
    all.segment<3>(3 * i) = *displacement;
  }
  WayTimes times;
  for (int step = 1; step <= steps; ++step) {
    const double before = ThreadMilliseconds();
    const RelaxationResult result = Step(static_cast<double>(step) / steps * all);
    const double ms = ThreadMilliseconds() - before;
    times.mean_ms += ms / steps;
    times.most_ms = std::max(times.most_ms, ms);
    times.iterations += static_cast<double>(result.iterations) / steps;
    times.unfinished += result.converged ? 0 : 1;
  }
  relaxation_ = std::move(fresh);
  U_.setZero();
  start_ = U_;
  return times;
}

double StaticCaseModel::Compliance() const {
  const Vector3d force = contacts_[0].force_W;
  if (force.norm() == 0) return 0;
  const Vector3d moved = moved_.head<3>() + indentations_[0].Compliance() * force;
  return moved.dot(force) / force.squaredNorm();
}

}  // namespace hpdm
