#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <memory>

#include "engine/solver/compliance_solver.h"
#include "engine/solver/relaxation.h"

namespace hpdm {
namespace {

// A stiffness in blocks of three unknowns, one block for each control point.
class ScalarBlocks {
 public:
  explicit ScalarBlocks(const ScalarStiffness& K) : K_(K), diagonal_(K.diagonal()) {}
  Eigen::Index size() const { return K_.rows(); }
  Matrix3d Diagonal(Eigen::Index a) const { return diagonal_[a] * Matrix3d::Identity(); }
  Vector3d RowTimes(Eigen::Index a, const Points& U) const {
    Vector3d sum = Vector3d::Zero();
    for (ScalarStiffness::InnerIterator it(K_, a); it; ++it) {
      sum += it.value() * U.row(it.index()).transpose();
    }
    return sum;
  }

 private:
  ScalarStiffness K_;
  Eigen::VectorXd diagonal_;
};

class FullBlocks {
 public:
  explicit FullBlocks(const FullStiffness& K) : K_(K) {}
  Eigen::Index size() const { return K_.rows() / 3; }
  Matrix3d Diagonal(Eigen::Index a) const { return K_.block<3, 3>(3 * a, 3 * a); }
  Vector3d RowTimes(Eigen::Index a, const Points& U) const {
    const Eigen::Map<const Eigen::VectorXd> u(U.data(), U.size());
    return K_.middleCols<3>(3 * a).transpose() * u;  // symmetric; columns lie together in memory
  }

 private:
  FullStiffness K_;
};

// Minimises the augmented Lagrangian
//     1/2 U^T K U - sum_i f_i . (x_i - t_i) + kappa_i/2 |P_i (x_i - t_i)|^2
// one control point (three unknowns) at a time, with P_i = I for a grasp and n n^T for a press in
// contact. Every sweep ends with f_i <- f_i - kappa_i P_i (x_i - t_i). The local part C_loc f_i of
// x_i uses the new force:
//     f_i <- (I + kappa_i P_i C_loc P_i)^-1 (f_i - kappa_i P_i (b_i U - t_i)).
template <class Blocks>
class GaussSeidelRelaxation final : public Relaxation {
 public:
  template <class Stiffness>
  GaussSeidelRelaxation(const Stiffness& K, const GaussSeidelOptions& options)
      : K_(K),
        solver_(MakeComplianceSolver(K)),
        diagonal_(K_.size()),
        options_(options),
        load_(K_.size(), 3) {
    for (Eigen::Index a = 0; a < K_.size(); ++a) diagonal_[a] = K_.Diagonal(a).trace() / 3;
  }

  std::unique_ptr<Relaxation> Clone() const override {
    return std::make_unique<GaussSeidelRelaxation>(*this);
  }
  void Take(const Relaxation& other) override {
    *this = static_cast<const GaussSeidelRelaxation&>(other);
  }

  RelaxationResult DoRelax(const RelaxationInput& /*input*/, ContactConstraints* contacts,
                           Points* U) override {
    RelaxationResult result;
    if (contacts->size() == 0) {
      U->setZero();
      return result;
    }
    Start(contacts, *U);
    result.converged = false;
    while (!result.converged && result.iterations < options_.max_sweeps) {
      Sweep(*contacts, U);
      const double violation = UpdateForces(contacts);
      ++result.iterations;
      if (violation > options_.tolerance) continue;
      result.residual = Residual(*contacts, *U);
      result.converged = result.residual <= options_.tolerance;
    }
    result.residual = Residual(*contacts, *U);
    return result;
  }

  const LatticeCompliance* compliance() const override { return solver_.get(); }

 private:
  void Start(ContactConstraints* contacts, const Points& U) {
    largest_change_ = 0;
    for (int i = 0; i < contacts->size(); ++i) {
      ContactConstraints::Row& row = (*contacts)[i];
      row.force_W.setZero();
      const auto b = contacts->Weights().row(i);
      off_target_[i] = row.p_rest_W - row.target_W;
      largest_change_ = std::max(largest_change_, off_target_[i].norm());
      for (int d = 0; d < 3; ++d) off_target_[i][d] += b.dot(U.col(d));
      // Twice the contact's stiffness against its own control points alone, which exceeds that of
      // the whole lattice. The forces then converge about as fast as the sweeps.
      penalty_[i] = 2 / (b.array().square() / diagonal_.transpose().array()).sum();
      stiffness_[i] = PenaltyStiffness(row, penalty_[i]);
    }
  }

  // Returns (P / kappa + P C_loc P)^+, which is kappa P without local compliance.
  static Matrix3d PenaltyStiffness(const ContactConstraints::Row& row, double penalty) {
    const Matrix3d C = row.LocalCompliance();
    if (row.kind == ContactConstraints::RowKind::kGrasp) {
      return (Matrix3d::Identity() / penalty + C).inverse();
    }
    const Vector3d& n = row.normal_W;
    return n * n.transpose() / (1 / penalty + n.dot(C * n));
  }

  // Returns the force of the augmented Lagrangian on row i's point at the present U.
  Vector3d AugmentedForce(const ContactConstraints::Row& row, int i) const {
    const Vector3d force = stiffness_[i] * (row.force_W / penalty_[i] - off_target_[i]);
    const bool pulls =
        row.kind == ContactConstraints::RowKind::kPress && row.normal_W.dot(force) >= 0;
    return pulls ? Vector3d::Zero() : force;
  }

  void Sweep(const ContactConstraints& contacts, Points* U) {
    const auto weights = contacts.Weights();
    for (Eigen::Index a = 0; a < K_.size(); ++a) {
      Vector3d gradient = K_.RowTimes(a, *U);
      Matrix3d block = K_.Diagonal(a);
      for (int i = 0; i < contacts.size(); ++i) {
        const double w = weights(i, a);
        if (w == 0) continue;
        const Vector3d force = AugmentedForce(contacts[i], i);
        gradient -= w * force;
        const bool grasps = contacts[i].kind == ContactConstraints::RowKind::kGrasp;
        if (grasps || force.squaredNorm() > 0) block += w * w * stiffness_[i];
      }
      const Vector3d change = -(block.inverse() * gradient);
      U->row(a) += change.transpose();
      for (int i = 0; i < contacts.size(); ++i) off_target_[i] += weights(i, a) * change;
    }
  }

  // Raises the multipliers; returns the largest violation relative to the largest contact change.
  double UpdateForces(ContactConstraints* contacts) {
    double violation = 0;
    for (int i = 0; i < contacts->size(); ++i) {
      ContactConstraints::Row& row = (*contacts)[i];
      const Vector3d force = AugmentedForce(row, i);
      violation = std::max(violation, (force - row.force_W).norm() / penalty_[i]);
      row.force_W = force;
      if (row.indentation.indents()) stiffness_[i] = PenaltyStiffness(row, penalty_[i]);
    }
    return largest_change_ > 0 ? violation / largest_change_ : 0;
  }

  double Residual(const ContactConstraints& contacts, const Points& U) {
    load_.setZero();
    for (int i = 0; i < contacts.size(); ++i) {
      for (int d = 0; d < 3; ++d) {
        load_.col(d) += contacts[i].force_W[d] * contacts.Weights().row(i).transpose();
      }
    }
    const double load = load_.norm();
    for (Eigen::Index a = 0; a < K_.size(); ++a) load_.row(a) -= K_.RowTimes(a, U).transpose();
    return load > 0 ? load_.norm() / load : 0;
  }

  Blocks K_;
  Cloned<ComplianceSolver> solver_;
  Eigen::VectorXd diagonal_;  // n: mean over the three axes
  GaussSeidelOptions options_;
  Points load_;  // n x 3, N: B^T f, then B^T f - K U
  double largest_change_ = 0;
  std::array<Vector3d, kMaxContacts> off_target_;  // m: x_i - t_i, without the local part
  std::array<Matrix3d, kMaxContacts> stiffness_;   // N/m: penalty on off_target_
  std::array<double, kMaxContacts> penalty_{};
};

}  // namespace

std::unique_ptr<Relaxation> MakeGaussSeidelRelaxation(const ScalarStiffness& K,
                                                      const GaussSeidelOptions& options) {
  return std::make_unique<GaussSeidelRelaxation<ScalarBlocks>>(K, options);
}

std::unique_ptr<Relaxation> MakeGaussSeidelRelaxation(const FullStiffness& K,
                                                      const GaussSeidelOptions& options) {
  return std::make_unique<GaussSeidelRelaxation<FullBlocks>>(K, options);
}

}  // namespace hpdm
