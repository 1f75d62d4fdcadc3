#include "engine/solver/compliance_solver.h"

#include <string>

#include "engine/base/error.h"
#include "engine/solver/symmetric_inverse.h"

namespace hpdm {
namespace {

// Views the unknowns of U as one vector (Points are row-major).
Eigen::Map<Eigen::VectorXd> AsVector(Points* U) { return {U->data(), U->size()}; }

// x, y and z are uncoupled and respond alike, so each contact row needs one column.
class ScalarComplianceSolver final : public ComplianceSolver {
 public:
  explicit ScalarComplianceSolver(const ScalarStiffness& K)
      : inverse_(InverseStiffness(Eigen::MatrixXd(K), "add an [[organ.support]] or raise alpha")),
        response_(K.rows(), kMaxContacts) {}

  void Respond(const ContactConstraints& contacts, ContactSolver* contact_solver) override {
    for (int i = 0; i < contacts.size(); ++i) {
      auto response = response_.col(i);
      response.setZero();
      for (Eigen::Index a = 0; a < inverse_.rows(); ++a) {
        const double weight = contacts.Weights()(i, a);
        if (weight != 0) response += weight * inverse_.col(a);
      }
    }
    row_compliance_.noalias() = contacts.Weights() * response_.leftCols(contacts.size());
    for (int e = 0; e < contact_solver->size(); ++e) {
      const ContactSolver::Equation& first = (*contact_solver)[e];
      for (int g = 0; g < contact_solver->size(); ++g) {
        const ContactSolver::Equation& second = (*contact_solver)[g];
        contact_solver->compliance()(e, g) =
            row_compliance_(first.row, second.row) * first.axis_W.dot(second.force_W);
      }
    }
  }

  void Deform(const ContactSolver& contact_solver, Points* U) const override {
    U->setZero();
    for (int e = 0; e < contact_solver.size(); ++e) {
      const Vector3d force = contact_solver.forces()[e] * contact_solver[e].force_W;
      for (int d = 0; d < 3; ++d) U->col(d) += force[d] * response_.col(contact_solver[e].row);
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

// Solver for coupled axes: K is 3n x 3n. A step reads only two parts of K^-1. The entries between
// the control points of its contact rows give the compliance. The columns of those points, read
// once, give the displacements under all forces.
class FullComplianceSolver final : public ComplianceSolver {
 public:
  explicit FullComplianceSolver(const FullStiffness& K)
      : n_(K.rows() / 3),
        inverse_(InverseStiffness(
            K, "add an [[organ.support]], use fewer cells, a lower degree or a lower poisson")),
        touched_(static_cast<std::size_t>(n_)),
        weights_(kMaxContacts, n_),
        moved_(3, n_) {}

  void Respond(const ContactConstraints& contacts, ContactSolver* contact_solver) override {
    Gather(contacts);
    for (int g = 0; g < contact_solver->size(); ++g) {
      Move((*contact_solver)[g]);
      Vector3d moved = Vector3d::Zero();
      int at = -1;  // the equations of one contact follow each other
      for (int e = 0; e < contact_solver->size(); ++e) {
        const ContactSolver::Equation& equation = (*contact_solver)[e];
        if (equation.row != at) {
          at = equation.row;
          moved.setZero();
          for (int t = 0; t < count_; ++t) moved += weights_(at, t) * moved_.col(t);
        }
        contact_solver->compliance()(e, g) = equation.axis_W.dot(moved);
      }
    }
  }

  void Deform(const ContactSolver& contact_solver, Points* U) const override {
    auto u = AsVector(U);
    u.setZero();
    for (int t = 0; t < count_; ++t) {
      Vector3d force = Vector3d::Zero();
      for (int e = 0; e < contact_solver.size(); ++e) {
        force += contact_solver.forces()[e] * weights_(contact_solver[e].row, t) *
                 contact_solver[e].force_W;
      }
      AddColumns(touched_[static_cast<std::size_t>(t)], force, &u);
    }
  }

  void Solve(Eigen::Ref<Eigen::MatrixXd> columns) const override {
    Eigen::VectorXd u(columns.rows());
    for (Eigen::Index c = 0; c < columns.cols(); ++c) {
      u.setZero();
      for (int a = 0; a < n_; ++a) AddColumns(a, columns.col(c).segment<3>(3 * a), &u);
      columns.col(c) = u;
    }
  }

  void RespondTo(const SparseRow& b, Eigen::Ref<Eigen::MatrixXd> response) const override {
    response.setZero();
    for (std::size_t i = 0; i < b.control_points.size(); ++i) {
      response += b.weights[i] * inverse_.middleCols<3>(3 * b.control_points[i]);
    }
  }

  Matrix3d PointCompliance(const SparseRow& b) const override { return PointBlock(inverse_, b); }

 private:
  // Collects the control points with a weight in any row, and their weights.
  void Gather(const ContactConstraints& contacts) {
    count_ = 0;
    for (int a = 0; a < n_; ++a) {
      const auto weights = contacts.Weights().col(a);
      if ((weights.array() == 0).all()) continue;
      weights_.col(count_).head(contacts.size()) = weights;
      touched_[static_cast<std::size_t>(count_++)] = a;
    }
  }

  // Computes the displacements of the touched control points for the equation's unit force.
  void Move(const ContactSolver::Equation& equation) {
    auto moved = moved_.leftCols(count_);
    moved.setZero();
    for (int t = 0; t < count_; ++t) {
      const double weight = weights_(equation.row, t);
      if (weight == 0) continue;
      for (int d = 0; d < 3; ++d) {
        if (equation.force_W[d] == 0) continue;
        const auto column = inverse_.col(3 * touched_[static_cast<std::size_t>(t)] + d);
        const double force = weight * equation.force_W[d];
        for (int s = 0; s < count_; ++s) {
          moved.col(s) += force * column.segment<3>(3 * touched_[static_cast<std::size_t>(s)]);
        }
      }
    }
  }

  // Adds the displacements for a force (N) on control point a.
  template <typename Displacements>
  void AddColumns(int a, const Vector3d& force, Displacements* u) const {
    for (int d = 0; d < 3; ++d) {
      if (force[d] != 0) *u += force[d] * inverse_.col(3 * a + d);
    }
  }

  int n_;
  Eigen::MatrixXd inverse_;   // 3n x 3n
  int count_ = 0;             // number of control points touched by the last Respond()'s contacts
  std::vector<int> touched_;  // n; the first count_ are these control points
  Eigen::MatrixXd weights_;   // kMaxContacts x n: their weights in each contact's row
  Eigen::Matrix3Xd moved_;    // 3 x n: their displacements for the present unit force
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
  // Functions with little tissue have little stiffness. Scaling to a unit diagonal separates them
  // from motions without stiffness.
  const Eigen::VectorXd scale = K.diagonal().cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd inverse = scale.asDiagonal() * K * scale.asDiagonal();
  // An unsupported motion leaves round-off of about 1e-18. A supported Bernstein lattice of degree
  // (20, 2, 2), whose functions are nearly dependent, gives 4e-15.
  constexpr double kMinPivot = 1e-15;
  if (!(InvertSymmetric(&inverse) > kMinPivot)) {
    throw InputError(std::string("lattice stiffness is not positive definite; ") + remedy);
  }
  inverse.array().colwise() *= scale.array();
  inverse.array().rowwise() *= scale.transpose().array();
  return inverse;
}

void FillCompliance(const ContactConstraints& contacts,
                    const Eigen::Ref<const Eigen::MatrixXd>& response,
                    ContactSolver* contact_solver) {
  for (int g = 0; g < contact_solver->size(); ++g) {
    const Eigen::Map<const Points> U(response.col(g).data(), response.rows() / 3, 3);
    Vector3d moved = Vector3d::Zero();
    int at = -1;  // the equations of one contact follow each other
    for (int e = 0; e < contact_solver->size(); ++e) {
      const auto& [row, axis, force, unilateral] = (*contact_solver)[e];
      if (row != at) moved.noalias() = (contacts.Weights().row(row) * U).transpose();
      at = row;
      contact_solver->compliance()(e, g) = axis.dot(moved);
    }
  }
}

RelaxationResult SolveContacts(ComplianceSolver* compliance_solver, ContactSolver* contact_solver,
                               ContactConstraints* contacts, Points* U) {
  contact_solver->Build(*contacts);
  compliance_solver->Respond(*contacts, contact_solver);
  const RelaxationResult result = contact_solver->Solve();
  contact_solver->WriteForces(contacts);
  compliance_solver->Deform(*contact_solver, U);
  return result;
}

std::unique_ptr<ComplianceSolver> MakeComplianceSolver(const ScalarStiffness& K) {
  return std::make_unique<ScalarComplianceSolver>(K);
}

std::unique_ptr<ComplianceSolver> MakeComplianceSolver(const FullStiffness& K) {
  return std::make_unique<FullComplianceSolver>(K);
}

}  // namespace hpdm
