#include "engine/contact/tip_compliance.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <array>
#include <cstdlib>
#include <optional>
#include <utility>
#include <vector>

namespace hpdm {
namespace {

constexpr int kControlPoints = 6;

// A lattice with a given K^-1.
class DenseCompliance final : public LatticeCompliance {
 public:
  explicit DenseCompliance(Eigen::MatrixXd inverse) : inverse_(std::move(inverse)) {}
  void RespondTo(const SparseRow& b, Eigen::Ref<Eigen::MatrixXd> response) const override {
    FillUnitLoads(b, response);
    response = (inverse_ * response).eval();
  }
  void SolveLoads(Eigen::Ref<Eigen::MatrixXd> loads) const override {
    loads = (inverse_ * loads).eval();
  }
  Matrix3d PointCompliance(const SparseRow& b) const override { return PointBlock(inverse_, b); }
  const Eigen::MatrixXd& inverse() const { return inverse_; }

 private:
  Eigen::MatrixXd inverse_;
};

// A grasp of three points and a press, on a lattice of random stiffness. The reference methods
// below use dense matrices of all rows.
class TipComplianceTest : public testing::Test {
 protected:
  struct Row {
    int tip;
    Eigen::RowVectorXd weights;
    Matrix3d C_loc;
    Vector3d x_W, force_W;
  };

  TipComplianceTest() {
    std::srand(1);
    const Eigen::MatrixXd root = Eigen::MatrixXd::Random(3 * kControlPoints, 3 * kControlPoints);
    lattice_.emplace(
        1e-3 * (root * root.transpose() + Eigen::MatrixXd::Identity(root.rows(), root.cols())));
  }
  void Add(int tip, double local) {
    const Matrix3d C_loc = local * Matrix3d::Identity();
    rows_.push_back({tip, Eigen::RowVectorXd::Random(kControlPoints), C_loc, Vector3d::Random(),
                     Vector3d::Random()});
  }
  void Condense() {
    for (const Row& row : rows_) {
      if (row.tip == tips_.size()) tips_.AddTip();
      tips_.AddRow(row.C_loc, row.x_W, row.force_W) = row.weights;
    }
    tips_.Condense(*lattice_);
  }

  // 3 x 3n: the displacement of a point by those of the control points.
  static Eigen::MatrixXd Expand(const Eigen::RowVectorXd& weights) {
    Eigen::MatrixXd b = Eigen::MatrixXd::Zero(3, 3 * kControlPoints);
    for (int a = 0; a < kControlPoints; ++a) {
      b.middleCols<3>(3 * a) = weights[a] * Matrix3d::Identity();
    }
    return b;
  }
  // The rows' forces and the tips' displacements, 3 each.
  struct Answer {
    Eigen::VectorXd rows, tips;
  };
  // Solves for a force on each tip, which moves its rows alike: C_rows r = T d,  T^T r = forces.
  Answer Respond(const Eigen::VectorXd& forces) const {
    const Eigen::Index m = 3 * static_cast<Eigen::Index>(rows_.size()), t = forces.size();
    Eigen::MatrixXd B(m, 3 * kControlPoints);
    Eigen::MatrixXd system = Eigen::MatrixXd::Zero(m + t, m + t);
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const auto at = 3 * static_cast<Eigen::Index>(i);
      B.middleRows<3>(at) = Expand(rows_[i].weights);
      system.block<3, 3>(at, at) = rows_[i].C_loc;
      system.block<3, 3>(at, m + 3 * rows_[i].tip) = -Matrix3d::Identity();
      system.block<3, 3>(m + 3 * rows_[i].tip, at) = Matrix3d::Identity();
    }
    system.topLeftCorner(m, m) += B * lattice_->inverse() * B.transpose();
    Eigen::VectorXd right = Eigen::VectorXd::Zero(m + t);
    right.tail(t) = forces;
    const Eigen::VectorXd solution = system.fullPivLu().solve(right);
    return {solution.head(m), solution.tail(t)};
  }
  // The displacement of a surface point under the rows' forces.
  Vector3d Displacement(const Eigen::RowVectorXd& weights, const Eigen::VectorXd& forces) const {
    Eigen::VectorXd loads = Eigen::VectorXd::Zero(3 * kControlPoints);
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      loads += Expand(rows_[i].weights).transpose() *
               forces.segment<3>(3 * static_cast<Eigen::Index>(i));
    }
    return Expand(weights) * (lattice_->inverse() * loads);
  }
  SparseRow Sparse(const Eigen::RowVectorXd& weights) {
    for (int a = 0; a < kControlPoints; ++a) {
      columns_[a] = a;
      values_[a] = weights[a];
    }
    return {columns_, values_};
  }

  std::optional<DenseCompliance> lattice_;
  std::vector<Row> rows_;
  TipCompliance tips_{kControlPoints};
  std::array<int, kControlPoints> columns_;
  std::array<double, kControlPoints> values_;
};

// The weights of another surface point.
const Eigen::RowVectorXd kPoint = Eigen::RowVectorXd::LinSpaced(kControlPoints, -1, 1);
constexpr double kRowPad = 1e-6;  // relative: the pad of 1e-9 times the condition of the rows

TEST_F(TipComplianceTest, PressesHaveTheComplianceOfTheirRows) {
  Add(0, 2e-3);
  Add(1, 1e-3);
  Condense();
  for (int a = 0; a < 2; ++a) {
    for (int c = 0; c < 2; ++c) {
      Matrix3d expected =
          Expand(rows_[a].weights) * lattice_->inverse() * Expand(rows_[c].weights).transpose();
      if (a == c) expected += rows_[a].C_loc;
      EXPECT_LT((tips_.Between(a, c) - expected).norm(), 1e-13);  // round-off
    }
    EXPECT_EQ(tips_[a].x_W, rows_[a].x_W);
    EXPECT_EQ(tips_[a].force_W, rows_[a].force_W);
  }
}

TEST_F(TipComplianceTest, AGraspMovesItsPointsAlikeUnderAForce) {
  for (int i = 0; i < 3; ++i) Add(0, 1e-3);
  Add(1, 2e-3);
  Condense();
  for (int axis = 0; axis < 6; ++axis) {
    const Answer answer = Respond(Eigen::VectorXd::Unit(6, axis));
    const int tip = axis / 3, d = axis % 3;
    for (int a = 0; a < 2; ++a) {
      EXPECT_LT((tips_.Between(a, tip).col(d) - answer.tips.segment<3>(3 * a)).norm(),
                kRowPad * answer.tips.norm());
    }
    const Vector3d followed = Displacement(kPoint, answer.rows);
    EXPECT_LT((tips_.Coupling(Sparse(kPoint), tip).col(d) - followed).norm(),
              kRowPad * followed.norm());
  }
}

TEST_F(TipComplianceTest, ReleasedTipsAndPointsGoBackToRest) {
  for (int i = 0; i < 3; ++i) Add(0, 1e-3);
  Add(1, 2e-3);
  const Vector3d rest[] = {Vector3d(0.1, 0.2, 0.3), Vector3d(-0.2, 0.1, 0)};
  Eigen::VectorXd forces(6);
  forces << 2, -1, 3, 0.5, 0, -4;
  const Answer answer = Respond(forces);
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const int tip = rows_[i].tip;
    rows_[i].force_W = answer.rows.segment<3>(3 * static_cast<Eigen::Index>(i));
    rows_[i].x_W = rest[tip] + answer.tips.segment<3>(3 * tip);
  }
  Condense();
  for (int tip = 0; tip < 2; ++tip) {
    EXPECT_LT((tips_[tip].force_W - forces.segment<3>(3 * tip)).norm(), 1e-9);
    EXPECT_LT((tips_[tip].p_original_W - rest[tip]).norm(), kRowPad * answer.tips.norm());
  }
  const Vector3d x = rest[0] + Displacement(kPoint, answer.rows);
  EXPECT_LT((tips_.Released(Sparse(kPoint), x) - rest[0]).norm(), kRowPad * answer.tips.norm());
}

// The jaws move the rows by theta x r_i; C_rows is built here from dense matrices.
TEST_F(TipComplianceTest, ARotationOfTheJawsNeedsTheForceOfItsTurn) {
  for (int i = 0; i < 3; ++i) Add(0, 1e-3);
  Condense();
  Eigen::MatrixXd B(9, 3 * kControlPoints);
  for (int i = 0; i < 3; ++i) B.middleRows<3>(3 * i) = Expand(rows_[ToSize(i)].weights);
  const Eigen::MatrixXd C_rows =
      B * lattice_->inverse() * B.transpose() + 1e-3 * Eigen::MatrixXd::Identity(9, 9);
  const Vector3d theta(0.3, -0.2, 0.5);
  Eigen::VectorXd way(9);
  for (int i = 0; i < 3; ++i) {
    way.segment<3>(3 * i) = theta.cross(rows_[ToSize(i)].x_W - tips_[0].x_W);
  }
  const Eigen::VectorXd forces = C_rows.ldlt().solve(way);
  const Vector3d force = forces.segment<3>(0) + forces.segment<3>(3) + forces.segment<3>(6);
  const Vector3d by_turn = tips_.Between(0, 0).inverse() * (tips_[0].turn_W * theta);
  ASSERT_GT(force.norm(), 0.01 * forces.norm());
  EXPECT_LT((by_turn - force).norm(), 1e-6 * forces.norm());
}

}  // namespace
}  // namespace hpdm
