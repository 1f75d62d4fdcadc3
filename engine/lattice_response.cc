#include "engine/lattice_response.h"

#include <Eigen/Cholesky>

#include "engine/error.h"

namespace hpdm {
namespace {

using Factor = Eigen::LLT<Eigen::MatrixXd>;

// The unknowns of U as one vector (Points are row-major).
Eigen::Map<Eigen::VectorXd> AsVector(Points* U) { return {U->data(), U->size()}; }

// x, y and z respond alike and apart: one solve a contact row, whatever its equations.
class ScalarResponse final : public LatticeResponse {
 public:
  explicit ScalarResponse(const ScalarStiffness& K)
      : factor_(Eigen::MatrixXd(K)), response_(K.rows(), kMaxContacts) {
    if (factor_.info() != Eigen::Success) {
      throw InputError(
          "lattice stiffness is not positive definite; add an [[organ.support]] or raise alpha");
    }
  }

  void Respond(const ContactSet& contacts, ContactProblem* problem) override {
    auto response = response_.leftCols(contacts.size());
    response = contacts.Weights().transpose();
    factor_.solveInPlace(response);
    row_compliance_.noalias() = contacts.Weights() * response;
    for (int e = 0; e < problem->size(); ++e) {
      const ContactProblem::Equation& first = (*problem)[e];
      for (int g = 0; g <= e; ++g) {
        const ContactProblem::Equation& second = (*problem)[g];
        const double compliance =
            row_compliance_(first.row, second.row) * first.axis_W.dot(second.axis_W);
        problem->compliance()(e, g) = compliance;
        problem->compliance()(g, e) = compliance;
      }
    }
  }

  void Deform(const ContactProblem& problem, Points* U) const override {
    U->setZero();
    for (int e = 0; e < problem.size(); ++e) {
      const Vector3d force = problem.forces()[e] * problem[e].axis_W;
      for (int d = 0; d < 3; ++d) U->col(d) += force[d] * response_.col(problem[e].row);
    }
  }

  void Solve(Eigen::Ref<Eigen::MatrixXd> columns) const override {
    for (Eigen::Index c = 0; c < columns.cols(); ++c) {
      Eigen::Map<Points> loads(columns.col(c).data(), factor_.rows(), 3);
      loads = factor_.solve(loads).eval();
    }
  }

 private:
  Factor factor_;
  Eigen::MatrixXd response_;  // n x kMaxContacts: K^-1 B^T
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxContacts,
                kMaxContacts>
      row_compliance_;  // m x m: B K^-1 B^T
};

// The axes are coupled: 3n x 3n. A contact's row b has few entries, one for each function that is
// not zero there (27 of quadratic splines), so a product with the columns of K^-1 that they name is
// several times cheaper than two triangular solves; K^-1 costs six times the factorisation, once.
class FullResponse final : public LatticeResponse {
 public:
  explicit FullResponse(const FullStiffness& K)
      : n_(K.rows() / 3), response_(K.rows(), ContactProblem::kMaxEquations) {
    const Factor factor(K);
    if (factor.info() != Eigen::Success) {
      throw InputError(
          "lattice stiffness is not positive definite; add an [[organ.support]] or use fewer "
          "[organ.lattice] cells");
    }
    inverse_ = factor.solve(Eigen::MatrixXd::Identity(K.rows(), K.rows()));
  }

  void Respond(const ContactSet& contacts, ContactProblem* problem) override {
    const int equations = problem->size();
    for (int e = 0; e < equations; ++e) {
      const auto& [row, axis, unilateral] = (*problem)[e];
      auto response = response_.col(e);
      response.setZero();
      for (Eigen::Index a = 0; a < n_; ++a) {
        const double weight = contacts.Weights()(row, a);
        if (weight == 0) continue;
        for (int d = 0; d < 3; ++d) {
          if (axis[d] != 0) response += weight * axis[d] * inverse_.col(3 * a + d);
        }
      }
    }
    FillCompliance(contacts, response_, problem);
  }

  void Deform(const ContactProblem& problem, Points* U) const override {
    AsVector(U).noalias() = response_.leftCols(problem.size()) * problem.forces();
  }

  void Solve(Eigen::Ref<Eigen::MatrixXd> columns) const override {
    columns = (inverse_ * columns).eval();
  }

 private:
  Eigen::Index n_;
  Eigen::MatrixXd inverse_;   // 3n x 3n
  Eigen::MatrixXd response_;  // 3n x kMaxEquations
};

}  // namespace

void FillCompliance(const ContactSet& contacts, const Eigen::Ref<const Eigen::MatrixXd>& response,
                    ContactProblem* problem) {
  for (int g = 0; g < problem->size(); ++g) {
    const Eigen::Map<const Points> U(response.col(g).data(), response.rows() / 3, 3);
    Vector3d moved = Vector3d::Zero();
    int at = -1;  // the equations of one contact follow each other
    for (int e = 0; e < problem->size(); ++e) {
      const auto& [row, axis, unilateral] = (*problem)[e];
      if (row != at) moved.noalias() = (contacts.Weights().row(row) * U).transpose();
      at = row;
      problem->compliance()(e, g) = axis.dot(moved);
    }
  }
}

std::unique_ptr<LatticeResponse> MakeLatticeResponse(const ScalarStiffness& K) {
  return std::make_unique<ScalarResponse>(K);
}

std::unique_ptr<LatticeResponse> MakeLatticeResponse(const FullStiffness& K) {
  return std::make_unique<FullResponse>(K);
}

}  // namespace hpdm
