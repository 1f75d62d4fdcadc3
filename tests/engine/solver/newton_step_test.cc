#include "engine/solver/newton_step.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>

namespace hpdm {
namespace {

// Springs of a different stiffness (N/m) along each axis of one control point.
class Springs final : public ElasticEnergy {
 public:
  explicit Springs(const Vector3d& stiffness) : stiffness_(stiffness) {}

  double Energy(const Points& U) override {
    return 0.5 * U.row(0).cwiseAbs2().dot(stiffness_.transpose());
  }
  double Gradient(const Points& U, Points* gradient) override {
    *gradient = U.row(0).cwiseProduct(stiffness_.transpose());
    return Energy(U);
  }
  std::unique_ptr<ElasticEnergy> Clone() const override {
    return std::make_unique<Springs>(stiffness_);
  }
  void Take(const ElasticEnergy& other) override { *this = static_cast<const Springs&>(other); }
  int control_points() const override { return 1; }
  void Hessian(const Points&, bool semi_definite, FullStiffness* K) override {
    Vector3d diagonal = stiffness_;
    if (semi_definite) diagonal = diagonal.cwiseMax(1e-3);
    *K = diagonal.asDiagonal();
  }
  double CollapsedShare(const Points&) override { return 0; }

 private:
  Vector3d stiffness_;
};

Points Row(double x, double y, double z) {
  Points U(1, 3);
  U << x, y, z;
  return U;
}

double Search(Springs* springs, const Points& U, const Points& step, const Points& force) {
  Points gradient(1, 3), trial(1, 3);
  const double value = springs->Gradient(U, &gradient);
  return SearchLength(U, step, value, gradient.cwiseProduct(step).sum(),
                      force.cwiseProduct(step).sum(), springs, &trial, &gradient);
}

TEST(NewtonStep, OneStepMinimisesAQuadraticPotential) {
  Springs springs(Vector3d(100, 200, 400));
  const Points U = Row(0.02, -0.01, 0.03), force = Row(1, 2, -4);
  Points gradient(1, 3);
  springs.Gradient(U, &gradient);
  NewtonFactor factor(1);
  ASSERT_TRUE(factor.Factorise(U, &springs));
  Eigen::MatrixXd column = (force - gradient).transpose();
  factor.SolveInPlace(column);
  const Points step = column.transpose();
  EXPECT_LT((U + step - Row(0.01, 0.01, -0.01)).norm(), 1e-16);  // force over stiffness
  EXPECT_EQ(Search(&springs, U, step, force), 1);
}

TEST(NewtonStep, AStepFourTimesTooLongIsHalvedTwice) {
  // Half of it ends at the mirror image, with the same energy.
  Springs springs(Vector3d(100, 100, 100));
  EXPECT_EQ(Search(&springs, Row(0.02, 0, 0), Row(-0.08, 0, 0), Row(0, 0, 0)), 0.25);
}

TEST(NewtonStep, AnUphillStepHasNoLength) {
  Springs springs(Vector3d(100, 100, 100));
  EXPECT_EQ(Search(&springs, Row(0.02, 0, 0), Row(0.02, 0, 0), Row(0, 0, 0)), 0);
  EXPECT_EQ(Search(&springs, Row(0.02, 0, 0), Row(0.02, 0, 0), Row(4, 0, 0)), 1)
      << "downhill under 4 N, whose minimum is there";
}

TEST(NewtonStep, AnIndefiniteHessianIsReplacedByItsPositivePart) {
  Springs springs(Vector3d(100, -50, 400));
  NewtonFactor factor(1);
  ASSERT_TRUE(factor.Factorise(Row(0, 0, 0), &springs));
  Eigen::MatrixXd column = Vector3d(1, 1, 1);
  factor.SolveInPlace(column);
  EXPECT_NEAR(column(0), 0.01, 1e-10);
  EXPECT_GT(column(1), 0) << "along the load";
}

TEST(NewtonStep, AHessianThatIsNotFiniteIsNotFactorised) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    for (int axis = 0; axis < 3; ++axis) {
      Vector3d stiffness(100, 200, 400);
      stiffness[axis] = bad;
      Springs springs(stiffness);
      NewtonFactor factor(1);
      EXPECT_FALSE(factor.Factorise(Row(0, 0, 0), &springs)) << bad << " along " << axis;
    }
  }
}

}  // namespace
}  // namespace hpdm
