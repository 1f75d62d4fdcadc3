#include "engine/contact/footprint.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <memory>
#include <vector>

#include "engine/organ/organ_state.h"
#include "tools/haptics/bonded_disc.h"

namespace hpdm {
namespace {

// Stiffness of a tied footprint for the translation (N/m) and the rotation about `centre` (N m).
Eigen::Matrix<double, 6, 6> Stiffness(const OrganModel& model, const Footprint& footprint,
                                      const Vector3d& centre, OrganState* state) {
  ActiveRefinement& active = state->contacts.refinement;
  if (model.refinement_basis() != nullptr) {
    active.ChooseNearest(model.refinement_basis()->centres(), {&centre, 1},
                         LocalFunctionsOf(model.options()));
    state->relaxation->SetActiveFunctions(active);
  }
  const int m = footprint.rows();
  LocalCoupling coupling;
  FillLocalCoupling({&footprint, 1}, &coupling);
  Eigen::MatrixXd C = coupling, T(3 * m, 6);
  const Eigen::Index n = state->control_displacements.rows();
  std::vector<Eigen::RowVectorXd> rows(static_cast<std::size_t>(m), Eigen::RowVectorXd::Zero(n));
  for (int k = 0; k < m; ++k) footprint.AddToRow(k, model, active, rows[ToSize(k)]);
  Eigen::MatrixXd response(3 * n, 3);
  for (int k = 0; k < m; ++k) {
    const SparseRow b = state->tips.Compress(rows[ToSize(k)]);
    state->relaxation->compliance()->RespondTo(b, response);
    for (int l = 0; l < m; ++l) {
      for (Eigen::Index a = 0; a < n; ++a) {
        C.block<3, 3>(3 * l, 3 * k) += rows[ToSize(l)][a] * response.middleRows<3>(3 * a);
      }
    }
    const Vector3d x = footprint.Mean(k, model.rest().vertices, model.rest().triangles) - centre;
    T.block<3, 3>(3 * k, 0).setIdentity();
    for (int d = 0; d < 3; ++d) T.block<3, 1>(3 * k, 3 + d) = Vector3d::Unit(d).cross(x);
  }
  return T.transpose() * C.ldlt().solve(T);
}

class BondedFootprint : public testing::TestWithParam<DiscCase> {};

// The closed forms are those of a half-space; the held sides of the block are 20 radii
// away and make it 3 to 4 % stiffer.
TEST_P(BondedFootprint, HasTheStiffnessOfABondedDisc) {
  const double nu = GetParam().poisson;
  const OrganModel model = DiscBlock(GetParam());
  OrganState state(model, 1);
  const Vector3d centre(0.0013, -0.0007, 0);
  const auto footprint = std::make_unique<Footprint>();
  AddDisc(model, centre, footprint.get());
  footprint->Resolve(model, 0, &state.neighbourhoods);
  const auto S = Stiffness(model, *footprint, centre, &state);
  const DiscStiffness exact = ExactDiscStiffness(nu);
  EXPECT_NEAR(S(0, 0) / exact.tangential, 1, 0.1);
  EXPECT_NEAR(S(1, 1) / exact.tangential, 1, 0.1);
  EXPECT_NEAR(S(2, 2) / exact.normal, 1, 0.1);
  EXPECT_NEAR(S(3, 3) / exact.rocking, 1, 0.1);
  EXPECT_NEAR(S(4, 4) / exact.rocking, 1, 0.1);
  EXPECT_NEAR(S(5, 5) / exact.twist, 1, 0.1);
}

INSTANTIATE_TEST_SUITE_P(, BondedFootprint,
                         testing::Values(DiscCase{0.3, 8, 4, 27}, DiscCase{0.3, 20, 4, 27},
                                         DiscCase{0.3, 41, 4, 27}, DiscCase{0.3, 20, 6, 64},
                                         DiscCase{0.3, 20, 8, 64}, DiscCase{0.45, 8, 6, 64},
                                         DiscCase{0.45, 41, 4, 27}));

TEST(Footprint, TheLocalComplianceIsPositive) {
  const OrganModel model = DiscBlock({0.3, 20, 4, 0});
  OrganState state(model, 1);
  const auto footprint = std::make_unique<Footprint>();
  AddDisc(model, Vector3d::Zero(), footprint.get());
  footprint->Resolve(model, 0, &state.neighbourhoods);
  LocalCoupling C;
  FillLocalCoupling({footprint.get(), 1}, &C);
  EXPECT_EQ(C, C.transpose());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen{Eigen::MatrixXd(C)};
  EXPECT_GT(eigen.eigenvalues().minCoeff(), 0);
}

TEST(Footprint, RowsAreMeansThatTogetherCoverAllPoints) {
  const OrganModel model = DiscBlock({0.3, 20, 4, 0});
  OrganState state(model, 1);
  const auto footprint = std::make_unique<Footprint>();
  const Vector3d centre(0.01, 0.004, 0);
  AddDisc(model, centre, footprint.get());
  footprint->Resolve(model, 0, &state.neighbourhoods);
  ASSERT_EQ(footprint->rows(), 4);
  Vector3d sum = Vector3d::Zero();
  for (int k = 0; k < 4; ++k) {
    const Vector3d mean = footprint->Mean(k, model.rest().vertices, model.rest().triangles);
    sum += mean / 4;
    // The mean of 1 + x over the disc lies at the second moment of x: a^2 / 3 (traction's density).
    EXPECT_NEAR(std::abs(mean.x() - centre.x()), kDiscRadius / 3, 0.05 * kDiscRadius);
    Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(state.control_displacements.rows());
    footprint->AddToRow(k, model, state.contacts.refinement, row);
    EXPECT_NEAR(row.sum(), 1, 1e-9);  // the lattice's functions sum to one
  }
  EXPECT_LT((sum - centre).norm(), 1e-6);
}

TEST(Footprint, OnePointHasOneRow) {
  const OrganModel model = DiscBlock({0.3, 8, 4, 0});
  OrganState state(model, 1);
  const auto footprint = std::make_unique<Footprint>();
  const SurfaceTree tree(model.rest().vertices, model.rest().triangles);
  footprint->Add({tree.Closest(Vector3d::Zero(), 1).at, {0, 0}, {0.002, 0.002}});
  footprint->Resolve(model, 0, &state.neighbourhoods);
  EXPECT_EQ(footprint->rows(), 1);
}

// Points on two sides of a square that meet: none is near the corner across.
TEST(Footprint, PointsInAnAngleHaveNoRowAtTheCornerAcross) {
  const OrganModel model = DiscBlock({0.3, 20, 4, 0});
  OrganState state(model, 1);
  const SurfaceTree tree(model.rest().vertices, model.rest().triangles);
  const double side = 0.002;
  for (const double sign_x : {-1.0, 1.0}) {
    for (const double sign_y : {-1.0, 1.0}) {
      const auto footprint = std::make_unique<Footprint>();
      for (int i = 0; i < 5; ++i) {
        for (int j = 0; j < 5; ++j) {
          if (i > 0 && j > 0) continue;
          const Eigen::Vector2d place(sign_x * side * (i - 2), sign_y * side * (j - 2));
          const Vector3d p(place.x(), place.y(), 0);
          footprint->Add({tree.Closest(p, 1).at, place, {side, side}});
        }
      }
      footprint->Resolve(model, 0, &state.neighbourhoods);
      ASSERT_EQ(footprint->rows(), 3);
      LocalCoupling C;
      FillLocalCoupling({footprint.get(), 1}, &C);
      ASSERT_TRUE(C.allFinite());
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen{Eigen::MatrixXd(C)};
      EXPECT_GT(eigen.eigenvalues().minCoeff(), 0);
      for (int k = 0; k < 3; ++k) {
        Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(state.control_displacements.rows());
        footprint->AddToRow(k, model, state.contacts.refinement, row);
        EXPECT_NEAR(row.sum(), 1, 1e-9);
      }
    }
  }
}

}  // namespace
}  // namespace hpdm
