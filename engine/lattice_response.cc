#include "engine/lattice_response.h"

#include <Eigen/Cholesky>
#include <string>

#include "engine/error.h"

namespace hpdm {
namespace {

// The unknowns of U as one vector (Points are row-major).
Eigen::Map<Eigen::VectorXd> AsVector(Points* U) { return {U->data(), U->size()}; }

// x, y and z respond alike and apart: one column a contact row, whatever its equations.
class ScalarResponse final : public LatticeResponse {
 public:
  explicit ScalarResponse(const ScalarStiffness& K)
      : inverse_(InverseStiffness(Eigen::MatrixXd(K), "add an [[organ.support]] or raise alpha")),
        response_(K.rows(), kMaxContacts) {}

  void Respond(const ContactSet& contacts, ContactProblem* problem) override {
    for (int i = 0; i < contacts.size(); ++i) {
      auto response = response_.col(i);
      response.setZero();
      for (Eigen::Index a = 0; a < inverse_.rows(); ++a) {
        const double weight = contacts.Weights()(i, a);
        if (weight != 0) response += weight * inverse_.col(a);
      }
    }
    row_compliance_.noalias() = contacts.Weights() * response_.leftCols(contacts.size());
    for (int e = 0; e < problem->size(); ++e) {
      const ContactProblem::Equation& first = (*problem)[e];
      for (int g = 0; g < problem->size(); ++g) {
        const ContactProblem::Equation& second = (*problem)[g];
        problem->compliance()(e, g) =
            row_compliance_(first.row, second.row) * first.axis_W.dot(second.force_W);
      }
    }
  }

  void Deform(const ContactProblem& problem, Points* U) const override {
    U->setZero();
    for (int e = 0; e < problem.size(); ++e) {
      const Vector3d force = problem.forces()[e] * problem[e].force_W;
      for (int d = 0; d < 3; ++d) U->col(d) += force[d] * response_.col(problem[e].row);
    }
  }

  void Solve(Eigen::Ref<Eigen::MatrixXd> columns) const override {
    for (Eigen::Index c = 0; c < columns.cols(); ++c) {
      Eigen::Map<Points> loads(columns.col(c).data(), inverse_.rows(), 3);
      loads = (inverse_ * loads).eval();
    }
  }

  void RespondTo(const SparseRow& b, Eigen::Ref<Eigen::MatrixXd> response) const override {
    response.setZero();
    for (std::size_t i = 0; i < b.control_points.size(); ++i) {
      for (Eigen::Index c = 0; c < inverse_.rows(); ++c) {
        const double moved = b.weights[i] * inverse_(c, b.control_points[i]);
        for (int d = 0; d < 3; ++d) response(3 * c + d, d) += moved;
      }
    }
  }

  Matrix3d PointCompliance(const SparseRow& b) const override {
    double sum = 0;
    for (std::size_t i = 0; i < b.control_points.size(); ++i) {
      for (std::size_t j = 0; j < b.control_points.size(); ++j) {
        sum += b.weights[i] * b.weights[j] * inverse_(b.control_points[j], b.control_points[i]);
      }
    }
    return sum * Matrix3d::Identity();
  }

 private:
  Eigen::MatrixXd inverse_;   // n x n
  Eigen::MatrixXd response_;  // n x kMaxContacts: K^-1 B^T
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxContacts,
                kMaxContacts>
      row_compliance_;  // m x m: B K^-1 B^T
};

// The axes are coupled: 3n x 3n.
class FullResponse final : public LatticeResponse {
 public:
  explicit FullResponse(const FullStiffness& K)
      : n_(K.rows() / 3),
        inverse_(InverseStiffness(
            K, "add an [[organ.support]], use fewer cells, a lower degree or a lower poisson")),
        response_(K.rows(), ContactProblem::kMaxEquations) {}

  void Respond(const ContactSet& contacts, ContactProblem* problem) override {
    const int equations = problem->size();
    for (int e = 0; e < equations; ++e) {
      const auto& [row, axis, force, unilateral] = (*problem)[e];
      auto response = response_.col(e);
      response.setZero();
      for (Eigen::Index a = 0; a < n_; ++a) {
        const double weight = contacts.Weights()(row, a);
        if (weight == 0) continue;
        for (int d = 0; d < 3; ++d) {
          if (force[d] != 0) response += weight * force[d] * inverse_.col(3 * a + d);
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

  void RespondTo(const SparseRow& b, Eigen::Ref<Eigen::MatrixXd> response) const override {
    response.setZero();
    for (std::size_t i = 0; i < b.control_points.size(); ++i) {
      response += b.weights[i] * inverse_.middleCols<3>(3 * b.control_points[i]);
    }
  }

  Matrix3d PointCompliance(const SparseRow& b) const override { return PointBlock(inverse_, b); }

 private:
  Eigen::Index n_;
  Eigen::MatrixXd inverse_;   // 3n x 3n
  Eigen::MatrixXd response_;  // 3n x kMaxEquations
};

}  // namespace

Matrix3d PointBlock(const Eigen::MatrixXd& inverse, const SparseRow& b) {
  Matrix3d sum = Matrix3d::Zero();
  for (std::size_t i = 0; i < b.control_points.size(); ++i) {
    Matrix3d row = Matrix3d::Zero();
    for (std::size_t j = 0; j < b.control_points.size(); ++j) {
      row += b.weights[j] * inverse.block<3, 3>(3 * b.control_points[j], 3 * b.control_points[i]);
    }
    sum += b.weights[i] * row;
  }
  return (sum + sum.transpose()) / 2;
}

Eigen::MatrixXd InverseStiffness(const Eigen::Ref<const Eigen::MatrixXd>& K, const char* remedy) {
  // Functions with little tissue have little stiffness; with a unit diagonal they do not look like
  // motions without any.
  const Eigen::VectorXd scale = K.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LLT<Eigen::MatrixXd> factor(scale.asDiagonal() * K * scale.asDiagonal());
  // A motion that nothing holds leaves round-off, some 1e-18; a held Bernstein lattice of degree
  // (20, 2, 2), whose functions are nearly dependent, 4e-15.
  constexpr double kLeast = 1e-15;
  if (factor.info() != Eigen::Success || !(factor.rcond() > kLeast)) {
    throw InputError(std::string("lattice stiffness is not positive definite; ") + remedy);
  }
  return scale.asDiagonal() * factor.solve(Eigen::MatrixXd(scale.asDiagonal()));
}

void FillCompliance(const ContactSet& contacts, const Eigen::Ref<const Eigen::MatrixXd>& response,
                    ContactProblem* problem) {
  for (int g = 0; g < problem->size(); ++g) {
    const Eigen::Map<const Points> U(response.col(g).data(), response.rows() / 3, 3);
    Vector3d moved = Vector3d::Zero();
    int at = -1;  // the equations of one contact follow each other
    for (int e = 0; e < problem->size(); ++e) {
      const auto& [row, axis, force, unilateral] = (*problem)[e];
      if (row != at) moved.noalias() = (contacts.Weights().row(row) * U).transpose();
      at = row;
      problem->compliance()(e, g) = axis.dot(moved);
    }
  }
}

RelaxationResult SolveContacts(LatticeResponse* response, ContactProblem* problem,
                               ContactSet* contacts, Points* U) {
  problem->Build(*contacts);
  response->Respond(*contacts, problem);
  const RelaxationResult result = problem->Solve();
  problem->WriteForces(contacts);
  response->Deform(*problem, U);
  return result;
}

std::unique_ptr<LatticeResponse> MakeLatticeResponse(const ScalarStiffness& K) {
  return std::make_unique<ScalarResponse>(K);
}

std::unique_ptr<LatticeResponse> MakeLatticeResponse(const FullStiffness& K) {
  return std::make_unique<FullResponse>(K);
}

}  // namespace hpdm
