#include "engine/baselines/surface_continuum.h"

#include <algorithm>
#include <array>

#include "engine/base/check.h"

namespace hpdm {
namespace {

// Cotangent Laplacian L, V x V: u^T L u = int |grad u|^2 da for u linear on each triangle.
ScalarStiffness CotangentLaplacian(const SurfaceMesh& rest) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<std::size_t>(12 * rest.triangles.rows()));
  for (Eigen::Index t = 0; t < rest.triangles.rows(); ++t) {
    std::array<Vector3d, 3> p;
    for (int k = 0; k < 3; ++k) p[k] = rest.vertices.row(rest.triangles(t, k));
    const double twice_area = (p[1] - p[0]).cross(p[2] - p[0]).norm();
    double longest2 = 0;
    for (int k = 0; k < 3; ++k) {
      longest2 = std::max(longest2, (p[k] - p[(k + 1) % 3]).squaredNorm());
    }
    if (twice_area <= 1e-6 * longest2) continue;  // degenerate as in MeshFacts
    for (int k = 0; k < 3; ++k) {
      const int i = rest.triangles(t, (k + 1) % 3), j = rest.triangles(t, (k + 2) % 3);
      const double cotangent = (p[(k + 1) % 3] - p[k]).dot(p[(k + 2) % 3] - p[k]) / twice_area;
      const double w = cotangent / 2;
      entries.emplace_back(i, i, w);
      entries.emplace_back(j, j, w);
      entries.emplace_back(i, j, -w);
      entries.emplace_back(j, i, -w);
    }
  }
  ScalarStiffness L(rest.vertices.rows(), rest.vertices.rows());
  L.setFromTriplets(entries.begin(), entries.end());
  return L;
}

ScalarStiffness Diagonal(const Eigen::VectorXd& values) {
  ScalarStiffness identity(values.size(), values.size());
  identity.setIdentity();
  return values.asDiagonal() * identity;
}

ScalarStiffness WithGround(const SurfaceMesh& rest, const Skin& skin,
                           const Eigen::VectorXd& ground_springs,
                           const SurfaceContinuumOptions& options) {
  HPDM_CHECK(ground_springs.size() == rest.vertices.rows() && options.time_step > 0);
  return SurfaceStiffness(rest, skin.areas, options.alpha * skin.thickness,
                          options.beta * skin.thickness) +
         Diagonal(ground_springs);
}

}  // namespace

SurfaceContinuumOptions ContinuumOf(const MaterialOptions& material, double thickness,
                                    double time_step) {
  const double modulus = material.young / (1 - material.poisson * material.poisson);
  SurfaceContinuumOptions options;
  options.alpha = 0.18 * modulus;
  options.beta = 0.32 * modulus * thickness * thickness;
  options.density = material.density;
  options.time_step = time_step;
  return options;
}

ScalarStiffness SurfaceStiffness(const SurfaceMesh& rest, const Eigen::VectorXd& areas,
                                 double tension, double bending) {
  const ScalarStiffness L = CotangentLaplacian(rest);
  const ScalarStiffness curvature = areas.cwiseInverse().asDiagonal() * L;
  const ScalarStiffness bend = ScalarStiffness(L.transpose()) * curvature;
  // The product's round-off is not symmetric; the mean with its transpose is.
  return tension * L + bending / 2 * (bend + ScalarStiffness(bend.transpose()));
}

SurfaceContinuum::SurfaceContinuum(const SurfaceMesh& rest, const Eigen::VectorXd& ground_springs,
                                   const SurfaceContinuumOptions& options, const std::string& name)
    : SurfaceContinuum(rest, MeasureSkin(rest, name), ground_springs, options, name) {}

SurfaceContinuum::SurfaceContinuum(const SurfaceMesh& rest, const Skin& skin,
                                   const Eigen::VectorXd& ground_springs,
                                   const SurfaceContinuumOptions& options, const std::string& name)
    : options_(options),
      mass_(options.density * skin.Volumes()),
      K_(WithGround(rest, skin, ground_springs, options)),
      factor_(StepMatrix(), "organ \"" + name +
                                "\": surface stiffness is not positive definite; add an "
                                "[[organ.support]] or raise alpha"),
      u_(Points::Zero(rest.vertices.rows(), 3)),
      v_(u_),
      solution_(u_),
      pull_(u_),
      response_(Eigen::MatrixXd::Zero(rest.vertices.rows(), kMaxContacts)),
      rows_(rest.vertices.rows()) {}

ScalarStiffness SurfaceContinuum::StepMatrix() const {
  const double dt = options_.time_step;
  return K_ + Diagonal((1 / (dt * dt) + options_.damping / (2 * dt)) * mass_);
}

void SurfaceContinuum::Reset(const Points& u) {
  u_ = u;
  v_.setZero();
}

RelaxationResult SurfaceContinuum::DoRelax(const RelaxationInput& /*input*/,
                                           ContactConstraints* contacts, Points* U) {
  const double dt = options_.time_step;
  const double inertia = 1 / (dt * dt) + options_.damping / (2 * dt);
  const double momentum = 1 / dt - options_.damping / 2;
  for (Eigen::Index v = 0; v < u_.rows(); ++v) {
    solution_.row(factor_.Place(v)) = mass_[v] * (inertia * u_.row(v) + momentum * v_.row(v));
  }
  factor_.SolveLower(&solution_);

  RelaxationResult result;
  const int m = contacts->size();
  if (m > 0) {
    // With Y = L^-1 P B^T and z = L^-1 P g: B A^-1 B^T = Y^T Y and B A^-1 g = Y^T z.
    rows_.Gather(*contacts);
    auto Y = response_.leftCols(m);
    Y.setZero();
    for (int i = 0; i < m; ++i) {
      for (const ContactRows::Entry* e = rows_.begin(i); e != rows_.end(i); ++e) {
        Y(factor_.Place(e->vertex), i) = e->weight;
      }
      factor_.SolveLowerSparse(Y.col(i));
    }
    compliance_.resize(m, m);
    for (int i = 0; i < m; ++i) {
      for (int j = 0; j <= i; ++j) {
        compliance_(i, j) = compliance_(j, i) = Y.col(i).dot(Y.col(j));
      }
      for (int d = 0; d < 3; ++d) p_free_W_[i][d] = Y.col(i).dot(solution_.col(d));
      p_free_W_[i] += (*contacts)[i].p_rest_W;
      targets_W_[i] = (*contacts)[i].target_W;
    }
    result = SolveContactForces(compliance_, p_free_W_, targets_W_, &contact_solver_, contacts);
    for (int i = 0; i < m; ++i) {
      for (int d = 0; d < 3; ++d) solution_.col(d) += (*contacts)[i].force_W[d] * Y.col(i);
    }
  }
  factor_.SolveUpper(&solution_);
  for (Eigen::Index v = 0; v < u_.rows(); ++v) {
    const auto next = solution_.row(factor_.Place(v));
    v_.row(v) = (next - u_.row(v)) / dt;
    u_.row(v) = next;
  }
  if (m == 0 && v_.isZero(kStill / dt) && u_.isZero(kStill)) {
    u_.setZero();
    v_.setZero();
  }
  *U = u_;
  if (!u_.allFinite()) {  // the caller reports it; the next step starts at rest
    Reset(Points::Zero(u_.rows(), 3));
    result.converged = false;
    return result;
  }
  if (options_.report_residual) result.residual = StaticResidual(*contacts);
  return result;
}

double SurfaceContinuum::StaticResidual(const ContactConstraints& contacts) {
  pull_.noalias() = K_ * u_;
  Points& off_balance = solution_;  // free between steps
  off_balance.setZero();
  for (int i = 0; i < contacts.size(); ++i) {
    for (const ContactRows::Entry* e = rows_.begin(i); e != rows_.end(i); ++e) {
      off_balance.row(e->vertex) += e->weight * contacts[i].force_W.transpose();
    }
  }
  const double load = off_balance.norm();
  return load == 0 ? 0 : (pull_ - off_balance).norm() / load;
}

std::int64_t SurfaceContinuum::StepMultiplications() const {
  // Both triangular solves and the right-hand side, three columns each.
  return 3 * (2 * factor_.nonzeros() + 2 * factor_.size());
}

}  // namespace hpdm
