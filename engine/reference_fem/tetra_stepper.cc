#include "engine/reference_fem/tetra_stepper.h"

#include <Eigen/LU>
#include <cmath>

#include "engine/base/check.h"
#include "engine/base/error.h"

namespace hpdm {
namespace {

constexpr std::size_t kMaxPairs = 20;
constexpr int kMaxConjugateGradients = 2000;
constexpr double kForcing = 1e-2;  // residual of a tangent's solve over its right-hand side
constexpr double kArmijo = 1e-4;
constexpr int kMostHalvings = 20;

}  // namespace

/// The prescribed rows A of a step, with the inverse H of some stiffness. Directions that keep the
/// rows, and the least one that changes them, in the norm of H^-1.
class TetraStepper::Patches {
 public:
  Patches(const std::vector<TetraRow>& rows, Eigen::Index nodes,
          const std::function<Points(const Points&)>& inverse)
      : rows_(rows), inverse_(inverse) {
    const auto size = static_cast<Eigen::Index>(3 * rows.size());
    Eigen::MatrixXd W(size, size);
    for (Eigen::Index column = 0; column < size; ++column) {
      Points unit = Points::Zero(static_cast<Eigen::Index>(rows.size()), 3);
      unit.data()[column] = 1;
      response_.push_back(inverse_(Spread(unit, nodes)));
      const Points moved = Of(response_.back());
      W.col(column) = Eigen::Map<const Eigen::VectorXd>(moved.data(), size);
    }
    compliance_.compute(W);
    Eigen::MatrixXd weights = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rows.size()), nodes);
    for (std::size_t l = 0; l < rows.size(); ++l) {
      for (const auto& [node, weight] : rows[l]) {
        weights(static_cast<Eigen::Index>(l), node) += weight;
      }
    }
    gram_.compute(weights * weights.transpose());
  }

  /// A u, L x 3.
  Points Of(const Points& u) const { return ApplyRows(rows_, u); }
  /// A^T f.
  Points Spread(const Points& forces, Eigen::Index nodes) const {
    Points spread = Points::Zero(nodes, 3);
    for (std::size_t l = 0; l < rows_.size(); ++l) {
      for (const auto& [node, weight] : rows_[l]) {
        spread.row(node) += weight * forces.row(static_cast<Eigen::Index>(l));
      }
    }
    return spread;
  }
  /// The forces f at the patches for which A^T f is nearest to `gradient`, L x 3.
  Points Balancing(const Points& gradient) const { return gram_.solve(Of(gradient)); }
  /// (A H A^T)^-1 moved, L x 3.
  Points Force(const Points& moved) const {
    Points force(moved.rows(), 3);
    Eigen::Map<Eigen::VectorXd>(force.data(), force.size()) =
        compliance_.solve(Eigen::Map<const Eigen::VectorXd>(moved.data(), moved.size()));
    return force;
  }
  /// H A^T (A H A^T)^-1 moved.
  Points Lift(const Points& moved) const {
    const Points force = Force(moved);
    Points u = Points::Zero(response_.front().rows(), 3);
    for (std::size_t c = 0; c < response_.size(); ++c) u += force.data()[c] * response_[c];
    return u;
  }
  /// H b without its part along the rows: A of it is zero.
  Points Keep(const Points& b) const {
    const Points free = inverse_(b);
    return free - Lift(Of(free));
  }

 private:
  const std::vector<TetraRow>& rows_;
  std::function<Points(const Points&)> inverse_;
  std::vector<Points> response_;
  Eigen::LDLT<Eigen::MatrixXd> compliance_;
  Eigen::LDLT<Eigen::MatrixXd> gram_;
};

SteppedBody Stepped(const TetraBody& body) {
  SteppedBody stepped;
  stepped.mesh = &body.mesh();
  stepped.gradient = [&body](const Points& u, Points* gradient) { *gradient = body.Gradient(u); };
  stepped.tangent = [&body](const Points& u, Points* gradient, BlockMatrix* K) {
    *gradient = body.Gradient(u);
    body.SetHessian(u, true, K);
  };
  stepped.energy = [&body](const Points& u) { return body.Energy(u); };
  stepped.linear = body.law() == TetraLaw::kSmallStrain;
  return stepped;
}

SteppedBody Stepped(const CorotationalBody& body) {
  SteppedBody stepped;
  stepped.mesh = &body.mesh();
  const auto tangent = [&body](const Points& u, Points* gradient, BlockMatrix* K) {
    body.Evaluate(u, gradient, K);
    *gradient = -*gradient;
  };
  stepped.gradient = [&body, tangent](const Points& u, Points* gradient) {
    BlockMatrix K(body.mesh().elements, static_cast<int>(u.rows()));
    tangent(u, gradient, &K);
  };
  stepped.tangent = tangent;
  return stepped;
}

TetraStepper::TetraStepper(SteppedBody body, const BlockMatrix& springs, StepMethod method,
                           int most_rounds)
    : body_(std::move(body)),
      springs_(springs),
      method_(method),
      most_rounds_(most_rounds),
      K_(springs) {
  u_ = Points::Zero(springs.rows(), 3);
  inverse_diagonal_.resize(static_cast<std::size_t>(springs.rows()));
  if (method_ != StepMethod::kConjugateGradients) factor_.analyzePattern(LowerTriangle(K_));
  Points gradient;
  Linearise(&gradient);
  if (!Factorise()) {
    throw InputError("tetrahedra: the stiffness is singular; hold the body with a support");
  }
}

std::size_t TetraStepper::factor_entries() const {
  if (method_ == StepMethod::kConjugateGradients) return 0;
  return static_cast<std::size_t>(factor_.matrixL().nestedExpression().nonZeros());
}

Points TetraStepper::SolveAtRest(const Points& b) const { return Inverse(b); }

// Sets the tangent at u_ and the gradient there.
void TetraStepper::Linearise(Points* gradient) {
  body_.tangent(u_, gradient, &K_);
  K_.Add(springs_);
  Points of_springs;
  springs_.Multiply(u_, &of_springs);
  *gradient += of_springs;
}

// Prepares Inverse() for the tangent.
bool TetraStepper::Factorise() {
  if (method_ != StepMethod::kConjugateGradients) {
    factor_.factorize(LowerTriangle(K_));
    return factor_.info() == Eigen::Success;
  }
  for (int i = 0; i < K_.rows(); ++i) {
    inverse_diagonal_[static_cast<std::size_t>(i)] = K_.At(i, i).inverse();
  }
  return true;
}

// Applies the factor, or with conjugate gradients the inverse of the diagonal blocks.
Points TetraStepper::Inverse(const Points& b) const {
  Points x(b.rows(), 3);
  if (method_ == StepMethod::kConjugateGradients) {
    for (Eigen::Index i = 0; i < b.rows(); ++i) {
      x.row(i) = b.row(i) * inverse_diagonal_[static_cast<std::size_t>(i)].transpose();
    }
    return x;
  }
  Eigen::Map<Eigen::VectorXd>(x.data(), x.size()) =
      factor_.solve(Eigen::Map<const Eigen::VectorXd>(b.data(), b.size()));
  return x;
}

Points TetraStepper::Gradient(const Points& u) const {
  Points gradient, of_springs;
  body_.gradient(u, &gradient);
  springs_.Multiply(u, &of_springs);
  return gradient + of_springs;
}

double TetraStepper::Potential(const Points& u) const {
  Points of_springs;
  springs_.Multiply(u, &of_springs);
  return body_.energy(u) + Dot(u, of_springs) / 2;
}

// Returns -H gradient within the directions that keep the patches; H from L-BFGS.
Points TetraStepper::Direction(const Patches& patches, const Points& gradient) const {
  Points q = gradient;
  std::vector<double> a(pairs_.size());
  for (std::size_t k = pairs_.size(); k-- > 0;) {
    a[k] = pairs_[k].rho * Dot(pairs_[k].s, q);
    q -= a[k] * pairs_[k].y;
  }
  Points direction = patches.Keep(q);
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    direction += (a[k] - pairs_[k].rho * Dot(pairs_[k].y, direction)) * pairs_[k].s;
  }
  return -direction;
}

// Solves K x = residual within the directions that keep the patches (projected conjugate gradients).
Points TetraStepper::ByConjugateGradients(const Patches& patches, const Points& residual) const {
  Points x = Points::Zero(residual.rows(), 3), r = residual, Kp;
  Points z = patches.Keep(r), p = z;
  double rz = Dot(r, z);
  const double goal = kForcing * kForcing * rz;
  for (int i = 0; i < kMaxConjugateGradients && rz > goal; ++i) {
    K_.Multiply(p, &Kp);
    const double curvature = Dot(p, Kp);
    if (!(curvature > 0)) break;
    x += rz / curvature * p;
    r -= rz / curvature * Kp;
    z = patches.Keep(r);
    const double next = Dot(r, z);
    p = z + next / rz * p;
    rz = next;
  }
  return x;
}

// Returns the part of the step that lowers the energy enough.
double TetraStepper::Shorten(const Points& step, const Points& gradient) const {
  if (!body_.energy || body_.linear) return 1;
  const double slope = Dot(gradient, step), before = Potential(u_);
  double length = 1;
  for (int h = 0; h < kMostHalvings; ++h, length /= 2) {
    const double after = Potential(u_ + length * step);
    if (after <= before + kArmijo * length * slope + 1e-13 * std::abs(before)) break;
  }
  return length;
}

TetraStepper::Result TetraStepper::MoveTo(const std::vector<TetraRow>& patches,
                                          const Points& displacements) {
  const auto nodes = static_cast<Eigen::Index>(K_.rows());
  const auto inverse = [this](const Points& b) { return Inverse(b); };
  const bool quasi = method_ == StepMethod::kQuasiNewton;
  Result result;
  if (body_.linear) {
    HPDM_CHECK(quasi);
    const Patches rows(patches, nodes, inverse);
    u_ = rows.Lift(displacements);
    forces_ = rows.Force(displacements);
    return {1, true};
  }
  pairs_.clear();
  std::optional<Patches> rows;
  Points gradient;
  for (; result.rounds < most_rounds_; ++result.rounds) {
    if (!quasi) {
      Linearise(&gradient);
      if (!Factorise()) return result;
    }
    if (!quasi || !rows) rows.emplace(patches, nodes, inverse);
    const Points gap = displacements - rows->Of(u_);
    if (gap.norm() > 1e-9 * displacements.norm()) {
      Points lift = rows->Lift(gap);
      if (!quasi) {  // the gap closes and the residual shrinks in one step
        Points of_lift;
        K_.Multiply(lift, &of_lift);
        const Points residual = -gradient - of_lift;
        lift += method_ == StepMethod::kNewton ? rows->Keep(residual)
                                               : ByConjugateGradients(*rows, residual);
      }
      u_ += lift;
      if (quasi) gradient = Gradient(u_);
      continue;
    }
    if (quasi && gradient.size() == 0) gradient = Gradient(u_);
    forces_ = rows->Balancing(gradient);
    const Points at_patches = rows->Spread(forces_, nodes);
    if ((gradient - at_patches).norm() <= kTolerance * at_patches.norm()) {
      result.converged = true;
      return result;
    }
    const Points step = quasi                            ? Direction(*rows, gradient)
                        : method_ == StepMethod::kNewton ? Points(-rows->Keep(gradient))
                                                         : ByConjugateGradients(*rows, -gradient);
    const Points way = Shorten(step, gradient) * step;
    u_ += way;
    if (!quasi) continue;
    const Points next = Gradient(u_);
    const Points change = next - gradient;
    gradient = next;
    const double curvature = Dot(way, change);
    if (!(curvature > 0)) continue;
    if (pairs_.size() == kMaxPairs) pairs_.erase(pairs_.begin());
    pairs_.push_back({way, change, 1 / curvature});
  }
  return result;
}

}  // namespace hpdm
