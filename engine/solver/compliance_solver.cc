#include "engine/solver/compliance_solver.h"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/copying.h"
#include "engine/base/error.h"
#include "engine/solver/elastic_supports.h"
#include "engine/solver/row_responses.h"
#include "engine/solver/symmetric_inverse.h"
#include "engine/solver/unit_responses.h"

namespace hpdm {
namespace {

std::shared_ptr<const Eigen::MatrixXd> Shared(Eigen::MatrixXd matrix) {
  return std::make_shared<const Eigen::MatrixXd>(std::move(matrix));
}

// Views the unknowns of U as one vector (Points are row-major).
Eigen::Map<Eigen::VectorXd> AsVector(Points* U) { return {U->data(), U->size()}; }

// x, y and z are uncoupled and respond alike, so each contact row needs one column.
class ScalarComplianceSolver final : public ComplianceSolver {
 public:
  explicit ScalarComplianceSolver(const ScalarStiffness& K)
      : inverse_(Shared(
            InverseStiffness(Eigen::MatrixXd(K), "add an [[organ.support]] or raise alpha"))),
        response_(K.rows(), kMaxContacts) {}
  std::unique_ptr<ComplianceSolver> Clone() const override {
    return std::make_unique<ScalarComplianceSolver>(*this);
  }
  void Take(const ComplianceSolver& other) override {
    *this = static_cast<const ScalarComplianceSolver&>(other);
  }

  void Respond(int body, const ContactConstraints& contacts, double yield,
               ContactSolver* contact_solver) override {
    for (int i = 0; i < contacts.size(); ++i) {
      auto response = response_.col(i);
      response.setZero();
      for (Eigen::Index a = 0; a < inverse_->rows(); ++a) {
        const double weight = contacts.Weights()(i, a);
        if (weight != 0) response += weight * inverse_->col(a);
      }
    }
    row_compliance_.noalias() = contacts.Weights() * response_.leftCols(contacts.size());
    for (const ContactSolver::Side& first : contact_solver->sides(body)) {
      for (const ContactSolver::Side& second : contact_solver->sides(body)) {
        contact_solver->AddCompliance(
            first.equation, second.equation,
            row_compliance_(first.row, second.row) * first.axis_W.dot(second.force_W), yield);
      }
    }
  }

  void Deform(int body, const ContactSolver& contact_solver, Points* U) const override {
    U->setZero();
    for (const ContactSolver::Side& side : contact_solver.sides(body)) {
      const Vector3d force = contact_solver.forces()[side.equation] * side.force_W;
      for (int d = 0; d < 3; ++d) U->col(d) += force[d] * response_.col(side.row);
    }
  }

  void SolveLoads(Eigen::Ref<Eigen::MatrixXd> columns) const override {
    for (Eigen::Index c = 0; c < columns.cols(); ++c) {
      Eigen::Map<Points> loads(columns.col(c).data(), inverse_->rows(), 3);
      loads = (*inverse_ * loads).eval();
    }
  }

  void RespondTo(const SparseRow& b, Eigen::Ref<Eigen::MatrixXd> response) const override {
    response.setZero();
    for (std::size_t i = 0; i < b.control_points.size(); ++i) {
      for (Eigen::Index c = 0; c < inverse_->rows(); ++c) {
        const double moved = b.weights[i] * (*inverse_)(c, b.control_points[i]);
        for (int d = 0; d < 3; ++d) response(3 * c + d, d) += moved;
      }
    }
  }

  Matrix3d PointCompliance(const SparseRow& b) const override {
    double sum = 0;
    for (std::size_t i = 0; i < b.control_points.size(); ++i) {
      for (std::size_t j = 0; j < b.control_points.size(); ++j) {
        sum += b.weights[i] * b.weights[j] * (*inverse_)(b.control_points[j], b.control_points[i]);
      }
    }
    return sum * Matrix3d::Identity();
  }

 private:
  std::shared_ptr<const Eigen::MatrixXd> inverse_;  // n x n
  WorkMatrix response_;                             // n x kMaxContacts: K^-1 B^T
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxContacts,
                kMaxContacts>
      row_compliance_;  // m x m: B K^-1 B^T
};

// Solver for coupled axes: K is 3n x 3n.
class FullComplianceSolver final : public ComplianceSolver {
 public:
  explicit FullComplianceSolver(const FullStiffness& K)
      : inverse_(Shared(InverseStiffness(
            K, "add an [[organ.support]], use fewer cells, a lower degree or a lower poisson"))),
        rows_(*inverse_),
        solved_(inverse_->rows(), kBatch) {}
  std::unique_ptr<ComplianceSolver> Clone() const override {
    return std::make_unique<FullComplianceSolver>(*this);
  }
  void Take(const ComplianceSolver& other) override {
    *this = static_cast<const FullComplianceSolver&>(other);
  }

  void Respond(int body, const ContactConstraints& contacts, double yield,
               ContactSolver* contact_solver) override {
    rows_.Gather(contacts);
    rows_.AddCompliance(body, yield, contact_solver);
  }

  void Deform(int body, const ContactSolver& contact_solver, Points* U) const override {
    rows_.SetForces(body, contact_solver);
    rows_.Deform(AsVector(U));
  }

  // Each column of K^-1 is read once for a batch of loads.
  void SolveLoads(Eigen::Ref<Eigen::MatrixXd> columns) const override {
    for (Eigen::Index first = 0; first < columns.cols(); first += kBatch) {
      auto loads = columns.middleCols(first, std::min(kBatch, columns.cols() - first));
      auto u = solved_.leftCols(loads.cols());
      u.setZero();
      for (Eigen::Index i = 0; i < loads.rows(); ++i) {
        for (Eigen::Index c = 0; c < loads.cols(); ++c) {
          if (loads(i, c) != 0) u.col(c) += loads(i, c) * inverse_->col(i);
        }
      }
      loads = u;
    }
  }

  void RespondTo(const SparseRow& b, Eigen::Ref<Eigen::MatrixXd> response) const override {
    FillUnitResponses(*inverse_, {&b, 1}, response);
  }
  void RespondToSet(std::span<const SparseRow> rows,
                    Eigen::Ref<Eigen::MatrixXd> responses) const override {
    FillUnitResponses(*inverse_, rows, responses);
  }

  Matrix3d PointCompliance(const SparseRow& b) const override { return PointBlock(*inverse_, b); }

 private:
  static constexpr Eigen::Index kBatch = 24;

  std::shared_ptr<const Eigen::MatrixXd> inverse_;  // 3n x 3n
  mutable RowResponses rows_;
  mutable Eigen::MatrixXd solved_;  // 3n x kBatch
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

void AddCompliance(int body, const ContactConstraints& contacts,
                   const Eigen::Ref<const Eigen::MatrixXd>& response, double yield,
                   ContactSolver* contact_solver) {
  Eigen::Index column = 0;
  for (const ContactSolver::Side& loaded : contact_solver->sides(body)) {
    const Eigen::Map<const Points> U(response.col(column++).data(), response.rows() / 3, 3);
    Vector3d moved = Vector3d::Zero();
    int at = -1;  // the sides of one row follow each other
    for (const ContactSolver::Side& side : contact_solver->sides(body)) {
      if (side.row != at) moved.noalias() = (contacts.Weights().row(side.row) * U).transpose();
      at = side.row;
      contact_solver->AddCompliance(side.equation, loaded.equation, side.axis_W.dot(moved) / yield,
                                    yield);
    }
  }
}

void TakeOffChanges(int body, const ContactConstraints& contacts, const Points& U,
                    ContactSolver* contact_solver) {
  for (const ContactSolver::Side& side : contact_solver->sides(body)) {
    contact_solver->change()[side.equation] -=
        side.axis_W.dot((contacts.Weights().row(side.row) * U).transpose());
  }
}

void LineariseQuadratic(int body, const ContactConstraints& contacts, const RelaxationInput& input,
                        ComplianceSolver* compliance_solver, ContactSolver* contact_solver) {
  compliance_solver->Respond(body, contacts, input.yield, contact_solver);
  if (input.supports != nullptr) {
    input.supports->AddCompliance(body, contacts, input.damping, contact_solver);
  }
  if (input.free != nullptr) TakeOffChanges(body, contacts, *input.free, contact_solver);
}

void AdvanceQuadratic(int body, const RelaxationInput& input,
                      const ComplianceSolver& compliance_solver,
                      const ContactSolver& contact_solver, Points* U) {
  compliance_solver.Deform(body, contact_solver, U);
  if (input.yield != 1) *U *= input.yield;
  if (input.supports != nullptr) {
    input.supports->AddDisplacements(body, input.damping, contact_solver, U);
  }
  if (input.free != nullptr) *U += *input.free;
}

std::unique_ptr<ComplianceSolver> MakeComplianceSolver(const ScalarStiffness& K) {
  return std::make_unique<ScalarComplianceSolver>(K);
}

std::unique_ptr<ComplianceSolver> MakeComplianceSolver(const FullStiffness& K) {
  return std::make_unique<FullComplianceSolver>(K);
}

}  // namespace hpdm
