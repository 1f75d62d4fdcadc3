#include "engine/elastic_relaxation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "engine/organ.h"
#include "engine/support.h"
#include "tests/shapes.h"

namespace hpdm {
namespace {

constexpr MaterialLaw kBothLaws[] = {MaterialLaw::kNeoHookean, MaterialLaw::kStVenantKirchhoff};
constexpr auto kGrasp = ContactSet::RowKind::kGrasp;
constexpr auto kPress = ContactSet::RowKind::kPress;

// A 0.2 x 0.15 x 0.1 m block of 4 x 4 x 4 quadratic cells, its bottom fifth held.
class ElasticRelaxationTest : public testing::Test {
 protected:
  ElasticRelaxationTest() : contacts_(lattice_.size()), U_(Points::Zero(lattice_.size(), 3)) {
    OrientedBox bottom = lattice_.box();
    bottom.lengths.z() *= 0.2;
    supports_ = SupportStiffness(lattice_, tissue_, {SupportOptions()},
                                 {BoxQuadrature(bottom, {12, 12, 6})}, MaterialOptions().young);
  }

  FiniteStrainEnergy Energy(MaterialLaw law, bool supported = true) const {
    const ScalarStiffness none(lattice_.size(), lattice_.size());
    return {lattice_, tissue_, HyperelasticLaw(law, ToLame({})), supported ? supports_ : none};
  }
  Points Shaken(double size) const {
    srand(1);
    return size * Points::Random(lattice_.size(), 3);
  }
  void AddContact(ContactSet::RowKind kind, const Vector3d& p, const Vector3d& move) {
    ContactSet::Row* row = contacts_.Add();
    ASSERT_NE(row, nullptr);
    row->kind = kind;
    row->p_rest_W = p;
    row->target_W = p + move;
    contacts_.WeightRow(contacts_.size() - 1) = lattice_.Weights(p.transpose()).toDense().row(0);
  }
  Vector3d PositionOf(int i) const {
    return contacts_[i].p_rest_W + (contacts_.Weights().row(i) * U_).transpose();
  }

  Lattice lattice_{{Vector3d::Zero(), Matrix3d::Identity(), Vector3d(0.2, 0.15, 0.1)}, {}};
  // Cell by cell, as SampleTissue gives it.
  Quadrature tissue_ = CellByCell(lattice_.box());
  ScalarStiffness supports_;
  ContactSet contacts_;
  Points U_;

 private:
  static Quadrature CellByCell(const OrientedBox& box) {
    Quadrature all{Points(64 * 27, 3), Eigen::VectorXd(64 * 27)};
    for (int c = 0; c < 64; ++c) {
      OrientedBox cell = box;
      cell.lengths /= 4;
      cell.origin_W = box.FromUnit(Vector3d(c / 16, c / 4 % 4, c % 4) / 4);
      const Quadrature part = BoxQuadrature(cell, {3, 3, 3});
      all.points.middleRows(27 * c, 27) = part.points;
      all.weights.segment(27 * c, 27) = part.weights;
    }
    return all;
  }
};

TEST_F(ElasticRelaxationTest, GradientAndHessianAreDerivativesOfTheEnergy) {
  for (const MaterialLaw law : kBothLaws) {
    FiniteStrainEnergy energy = Energy(law);
    const Points U = Shaken(0.01), direction = Shaken(1).rowwise().reverse();
    Points gradient = U, ahead = U, behind = U;
    const double value = energy.Gradient(U, &gradient);
    EXPECT_NEAR(energy.Energy(U) / value, 1, 1e-14);
    FullStiffness K;
    energy.Hessian(U, false, &K);
    EXPECT_LT((K - K.transpose()).norm(), 1e-12 * K.norm());
    // Errors: 1e-12 of the third derivative along the unit step, 1e-16 / 1e-6 of round-off.
    constexpr double kStep = 1e-6;
    const double up = energy.Gradient(U + kStep * direction, &ahead);
    const double down = energy.Gradient(U - kStep * direction, &behind);
    EXPECT_NEAR((up - down) / (2 * kStep) / gradient.cwiseProduct(direction).sum(), 1, 1e-6);
    const Points difference = (ahead - behind) / (2 * kStep);
    const Eigen::VectorXd product =
        K * Eigen::Map<const Eigen::VectorXd>(direction.data(), direction.size());
    EXPECT_LT(
        (product - Eigen::Map<const Eigen::VectorXd>(difference.data(), difference.size())).norm(),
        1e-6 * product.norm());
  }
}

TEST_F(ElasticRelaxationTest, FiniteRotationsCostNothing) {
  const Matrix3d R = Eigen::AngleAxisd(2.1, Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  const Points X = lattice_.ControlPoints();
  for (const MaterialLaw law : kBothLaws) {
    FiniteStrainEnergy energy = Energy(law, false);
    Points turned = X * R.transpose();
    turned.rowwise() += Eigen::RowVector3d(0.3, -0.1, 0.2);
    Points gradient = X;
    const double scale = energy.Energy(Shaken(0.01));
    EXPECT_LT(std::abs(energy.Gradient(turned - X, &gradient)), 1e-9 * scale);
    EXPECT_LT(gradient.norm() * 0.01, 1e-9 * scale);
    // A deformed body that is turned as well has the same energy.
    const Points deformed = X + Shaken(0.01);
    EXPECT_NEAR(energy.Energy(deformed * R.transpose() - X) / energy.Energy(deformed - X), 1, 1e-9);
  }
}

TEST_F(ElasticRelaxationTest, HessianAtRestIsTheSmallStrainStiffness) {
  FullStiffness small = StrainStiffness(lattice_, tissue_, {}, Dilatation::kPointwise);
  AddAlongEachAxis(supports_, &small);
  for (const MaterialLaw law : kBothLaws) {
    FullStiffness K;
    Energy(law).Hessian(U_, false, &K);
    EXPECT_LT((K - small).norm(), 1e-12 * small.norm());
  }
}

TEST_F(ElasticRelaxationTest, SmallDisplacementsAgreeWithCholesky) {
  FullStiffness small = StrainStiffness(lattice_, tissue_, {}, Dilatation::kPointwise);
  AddAlongEachAxis(supports_, &small);
  AddContact(kGrasp, Vector3d(0.05, 0.05, 0.1), Vector3d(1e-6, 0, 2e-6));
  AddContact(kPress, Vector3d(0.15, 0.1, 0.1), Vector3d(0, 0, -1e-6));
  MakeCholeskyRelaxation(small)->Relax(&contacts_, &U_);
  const Points linear = U_;
  for (const MaterialLaw law : kBothLaws) {
    EXPECT_TRUE(MakeNewtonRelaxation(Energy(law))->Relax(&contacts_, &U_).converged);
    // The laws differ from the linear one by strain, about 1e-6 / 0.025 m.
    EXPECT_LT((U_ - linear).norm(), 1e-3 * linear.norm());
  }
}

TEST_F(ElasticRelaxationTest, LargeLiftsConvergeWithExactContacts) {
  for (const MaterialLaw law : kBothLaws) {
    // St. Venant-Kirchhoff softens under a point that presses 20 mm deep until it is no longer
    // convex, and then converges linearly.
    const double size = law == MaterialLaw::kNeoHookean ? 1 : 0.4;
    contacts_.Clear();
    AddContact(kGrasp, Vector3d(0.05, 0.05, 0.1), size * Vector3d(0.02, 0, 0.04));
    AddContact(kPress, Vector3d(0.15, 0.1, 0.1), size * Vector3d(0, 0, -0.02));
    AddContact(kPress, Vector3d(0.15, 0.05, 0.1), size * Vector3d(0, 0, 0.06));
    const auto newton = MakeNewtonRelaxation(Energy(law), {.max_iterations = 30});
    const RelaxationResult result = newton->Relax(&contacts_, &U_);
    EXPECT_TRUE(result.converged) << result.residual;
    EXPECT_LE(result.iterations, 8);  // 6 measured
    EXPECT_LT((PositionOf(0) - contacts_[0].target_W).norm(), 1e-9);
    EXPECT_NEAR(PositionOf(1).z(), contacts_[1].target_W.z(), 1e-9);
    EXPECT_LT(contacts_[1].force_W.z(), 0);
    EXPECT_EQ(contacts_[2].force_W.norm(), 0);  // a press never pulls
  }
}

TEST_F(ElasticRelaxationTest, ABudgetOfOneIterationHoldsTheContactsAndCatchesUp) {
  AddContact(kGrasp, Vector3d(0.05, 0.05, 0.1), Vector3d(0.01, 0, 0.03));
  const auto newton = MakeNewtonRelaxation(Energy(MaterialLaw::kNeoHookean), {.max_iterations = 1});
  RelaxationResult result;
  for (int step = 0; step < 12; ++step) {
    result = newton->Relax(&contacts_, &U_);
    EXPECT_EQ(result.iterations, 1);
    EXPECT_LT((PositionOf(0) - contacts_[0].target_W).norm(), 1e-9);
    if (step == 0) {
      EXPECT_FALSE(result.converged);
      EXPECT_GT(result.residual, 1e-3);
    }
  }
  EXPECT_TRUE(result.converged) << result.residual;
}

TEST_F(ElasticRelaxationTest, APointPushedThroughTheBodyRecovers) {
  const auto newton =
      MakeNewtonRelaxation(Energy(MaterialLaw::kNeoHookean), {.max_iterations = 40});
  // From the top through the held bottom in one step: cells turn inside out.
  AddContact(kGrasp, Vector3d(0.1, 0.07, 0.1), Vector3d(0, 0, -0.12));
  newton->Relax(&contacts_, &U_);
  EXPECT_TRUE(U_.allFinite());
  EXPECT_TRUE(contacts_[0].force_W.allFinite());
  EXPECT_LT(contacts_[0].force_W.z(), 0);
  EXPECT_NEAR(PositionOf(0).z(), -0.02, 1e-9);
  // Back to its place: the body is at rest again, from wherever it was.
  contacts_[0].target_W = contacts_[0].p_rest_W + Vector3d(0, 0, 1e-6);
  newton->Relax(&contacts_, &U_);
  EXPECT_LT(U_.norm(), 1e-4);
}

TEST(OrganModel, BuildsTheEnergyItIsAskedFor) {
  const SurfaceMesh mesh = Ellipsoid(Vector3d(0.1, 0.07, 0.05), 3);
  const Vector3d push(0, 0, -1e-5);
  std::vector<double> forces;
  for (const StrainMeasure strain : {StrainMeasure::kSmall, StrainMeasure::kFinite}) {
    OrganOptions options;
    options.energy.type = EnergyType::kStrain;
    options.energy.strain = strain;
    options.material.poisson = 0;  // the dilatation's form does not matter
    SupportOptions bottom;
    bottom.region = BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)};
    options.supports.push_back(bottom);
    const OrganModel model(options, mesh);
    OrganState state(model, 1);
    Eigen::Index top = 0;
    mesh.vertices.col(2).maxCoeff(&top);
    ContactSet::Row* row = state.contacts.Add();
    row->p_rest_W = mesh.vertices.row(top);
    row->target_W = row->p_rest_W + push;
    state.contacts.WeightRow(0) = model.weights().row(top).toDense();
    Points U = Points::Zero(model.lattice().size(), 3);
    EXPECT_TRUE(state.relaxation->Relax(&state.contacts, &U).converged);
    forces.push_back(state.contacts[0].force_W.norm());
    EXPECT_GT(forces.back(), 0);
  }
  EXPECT_NEAR(forces[1] / forces[0], 1, 1e-3);  // strain of about 1e-5 / 0.02 m
}

}  // namespace
}  // namespace hpdm
