#include <Eigen/Cholesky>

#include "engine/lattice_response.h"
#include "engine/local_functions.h"

namespace hpdm {
namespace {

// With a load (f, g) on the control points and on the local functions in use, of which X and S are
// the columns and blocks in LocalFunctions,
//     V = S^-1 (g - X^T f),   U = K^-1 f - X V.
class RefinedResponse final : public LatticeResponse {
 public:
  RefinedResponse(const LocalFunctions& functions, int slots)
      : functions_(functions),
        unknowns_(functions.inverse().rows()),
        function_(slots, -1),
        coupling_(Eigen::MatrixXd::Zero(unknowns_, 3 * slots)),
        reduced_(Eigen::MatrixXd::Identity(3 * slots, 3 * slots)),
        regular_(reduced_),
        factor_(reduced_),
        response_(unknowns_ + 3 * slots, ContactProblem::kMaxEquations) {}

  // The parts of S that belong to slots that changed, then its factor.
  void Follow(const ActiveFunctions& active) override {
    bool changed = false;
    for (int s = 0; s < active.slots(); ++s) {
      if (function_[s] == active.Function(s)) continue;
      function_[s] = active.Function(s);
      changed = true;
      if (function_[s] >= 0) {
        coupling_.middleCols<3>(3 * s) = functions_.Coupling(function_[s]);
      } else {
        coupling_.middleCols<3>(3 * s).setZero();
      }
      stale_[s] = true;
    }
    if (!changed) return;
    for (int s = 0; s < active.slots(); ++s) {
      for (int t = 0; t <= s; ++t) {
        if (!stale_[s] && !stale_[t]) continue;
        Matrix3d block = Matrix3d::Zero();
        if (function_[s] >= 0 && function_[t] >= 0) {
          block = functions_.ReducedStiffness(function_[s], function_[t]);
        } else if (s == t) {
          block.setIdentity();
        }
        reduced_.block<3, 3>(3 * s, 3 * t) = block;
        reduced_.block<3, 3>(3 * t, 3 * s) = block.transpose();
      }
    }
    std::fill(stale_.begin(), stale_.end(), false);
    // Local functions that together make up one of the lattice's own leave its share of S without
    // stiffness; which of the two moves is arbitrary then.
    for (double extra = kRegularisation; extra < 1; extra *= 10) {
      regular_ = reduced_;
      regular_.diagonal() *= 1 + extra;
      factor_.compute(regular_);
      if (factor_.info() == Eigen::Success) return;
    }
  }

  void Respond(const ContactSet& contacts, ContactProblem* problem) override {
    Follow(contacts.local);
    const int equations = problem->size();
    for (int e = 0; e < equations; ++e) {
      const auto& [row, axis, force, unilateral] = (*problem)[e];
      auto load = response_.col(e);
      for (Eigen::Index a = 0; 3 * a < load.size(); ++a) {
        load.segment<3>(3 * a) = contacts.Weights()(row, a) * force;
      }
    }
    Solve(response_.leftCols(equations));
    FillCompliance(contacts, response_, problem);
  }

  void Deform(const ContactProblem& problem, Points* U) const override {
    Eigen::Map<Eigen::VectorXd>(U->data(), U->size()).noalias() =
        response_.leftCols(problem.size()) * problem.forces();
  }

  void Solve(Eigen::Ref<Eigen::MatrixXd> columns) const override {
    for (Eigen::Index c = 0; c < columns.cols(); ++c) SolveColumn(columns.col(c));
  }

  void RespondTo(const SparseRow& b, Eigen::Ref<Eigen::MatrixXd> response) const override {
    response.setZero();
    for (std::size_t i = 0; i < b.control_points.size(); ++i) {
      for (int d = 0; d < 3; ++d) response(3 * b.control_points[i] + d, d) += b.weights[i];
    }
    Solve(response);
  }

  // Without local functions.
  Matrix3d PointCompliance(const SparseRow& b) const override {
    return PointBlock(functions_.inverse(), b);
  }

 private:
  static constexpr double kRegularisation = 1e-9;

  // Loads have few entries: a contact's row has one for each function that is not zero there.
  void SolveColumn(Eigen::Ref<Eigen::VectorXd> column) const {
    auto f = column.head(unknowns_);
    auto g = column.tail(column.size() - unknowns_);
    scratch_.setZero(unknowns_);
    for (Eigen::Index i = 0; i < unknowns_; ++i) {
      if (f[i] != 0) scratch_ += f[i] * functions_.inverse().col(i);
    }
    g.noalias() -= coupling_.transpose() * f;
    factor_.solveInPlace(g);
    f = scratch_;
    f.noalias() -= coupling_ * g;
  }

  const LocalFunctions& functions_;
  Eigen::Index unknowns_;  // 3n
  std::vector<int> function_;
  std::vector<bool> stale_ = std::vector<bool>(function_.size());
  Eigen::MatrixXd coupling_;  // 3n x 3 slots: X
  Eigen::MatrixXd reduced_;   // 3 slots x 3 slots: S, the identity where a slot is empty
  Eigen::MatrixXd regular_;
  Eigen::LLT<Eigen::MatrixXd> factor_;
  Eigen::MatrixXd response_;  // (3n + 3 slots) x kMaxEquations
  mutable Eigen::VectorXd scratch_ = Eigen::VectorXd(unknowns_);
};

}  // namespace

std::unique_ptr<LatticeResponse> MakeLatticeResponse(const LocalFunctions& functions, int slots) {
  return std::make_unique<RefinedResponse>(functions, slots);
}

}  // namespace hpdm
