#include "engine/solver/compliance_solver.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

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

  void Respond(int body, const ContactConstraints& contacts, double yield,
               ContactSolver* contact_solver) override {
    for (int i = 0; i < contacts.size(); ++i) {
      auto response = response_.col(i);
      response.setZero();
      for (Eigen::Index a = 0; a < inverse_.rows(); ++a) {
        const double weight = contacts.Weights()(i, a);
        if (weight != 0) response += weight * inverse_.col(a);
      }
    }
    row_compliance_.noalias() = contacts.Weights() * response_.leftCols(contacts.size());
    for (const ContactSolver::Side& first : contact_solver->sides(body)) {
      for (const ContactSolver::Side& second : contact_solver->sides(body)) {
        contact_solver->compliance()(first.equation, second.equation) +=
            yield * (row_compliance_(first.row, second.row) * first.axis_W.dot(second.force_W));
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
// the control points of its contact rows give the compliance between the rows. The columns of those
// points, read once, give the displacements under all forces.
class FullComplianceSolver final : public ComplianceSolver {
 public:
  explicit FullComplianceSolver(const FullStiffness& K)
      : n_(K.rows() / 3),
        inverse_(InverseStiffness(
            K, "add an [[organ.support]], use fewer cells, a lower degree or a lower poisson")),
        place_(static_cast<std::size_t>(n_)),
        touched_(static_cast<std::size_t>(n_)),
        runs_(static_cast<std::size_t>(n_)),
        entries_(kMaxContacts * static_cast<std::size_t>(n_)),
        moved_(3 * n_, 3),
        row_compliance_(3 * kMaxContacts, 3 * kMaxContacts),
        forces_(3, n_),
        solved_(3 * n_, kBatch) {}

  void Respond(int body, const ContactConstraints& contacts, double yield,
               ContactSolver* contact_solver) override {
    Gather(contacts);
    for (int i = 0; i < contacts.size(); ++i) FillRowCompliance(i);
    for (const ContactSolver::Side& loaded : contact_solver->sides(body)) {
      Vector3d moved = Vector3d::Zero();
      int at = -1;  // the sides of one row follow each other
      for (const ContactSolver::Side& side : contact_solver->sides(body)) {
        if (side.row != at) {
          at = side.row;
          moved.noalias() = row_compliance_.block<3, 3>(3 * at, 3 * loaded.row) * loaded.force_W;
        }
        contact_solver->compliance()(side.equation, loaded.equation) +=
            yield * side.axis_W.dot(moved);
      }
    }
  }

  void Deform(int body, const ContactSolver& contact_solver, Points* U) const override {
    forces_.leftCols(count_).setZero();
    for (const ContactSolver::Side& side : contact_solver.sides(body)) {
      const Vector3d force = contact_solver.forces()[side.equation] * side.force_W;
      for (const Entry& entry : EntriesOf(side.row)) {
        forces_.col(entry.place) += entry.weight * force;
      }
    }
    auto u = AsVector(U);
    u.setZero();
    for (int t = 0; t < count_; ++t) {
      const int a = touched_[static_cast<std::size_t>(t)];
      for (int d = 0; d < 3; ++d) {
        if (forces_(d, t) != 0) u += forces_(d, t) * inverse_.col(3 * a + d);
      }
    }
  }

  // Each column of K^-1 is read once for a batch of loads.
  void SolveLoads(Eigen::Ref<Eigen::MatrixXd> columns) const override {
    for (Eigen::Index first = 0; first < columns.cols(); first += kBatch) {
      auto loads = columns.middleCols(first, std::min(kBatch, columns.cols() - first));
      auto u = solved_.leftCols(loads.cols());
      u.setZero();
      for (Eigen::Index i = 0; i < loads.rows(); ++i) {
        for (Eigen::Index c = 0; c < loads.cols(); ++c) {
          if (loads(i, c) != 0) u.col(c) += loads(i, c) * inverse_.col(i);
        }
      }
      loads = u;
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
  static constexpr Eigen::Index kBatch = 24;

  // A non-zero weight of a row: the place of its control point in touched_.
  struct Entry {
    int place = 0;
    double weight = 0;
  };
  // Touched control points with successive numbers.
  struct Run {
    int first = 0;  // control point
    int place = 0;
    int length = 0;
  };

  std::span<Entry> EntriesOf(int row) {
    const auto i = static_cast<std::size_t>(row);
    return {entries_.data() + i * static_cast<std::size_t>(n_), entry_count_[i]};
  }
  std::span<const Entry> EntriesOf(int row) const {
    const auto i = static_cast<std::size_t>(row);
    return {entries_.data() + i * static_cast<std::size_t>(n_), entry_count_[i]};
  }

  // Collects the control points with a weight in any row, and the rows' weights.
  void Gather(const ContactConstraints& contacts) {
    constexpr int kUntouched = -1;
    std::fill(place_.begin(), place_.end(), kUntouched);
    for (int i = 0; i < contacts.size(); ++i) {
      const auto row = static_cast<std::size_t>(i);
      entry_count_[row] = 0;
      for (int a = 0; a < n_; ++a) {
        const double weight = contacts.Weights()(i, a);
        if (weight == 0) continue;
        entries_[row * static_cast<std::size_t>(n_) + entry_count_[row]++] = {a, weight};
        place_[static_cast<std::size_t>(a)] = 0;
      }
    }
    count_ = 0;
    run_count_ = 0;
    for (int a = 0; a < n_; ++a) {
      int& place = place_[static_cast<std::size_t>(a)];
      if (place == kUntouched) continue;
      const bool follows = a > 0 && place_[static_cast<std::size_t>(a - 1)] != kUntouched;
      if (!follows) runs_[run_count_++] = {a, count_, 0};
      ++runs_[run_count_ - 1].length;
      touched_[static_cast<std::size_t>(count_)] = a;
      place = count_++;
    }
    for (int i = 0; i < contacts.size(); ++i) {
      for (Entry& entry : EntriesOf(i)) entry.place = place_[static_cast<std::size_t>(entry.place)];
    }
  }

  // Computes B K^-1 B^T between row i and the rows up to it.
  void FillRowCompliance(int i) {
    moved_.topRows(3 * count_).setZero();  // the touched control points, for unit forces on the row
    for (const Entry& entry : EntriesOf(i)) {
      const int a = touched_[static_cast<std::size_t>(entry.place)];
      for (std::size_t r = 0; r < run_count_; ++r) {
        const Run& run = runs_[r];
        moved_.middleRows(3 * run.place, 3 * run.length) +=
            entry.weight * inverse_.middleCols<3>(3 * a).middleRows(3 * run.first, 3 * run.length);
      }
    }
    for (int j = 0; j <= i; ++j) {
      Matrix3d sum = Matrix3d::Zero();
      for (const Entry& entry : EntriesOf(j)) {
        sum += entry.weight * moved_.middleRows<3>(3 * entry.place);
      }
      if (j == i) sum = ((sum + sum.transpose()) / 2).eval();
      row_compliance_.block<3, 3>(3 * j, 3 * i) = sum;
      row_compliance_.block<3, 3>(3 * i, 3 * j) = sum.transpose();
    }
  }

  int n_;
  Eigen::MatrixXd inverse_;    // 3n x 3n
  int count_ = 0;              // number of control points touched by the last Respond()'s contacts
  std::vector<int> place_;     // n: of the control points in touched_, or -1
  std::vector<int> touched_;   // n; the first count_ are these control points
  std::size_t run_count_ = 0;  // of them
  std::vector<Run> runs_;      // n
  std::array<std::size_t, kMaxContacts> entry_count_{};
  std::vector<Entry> entries_;                      // kMaxContacts x n
  Eigen::Matrix<double, Eigen::Dynamic, 3> moved_;  // 3n x 3
  Eigen::MatrixXd row_compliance_;                  // B K^-1 B^T of the last Respond()
  mutable Eigen::Matrix3Xd forces_;                 // on the touched control points, N
  mutable Eigen::MatrixXd solved_;                  // 3n x kBatch
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
      contact_solver->compliance()(side.equation, loaded.equation) +=
          yield * side.axis_W.dot(moved);
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
  if (input.free != nullptr) TakeOffChanges(body, contacts, *input.free, contact_solver);
}

void AdvanceQuadratic(int body, const RelaxationInput& input,
                      const ComplianceSolver& compliance_solver,
                      const ContactSolver& contact_solver, Points* U) {
  compliance_solver.Deform(body, contact_solver, U);
  if (input.yield != 1) *U *= input.yield;
  if (input.free != nullptr) *U += *input.free;
}

std::unique_ptr<ComplianceSolver> MakeComplianceSolver(const ScalarStiffness& K) {
  return std::make_unique<ScalarComplianceSolver>(K);
}

std::unique_ptr<ComplianceSolver> MakeComplianceSolver(const FullStiffness& K) {
  return std::make_unique<FullComplianceSolver>(K);
}

}  // namespace hpdm
