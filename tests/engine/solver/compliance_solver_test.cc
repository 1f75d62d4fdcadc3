#include "engine/solver/compliance_solver.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <array>
#include <cstdlib>
#include <memory>

#include "engine/base/error.h"

namespace hpdm {
namespace {

constexpr int kControlPoints = 7;
constexpr double kRoundOff = 1e-11;  // relative: the condition of K is below 1e3

// Both solvers against a dense Cholesky factorisation of the same K.
class ComplianceSolverTest : public testing::Test {
 protected:
  ComplianceSolverTest() {
    std::srand(1);
    AddRow(ContactConstraints::RowKind::kGrasp);
    AddRow(ContactConstraints::RowKind::kPress).normal_W = Vector3d(0.6, 0, 0.8);
    ContactConstraints::Row& sliding = AddRow(ContactConstraints::RowKind::kPress);
    sliding.normal_W = Vector3d(0, 1, 0);
    sliding.friction_W = Vector3d(0.3, 0, 0.1);
    contact_solver_.Build(contacts_);
  }

  ContactConstraints::Row& AddRow(ContactConstraints::RowKind kind) {
    ContactConstraints::Row& row = *contacts_.Add();
    row.kind = kind;
    auto weights = contacts_.WeightRow(contacts_.size() - 1);
    weights = Eigen::RowVectorXd::Random(kControlPoints);
    weights[contacts_.size()] = 0;  // as most functions are at a point
    return row;
  }
  static Eigen::MatrixXd RandomStiffness(int size) {
    const Eigen::MatrixXd root = Eigen::MatrixXd::Random(size, size);
    return 100 * (root * root.transpose() + Eigen::MatrixXd::Identity(size, size));
  }
  // The loads (3n) of equation e's unit force.
  Eigen::VectorXd Load(int e) const {
    const ContactSolver::Side& equation = contact_solver_.sides()[e];
    Eigen::VectorXd load(3 * kControlPoints);
    for (int a = 0; a < kControlPoints; ++a) {
      load.segment<3>(3 * a) = contacts_.Weights()(equation.row, a) * equation.force_W;
    }
    return load;
  }
  // The displacement of equation e's point along its axis.
  double Along(int e, const Eigen::VectorXd& u) const {
    const ContactSolver::Side& equation = contact_solver_.sides()[e];
    Vector3d moved = Vector3d::Zero();
    for (int a = 0; a < kControlPoints; ++a) {
      moved += contacts_.Weights()(equation.row, a) * u.segment<3>(3 * a);
    }
    return equation.axis_W.dot(moved);
  }

  void ExpectDenseAnswers(ComplianceSolver* solver, const Eigen::MatrixXd& K) {
    const Eigen::LLT<Eigen::MatrixXd> dense(K);
    solver->Respond(0, contacts_, 1, &contact_solver_);
    for (int g = 0; g < contact_solver_.size(); ++g) {
      const Eigen::VectorXd u = dense.solve(Load(g));
      for (int e = 0; e < contact_solver_.size(); ++e) {
        EXPECT_NEAR(contact_solver_.compliance()(e, g), Along(e, u), kRoundOff * u.norm());
      }
    }
    contact_solver_.change().setConstant(0.01);
    contact_solver_.Solve();
    Eigen::VectorXd load = Eigen::VectorXd::Zero(3 * kControlPoints);
    for (int e = 0; e < contact_solver_.size(); ++e) load += contact_solver_.forces()[e] * Load(e);
    const Eigen::VectorXd u = dense.solve(load);
    ASSERT_GT(u.norm(), 1e-3);
    Points U(kControlPoints, 3);
    solver->Deform(0, contact_solver_, &U);
    EXPECT_LT((Eigen::Map<const Eigen::VectorXd>(U.data(), U.size()) - u).norm(),
              kRoundOff * u.norm());

    Eigen::MatrixXd columns = Eigen::MatrixXd::Random(3 * kControlPoints, 2);
    const Eigen::MatrixXd expected = dense.solve(columns);
    solver->SolveLoads(columns);
    EXPECT_LT((columns - expected).norm(), kRoundOff * expected.norm());

    const std::array<int, 2> control_points = {1, 4};
    const std::array<double, 2> weights = {0.7, -0.2};
    const SparseRow b{control_points, weights};
    Eigen::MatrixXd loads(3 * kControlPoints, 3), response(3 * kControlPoints, 3);
    FillUnitLoads(b, loads);
    solver->RespondTo(b, response);
    EXPECT_LT((response - dense.solve(loads)).norm(), kRoundOff * response.norm());
    EXPECT_LT((solver->PointCompliance(b) - loads.transpose() * response).norm(),
              kRoundOff * response.norm());
  }

  ContactConstraints contacts_{kControlPoints};
  ContactSolver contact_solver_;
};

TEST_F(ComplianceSolverTest, CoupledAxesAnswerAsTheDenseStiffnessDoes) {
  const FullStiffness K = RandomStiffness(3 * kControlPoints);
  ExpectDenseAnswers(MakeComplianceSolver(K).get(), K);
}

TEST_F(ComplianceSolverTest, UncoupledAxesAnswerAsTheDenseStiffnessDoes) {
  const Eigen::MatrixXd K = RandomStiffness(kControlPoints);
  FullStiffness along_each_axis = FullStiffness::Zero(3 * kControlPoints, 3 * kControlPoints);
  const ScalarStiffness scalar = K.sparseView();
  AddAlongEachAxis(scalar, &along_each_axis);
  ExpectDenseAnswers(MakeComplianceSolver(scalar).get(), along_each_axis);
}

TEST_F(ComplianceSolverTest, AFreeLatticeIsRefused) {
  // A chain of springs without a support: translations cost nothing.
  Eigen::MatrixXd K = 2 * Eigen::MatrixXd::Identity(kControlPoints, kControlPoints);
  K.diagonal(1).setConstant(-1);
  K.diagonal(-1).setConstant(-1);
  K(0, 0) = K(kControlPoints - 1, kControlPoints - 1) = 1;
  const ScalarStiffness free = K.sparseView();
  EXPECT_THROW(MakeComplianceSolver(free), InputError);
  K(0, 0) = 2;  // held at one end
  const ScalarStiffness held = K.sparseView();
  EXPECT_NO_THROW(MakeComplianceSolver(held));
}

}  // namespace
}  // namespace hpdm
