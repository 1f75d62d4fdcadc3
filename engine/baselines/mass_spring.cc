#include "engine/baselines/mass_spring.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/check.h"

namespace hpdm {
namespace {

// Returns the largest eigenvalue of M^-1 K by power iteration from a fixed start; K is given by its
// product with a vector. The Rayleigh quotient's error is the square of the vector's, so 300 rounds
// give well below 1 % although a mesh's upper eigenvalues lie close together.
template <typename Product>
double LargestEigenvalue(const Eigen::VectorXd& mass, Product product) {
  Points x(mass.size(), 3), Kx(mass.size(), 3);
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    x.data()[i] = std::sin(1.0 + 7.31 * static_cast<double>(i) * static_cast<double>(i % 97 + 1));
  }
  double eigenvalue = 0;
  for (int round = 0; round < 300; ++round) {
    product(x, &Kx);
    eigenvalue = x.cwiseProduct(Kx).sum() / x.cwiseProduct(mass.asDiagonal() * x).sum();
    x = mass.cwiseInverse().asDiagonal() * Kx;
    const double size = x.norm();
    if (size == 0) return 0;
    x /= size;
  }
  return eigenvalue;
}

double StableStep(double largest_eigenvalue) {
  return largest_eigenvalue > 0 ? 2 / std::sqrt(largest_eigenvalue)
                                : std::numeric_limits<double>::infinity();
}

}  // namespace

MassSpringOptions MassSpringOf(const MaterialOptions& material, double thickness,
                               double time_step) {
  const double modulus = material.young / (1 - material.poisson * material.poisson);
  MassSpringOptions options;
  options.alpha = 3.2 * modulus;
  options.home = 0.32 * modulus / (thickness * thickness);
  options.density = material.density;
  options.time_step = time_step;
  return options;
}

MassSpring::MassSpring(const SurfaceMesh& rest, const Eigen::VectorXd& ground_springs,
                       const MassSpringOptions& options, const std::string& name)
    : MassSpring(rest, MeasureSkin(rest, name), ground_springs, options) {}

MassSpring::MassSpring(const SurfaceMesh& rest, const Skin& skin,
                       const Eigen::VectorXd& ground_springs, const MassSpringOptions& options)
    : options_(options),
      rest_(rest.vertices),
      mass_(options.density * skin.Volumes()),
      ground_(ground_springs + options.home * skin.Volumes()),
      springs_(
          SurfaceSprings(rest, options.alpha * skin.thickness, options.shear, options.flexion)),
      p_(rest_),
      v_(Points::Zero(rest_.rows(), 3)),
      force_(v_),
      rows_(rest_.rows()) {
  HPDM_CHECK(ground_springs.size() == rest_.rows() && options.time_step > 0);
  const double needed = std::ceil(options.time_step / (kSafety * SafeSubstep()));
  substeps_ = options.substeps > 0 ? options.substeps : std::max(1, static_cast<int>(needed));
  h_ = options.time_step / substeps_;
  effective_mass_ = (1 + h_ * options.damping) * mass_ + h_ * h_ * ground_;
}

void MassSpring::Reset(const Points& u) {
  p_ = rest_ + u;
  v_.setZero();
}

void MassSpring::SpringForces(const Points& p, Points* forces) const {
  forces->setZero();
  for (const Spring& spring : springs_) {
    const Vector3d l = p.row(spring.a) - p.row(spring.b);
    const double length = l.norm();
    // Two masses in one place have no direction of force.
    if (length < 1e-9 * spring.length) continue;
    const Vector3d force = -spring.stiffness * (1 - spring.length / length) * l;
    forces->row(spring.a) += force.transpose();
    forces->row(spring.b) -= force.transpose();
  }
}

double MassSpring::SpringEnergy(const Points& p) const {
  double energy = 0;
  for (const Spring& spring : springs_) {
    const double stretch = (p.row(spring.a) - p.row(spring.b)).norm() - spring.length;
    energy += spring.stiffness / 2 * stretch * stretch;
  }
  return energy;
}

Points MassSpring::RestoringForces(const Points& u) const {
  Points forces(u.rows(), 3);
  SpringForces(rest_ + u, &forces);
  return ground_.asDiagonal() * u - forces;
}

double MassSpring::StoredEnergy(const Points& u) const {
  return SpringEnergy(rest_ + u) + u.cwiseProduct(ground_.asDiagonal() * u).sum() / 2;
}

double MassSpring::StableSubstepAtRest() const {
  return StableStep(LargestEigenvalue(mass_, [this](const Points& x, Points* Kx) {
    Kx->setZero();
    for (const Spring& spring : springs_) {
      const Vector3d d = (rest_.row(spring.a) - rest_.row(spring.b)) / spring.length;
      const Vector3d pull =
          spring.stiffness * d.dot(Vector3d(x.row(spring.a) - x.row(spring.b))) * d;
      Kx->row(spring.a) += pull.transpose();
      Kx->row(spring.b) -= pull.transpose();
    }
  }));
}

double MassSpring::SafeSubstep() const {
  return StableStep(LargestEigenvalue(mass_, [this](const Points& x, Points* Kx) {
    Kx->setZero();
    for (const Spring& spring : springs_) {
      const Vector3d pull = spring.stiffness * Vector3d(x.row(spring.a) - x.row(spring.b));
      Kx->row(spring.a) += pull.transpose();
      Kx->row(spring.b) -= pull.transpose();
    }
  }));
}

RelaxationResult MassSpring::DoRelax(const RelaxationInput& /*input*/, ContactConstraints* contacts,
                                     Points* U) {
  RelaxationResult result;
  const int m = contacts->size();
  rows_.Gather(*contacts);
  compliance_.resize(m, m);
  for (int i = 0; i < m; ++i) {
    force_sum_[i].setZero();
    start_W_[i] = (*contacts)[i].p_rest_W + rows_.Sum(i, p_) - rows_.Sum(i, rest_);
    for (int j = 0; j <= i; ++j) {
      // Both rows ascend by vertex.
      double sum = 0;
      const ContactRows::Entry* b = rows_.begin(j);
      for (const ContactRows::Entry* a = rows_.begin(i); a != rows_.end(i); ++a) {
        while (b != rows_.end(j) && b->vertex < a->vertex) ++b;
        if (b == rows_.end(j)) break;
        if (b->vertex == a->vertex) sum += a->weight * b->weight / effective_mass_[a->vertex];
      }
      compliance_(i, j) = compliance_(j, i) = h_ * h_ * sum;
    }
  }
  for (int s = 1; s <= substeps_; ++s) {
    Substep(static_cast<double>(s) / substeps_, &result, contacts);
  }
  for (int i = 0; i < m; ++i) (*contacts)[i].force_W = force_sum_[i] / substeps_;
  result.residual = StaticResidual(*contacts);
  if (m == 0 && v_.isZero(kStill / options_.time_step) && (p_ - rest_).isZero(kStill)) {
    p_ = rest_;
    v_.setZero();
  }
  *U = p_ - rest_;
  if (!p_.allFinite()) {  // the caller reports it; the next step starts at rest
    result.converged = false;
    p_ = rest_;
    v_.setZero();
  }
  return result;
}

void MassSpring::Substep(double share, RelaxationResult* result, ContactConstraints* contacts) {
  SpringForces(p_, &force_);
  for (Eigen::Index v = 0; v < p_.rows(); ++v) {
    v_.row(v) =
        (mass_[v] * v_.row(v) + h_ * (force_.row(v) - ground_[v] * (p_.row(v) - rest_.row(v)))) /
        effective_mass_[v];
  }
  if (contacts->size() > 0) SolveContacts(share, result, contacts);
  p_ += h_ * v_;
}

void MassSpring::SolveContacts(double share, RelaxationResult* result,
                               ContactConstraints* contacts) {
  const int m = contacts->size();
  for (int i = 0; i < m; ++i) {
    const ContactConstraints::Row& row = (*contacts)[i];
    p_free_W_[i] = row.p_rest_W + rows_.Sum(i, p_) - rows_.Sum(i, rest_) + h_ * rows_.Sum(i, v_);
    const Vector3d way = row.target_W - start_W_[i];
    const bool moves = row.kind == ContactConstraints::RowKind::kGrasp || row.normal_W.dot(way) < 0;
    targets_W_[i] = moves ? Vector3d(start_W_[i] + share * way) : row.target_W;
  }
  const RelaxationResult outcome =
      SolveContactForces(compliance_, p_free_W_, targets_W_, &contact_solver_, contacts);
  result->iterations += outcome.iterations;
  result->converged = result->converged && outcome.converged;
  result->regularised = result->regularised || outcome.regularised;
  for (int i = 0; i < m; ++i) {
    const Vector3d& force = (*contacts)[i].force_W;
    force_sum_[i] += force;
    for (const ContactRows::Entry* e = rows_.begin(i); e != rows_.end(i); ++e) {
      v_.row(e->vertex) += h_ * e->weight / effective_mass_[e->vertex] * force.transpose();
    }
  }
}

double MassSpring::StaticResidual(const ContactConstraints& contacts) {
  SpringForces(p_, &force_);
  force_ -= ground_.asDiagonal() * (p_ - rest_);
  // The loads are summed for their norm, since rows may share vertices.
  double load2 = 0;
  for (int i = 0; i < contacts.size(); ++i) {
    for (const ContactRows::Entry* e = rows_.begin(i); e != rows_.end(i); ++e) {
      force_.row(e->vertex) += e->weight * contacts[i].force_W.transpose();
    }
    for (int j = 0; j < contacts.size(); ++j) {
      double overlap = 0;
      const ContactRows::Entry* b = rows_.begin(j);
      for (const ContactRows::Entry* a = rows_.begin(i); a != rows_.end(i); ++a) {
        while (b != rows_.end(j) && b->vertex < a->vertex) ++b;
        if (b == rows_.end(j)) break;
        if (b->vertex == a->vertex) overlap += a->weight * b->weight;
      }
      load2 += overlap * contacts[i].force_W.dot(contacts[j].force_W);
    }
  }
  return load2 == 0 ? 0 : force_.norm() / std::sqrt(load2);
}

}  // namespace hpdm
