#include <Eigen/LU>
#include <algorithm>
#include <array>

#include "engine/relaxation.h"

namespace hpdm {
namespace {

// Minimises the augmented Lagrangian
//     1/2 U^T K U - sum_i f_i . (x_i - t_i) + kappa_i/2 |P_i (x_i - t_i)|^2
// one control point (three unknowns) at a time, with P_i = I for a grasp and n n^T for a press in
// contact; after every sweep f_i <- f_i - kappa_i P_i (x_i - t_i).
class GaussSeidelRelaxation final : public Relaxation {
 public:
  GaussSeidelRelaxation(const ScalarStiffness& K, const GaussSeidelOptions& options)
      : K_(K), diagonal_(K.diagonal()), options_(options), pull_(K.rows(), 3), load_(K.rows(), 3) {}

  RelaxationResult Relax(ContactSet* contacts, Points* U) override {
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

 private:
  void Start(ContactSet* contacts, const Points& U) {
    largest_change_ = 0;
    for (int i = 0; i < contacts->size(); ++i) {
      ContactSet::Row& row = (*contacts)[i];
      row.force_W.setZero();
      const auto b = contacts->Weights().row(i);
      off_target_[i] = row.p_rest_W - row.target_W;
      largest_change_ = std::max(largest_change_, off_target_[i].norm());
      for (int d = 0; d < 3; ++d) off_target_[i][d] += b.dot(U.col(d));
      // Twice the contact's stiffness against its own control points alone, which is above the
      // stiffness of the whole lattice: the forces then converge about as fast as the sweeps do.
      penalty_[i] = 2 / (b.array().square() / diagonal_.transpose().array()).sum();
    }
  }

  // Force that the augmented Lagrangian puts on row i's point now.
  Vector3d AugmentedForce(const ContactSet::Row& row, int i) const {
    if (row.kind == ContactSet::RowKind::kGrasp) return row.force_W - penalty_[i] * off_target_[i];
    const double f_n =
        -row.normal_W.dot(row.force_W) + penalty_[i] * row.normal_W.dot(off_target_[i]);
    return f_n > 0 ? Vector3d(-f_n * row.normal_W) : Vector3d::Zero();
  }

  void Sweep(const ContactSet& contacts, Points* U) {
    const auto weights = contacts.Weights();
    for (Eigen::Index a = 0; a < K_.rows(); ++a) {
      Vector3d gradient = Vector3d::Zero();
      for (ScalarStiffness::InnerIterator it(K_, a); it; ++it) {
        gradient += it.value() * U->row(it.index()).transpose();
      }
      Matrix3d block = diagonal_[a] * Matrix3d::Identity();
      for (int i = 0; i < contacts.size(); ++i) {
        const double w = weights(i, a);
        if (w == 0) continue;
        const Vector3d force = AugmentedForce(contacts[i], i);
        gradient -= w * force;
        if (contacts[i].kind == ContactSet::RowKind::kGrasp) {
          block.diagonal().array() += penalty_[i] * w * w;
        } else if (force.squaredNorm() > 0) {
          const Vector3d& n = contacts[i].normal_W;
          block += penalty_[i] * w * w * n * n.transpose();
        }
      }
      const Vector3d change = -(block.inverse() * gradient);
      U->row(a) += change.transpose();
      for (int i = 0; i < contacts.size(); ++i) off_target_[i] += weights(i, a) * change;
    }
  }

  // Raises the multipliers; returns the largest violation relative to the largest contact change.
  double UpdateForces(ContactSet* contacts) {
    double violation = 0;
    for (int i = 0; i < contacts->size(); ++i) {
      ContactSet::Row& row = (*contacts)[i];
      const Vector3d force = AugmentedForce(row, i);
      violation = std::max(violation, (force - row.force_W).norm() / penalty_[i]);
      row.force_W = force;
    }
    return largest_change_ > 0 ? violation / largest_change_ : 0;
  }

  double Residual(const ContactSet& contacts, const Points& U) {
    load_.setZero();
    for (int i = 0; i < contacts.size(); ++i) {
      for (int d = 0; d < 3; ++d) {
        load_.col(d) += contacts[i].force_W[d] * contacts.Weights().row(i).transpose();
      }
    }
    pull_.noalias() = K_ * U;
    const double load = load_.norm();
    return load > 0 ? (pull_ - load_).norm() / load : 0;
  }

  ScalarStiffness K_;
  Eigen::VectorXd diagonal_;
  GaussSeidelOptions options_;
  Points pull_;  // n x 3: K U
  Points load_;  // n x 3: B^T f
  double largest_change_ = 0;
  std::array<Vector3d, kMaxContacts> off_target_;  // x_i - t_i
  std::array<double, kMaxContacts> penalty_{};
};

}  // namespace

std::unique_ptr<Relaxation> MakeGaussSeidelRelaxation(const ScalarStiffness& K,
                                                      const GaussSeidelOptions& options) {
  return std::make_unique<GaussSeidelRelaxation>(K, options);
}

}  // namespace hpdm
