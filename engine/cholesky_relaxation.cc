#include <Eigen/Cholesky>
#include <algorithm>

#include "engine/error.h"
#include "engine/relaxation.h"

namespace hpdm {
namespace {

constexpr int kMaxEquations = 3 * kMaxContacts;
using EquationMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor,
                                     kMaxEquations, kMaxEquations>;
using EquationVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxEquations, 1>;

// Solves in the contacts' compliance space W = B K^-1 B^T: a grasp row gives three equations, a
// pressing row one, along its normal.
class CholeskyRelaxation final : public Relaxation {
 public:
  explicit CholeskyRelaxation(const ScalarStiffness& K)
      : factor_(Eigen::MatrixXd(K)), response_(K.rows(), kMaxContacts) {
    if (factor_.info() != Eigen::Success) {
      throw InputError(
          "lattice stiffness is not positive definite; add an [[organ.support]] or raise alpha");
    }
  }

  RelaxationResult Relax(ContactSet* contacts, Points* U) override {
    const int m = contacts->size();
    RelaxationResult result;
    U->setZero();
    if (m == 0) return result;

    auto response = response_.leftCols(m);
    response = contacts->Weights().transpose();
    factor_.solveInPlace(response);
    compliance_.noalias() = contacts->Weights() * response;
    largest_change_ = 0;
    for (int i = 0; i < m; ++i) {
      const ContactSet::Row& row = (*contacts)[i];
      largest_change_ = std::max(largest_change_, (row.target_W - row.p_rest_W).norm());
    }

    // Presses that would be free at rest start inactive.
    for (int i = 0; i < m; ++i) {
      const ContactSet::Row& row = (*contacts)[i];
      active_[i] = row.kind == ContactSet::RowKind::kGrasp ||
                   row.normal_W.dot(row.target_W - row.p_rest_W) < 0;
    }
    // Active-set method: each round releases the presses that would pull and adds those that would
    // be pierced. The rounds are bounded; a cycle keeps the last feasible forces.
    constexpr int kMaxRounds = 2 * kMaxContacts;
    bool changed = true;
    while (changed && result.iterations < kMaxRounds) {
      ++result.iterations;
      result.regularised = SolveActive(contacts);
      changed = UpdateActiveSet(contacts);
    }
    result.converged = !changed;
    for (int i = 0; i < m; ++i) {
      for (int d = 0; d < 3; ++d) U->col(d) += (*contacts)[i].force_W[d] * response.col(i);
    }
    return result;
  }

 private:
  // Forces of the active rows so that their equations hold; inactive rows get none. True when the
  // equations are (nearly) dependent.
  bool SolveActive(ContactSet* contacts) {
    int equations = 0;
    for (int i = 0; i < contacts->size(); ++i) {
      ContactSet::Row& row = (*contacts)[i];
      row.force_W.setZero();
      if (!active_[i]) continue;
      if (row.kind == ContactSet::RowKind::kPress) {
        AddEquation(equations++, i, row.normal_W);
      } else {
        for (int d = 0; d < 3; ++d) AddEquation(equations++, i, Vector3d::Unit(d));
      }
    }
    if (equations == 0) return false;

    EquationMatrix matrix(equations, equations);
    EquationVector change(equations);
    for (int e = 0; e < equations; ++e) {
      for (int g = 0; g <= e; ++g) {
        matrix(e, g) = compliance_(equation_row_[e], equation_row_[g]) *
                       equation_axis_[e].dot(equation_axis_[g]);
        matrix(g, e) = matrix(e, g);
      }
      const ContactSet::Row& row = (*contacts)[equation_row_[e]];
      change[e] = equation_axis_[e].dot(row.target_W - row.p_rest_W);
    }
    // A pad compliance of 1e-9 of the softest contact: coincident contacts share their force, and
    // others move by one part in 1e9.
    const double pad = 1e-9 * matrix.diagonal().maxCoeff();
    matrix.diagonal().array() += pad;
    const Eigen::LDLT<EquationMatrix> factor(matrix);
    const EquationVector force = factor.solve(change);
    for (int e = 0; e < equations; ++e) {
      (*contacts)[equation_row_[e]].force_W += force[e] * equation_axis_[e];
    }
    return factor.vectorD().minCoeff() < 10 * pad;
  }

  bool UpdateActiveSet(ContactSet* contacts) {
    bool changed = false;
    for (int i = 0; i < contacts->size(); ++i) {
      const ContactSet::Row& row = (*contacts)[i];
      if (row.kind == ContactSet::RowKind::kGrasp) continue;
      if (active_[i]) {
        if (row.force_W.dot(row.normal_W) > 0) {
          active_[i] = false;
          changed = true;
        }
        continue;
      }
      Vector3d p = row.p_rest_W;
      for (int j = 0; j < contacts->size(); ++j) p += compliance_(i, j) * (*contacts)[j].force_W;
      const double depth = row.normal_W.dot(p - row.target_W);
      if (depth > 1e-9 * largest_change_) {  // round-off of the solve, in any unit
        active_[i] = true;
        changed = true;
      }
    }
    return changed;
  }

  void AddEquation(int e, int row, const Vector3d& axis) {
    equation_row_[e] = row;
    equation_axis_[e] = axis;
  }

  Eigen::LLT<Eigen::MatrixXd> factor_;
  Eigen::MatrixXd response_;  // n x kMaxContacts: K^-1 B^T
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxContacts,
                kMaxContacts>
      compliance_;             // m x m: W
  double largest_change_ = 0;  // m
  std::array<bool, kMaxContacts> active_{};
  std::array<int, kMaxEquations> equation_row_{};
  std::array<Vector3d, kMaxEquations> equation_axis_;
};

}  // namespace

std::unique_ptr<Relaxation> MakeCholeskyRelaxation(const ScalarStiffness& K) {
  return std::make_unique<CholeskyRelaxation>(K);
}

}  // namespace hpdm
