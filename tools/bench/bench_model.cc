#include "tools/bench/bench_model.h"

#include <cmath>
#include <limits>

#include "engine/baselines/surface_continuum.h"
#include "engine/solver/sparse_cholesky.h"
#include "scenes/generator/mesh_assets.h"
#include "tools/shared/timing.h"

namespace hpdm {
namespace {

// Both models' Gauss-Seidel solvers stop at this tolerance: the iterative rows compare equal
// residuals.
constexpr GaussSeidelOptions kIterative{.max_sweeps = 200000, .tolerance = 1e-6};

SurfaceContinuum MakeContinuum(const BenchOrgan& organ) {
  SurfaceContinuumOptions options;
  options.alpha = organ.options.energy.alpha;
  options.time_step = std::numeric_limits<double>::infinity();  // gives the static answer in one
                                                                // step
  options.report_residual = false;                              // measured separately, not timed
  const Skin skin = MeasureSkin(organ.rest, organ.options.name);
  return SurfaceContinuum(
      organ.rest,
      GroundSprings(organ.rest, skin, organ.options.supports, options.alpha, organ.options.name),
      options, organ.options.name);
}

}  // namespace

BenchOrgan MakeBenchOrgan(const std::string& asset) {
  BenchOrgan organ;
  organ.rest = MakeMeshAsset(asset);
  organ.options.name = asset;
  organ.options.energy.type = EnergyType::kStrain;
  organ.options.lattice.local.functions = 0;
  organ.options.supports = {{BoxFraction{Vector3d(0, 0.7, 0), Vector3d::Ones()}, {}}};
  return organ;
}

SurfacePoint FrontPoint(const SurfaceMesh& rest, double side) {
  SurfacePoint best;
  double highest = -std::numeric_limits<double>::infinity();
  for (int t = 0; t < rest.triangles.rows(); ++t) {
    const SurfacePoint centre{t, Vector3d::Constant(1. / 3)};
    const Vector3d p = centre.Position(rest.vertices, rest.triangles);
    const double height = p.z() - std::abs(p.x() - side);  // a 45-degree ridge above the line x =
                                                           // side
    if (height <= highest) continue;
    highest = height;
    best = centre;
  }
  return best;
}

BenchModel::BenchModel(const BenchOrgan& organ, double side)
    : rest_(organ.rest.vertices), vertices_(rest_) {
  const TimingClock::time_point start = TimingClock::now();
  organ_ = std::make_unique<OrganModel>(organ.options, organ.rest);
  stiffness_ = organ_->stiffness();
  if (organ.options.energy.solver == SolverType::kGaussSeidel) {
    relaxation_ = std::visit([](const auto& K) { return MakeGaussSeidelRelaxation(K, kIterative); },
                             stiffness_);
  } else {
    relaxation_ = organ_->MakeRelaxation(organ_->RefinementSlots(1));
  }
  setup_ms_ = MillisecondsSince(start);
  AddPress(organ, side);
}

BenchModel::BenchModel(const BenchOrgan& organ, ContinuumStep step, double side)
    : rest_(organ.rest.vertices), vertices_(rest_) {
  const TimingClock::time_point start = TimingClock::now();
  auto continuum = std::make_unique<SurfaceContinuum>(MakeContinuum(organ));
  const ScalarStiffness K = continuum->stiffness();
  stiffness_ = K;
  repositions_ = step == ContinuumStep::kGaussSeidel;
  if (step == ContinuumStep::kGaussSeidel) {
    relaxation_ = MakeGaussSeidelRelaxation(K, kIterative);
  } else {
    relaxation_ = std::move(continuum);
  }
  if (step == ContinuumStep::kFactorisedAnew) {
    before_step_ = [K] { SparseCholesky(K, "bench: the continuum's stiffness is singular"); };
  }
  setup_ms_ = MillisecondsSince(start);
  AddPress(organ, side);
}

void BenchModel::AddPress(const BenchOrgan& organ, double side) {
  const Triangles& triangles = organ.rest.triangles;
  const SurfacePoint at = FrontPoint(organ.rest, side);
  const int slots = organ_ ? organ_->RefinementSlots(1) : 0;
  contacts_ =
      ContactConstraints(unknowns(), slots > 0 ? organ_->refinement_basis()->size() : 0, slots);
  U_ = Points::Zero(unknowns() + slots, 3);
  ContactConstraints::Row* row = contacts_.Add();
  row->p_rest_W = at.Position(rest_, triangles);
  const Vector3d a = rest_.row(triangles(at.triangle, 0));
  row->normal_W = (Vector3d(rest_.row(triangles(at.triangle, 1))) - a)
                      .cross(Vector3d(rest_.row(triangles(at.triangle, 2))) - a)
                      .normalized();
  if (slots > 0) RefineAtTip();
  if (organ_) {
    organ_->AddToRow(at, 1, contacts_.refinement, contacts_.WeightRow(0));
  } else {
    for (int k = 0; k < 3; ++k) {
      contacts_.WeightRow(0)[triangles(at.triangle, k)] = at.barycentric[k];
    }
  }
}

void BenchModel::RefineAtTip() {
  const Vector3d p = contacts_[0].p_rest_W;
  contacts_.refinement.ChooseNearest(organ_->refinement_basis()->centres(), {&p, 1},
                                     LocalFunctionsOf(organ_->options()));
}

void BenchModel::Step() {
  ContactConstraints::Row& row = contacts_[0];
  row.target_W = row.p_rest_W - (deep_ ? 0.010 : 0.009) * row.normal_W;
  deep_ = !deep_;
  if (before_step_) before_step_();
  if (contacts_.refinement.slots() > 0) RefineAtTip();
  if (repositions_) {
    const Eigen::RowVector3d p = row.p_rest_W.transpose() + contacts_.Weights().row(0) * U_;
    const double move = std::min(0.0, row.normal_W.dot(row.target_W - p.transpose()));
    const Points change = move * row.normal_W.transpose();
    MoveDirectly(contacts_.Weights(), change, U_);
  }
  relaxation_->Relax(&contacts_, &U_);
  if (organ_) {
    organ_->relocation().Relocate(U_, &vertices_);
    organ_->AddLocalDisplacements(contacts_.refinement, U_, &vertices_);
  } else {
    vertices_ = rest_ + U_;
  }
}

double BenchModel::StaticResidual() const {
  const Eigen::Index n = unknowns();
  Points elastic(n, 3);
  if (const auto* scalar = std::get_if<ScalarStiffness>(&stiffness_)) {
    elastic = *scalar * U_;
  } else {
    // Y = K^-1 K_c for the local functions (refinement_basis.h), so K U + K_c V = K (U + Y V).
    Points moved = U_.topRows(n);
    Eigen::Map<Eigen::VectorXd> u(moved.data(), moved.size());
    for (int s = 0; s < contacts_.refinement.slots(); ++s) {
      const int function = contacts_.refinement.Function(s);
      if (function >= 0)
        u += organ_->refinement_basis()->Coupling(function) * U_.row(n + s).transpose();
    }
    Eigen::Map<Eigen::VectorXd>(elastic.data(), elastic.size()) =
        std::get<FullStiffness>(stiffness_) * u;
  }
  const Points load =
      contacts_.Weights().row(0).head(n).transpose() * contacts_[0].force_W.transpose();
  return (elastic - load).norm() / load.norm();
}

}  // namespace hpdm
