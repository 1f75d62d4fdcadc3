#include "engine/solver/refinement_basis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <numeric>
#include <vector>

#include "engine/energy/mixed_dilatation.h"
#include "tests/support/lattice_body.h"
#include "tests/support/mesh_shapes.h"

namespace hpdm {
namespace {

// The energy that refinement_basis.h describes, from the displacement gradients at the tissue's
// points: of U and V together, with what the projection does not see of V's own dilatation.
double EnergyAtPoints(const LatticeBody& body, const Lattice& finer, const Points& U,
                      const Points& V) {
  const auto [mu, lambda] = ToLame(body.material);
  const auto [pointwise, projected] = ShareLambda({mu, lambda}, Dilatation::kProjected);
  const auto coarse = body.lattice.GradientWeights(body.tissue.points),
             fine = finer.GradientWeights(body.tissue.points);
  Eigen::VectorXd own = Eigen::VectorXd::Zero(body.tissue.weights.size()), sum = own;
  double energy = 0;
  for (Eigen::Index q = 0; q < own.size(); ++q) {
    Matrix3d grad_u = Matrix3d::Zero(), grad_v = Matrix3d::Zero();
    for (int d = 0; d < 3; ++d) {
      grad_u.col(d) = (coarse[d].row(q) * U).transpose();
      grad_v.col(d) = (fine[d].row(q) * V).transpose();
    }
    const Matrix3d strain = 0.5 * (grad_u + grad_v + (grad_u + grad_v).transpose());
    own[q] = grad_v.trace();
    sum[q] = strain.trace();
    energy +=
        body.tissue.weights[q] * (mu * strain.squaredNorm() + pointwise / 2 * sum[q] * sum[q] +
                                  projected / 2 * own[q] * own[q]);
  }
  const CoarserSplines splines(body.lattice, body.tissue);
  const auto seen = [&](const Eigen::VectorXd& field) {
    return splines.Project(WeightMatrix(field.sparseView())).squaredNorm();
  };
  energy += projected / 2 * (seen(sum) - seen(own));
  for (int d = 0; d < 3; ++d) energy += 0.5 * U.col(d).dot(body.springs * U.col(d));
  return energy;
}

// Returns 1/2 |U + Y V|_K^2 + 1/2 V^T Sigma V.
double EnergyOf(const LatticeBody& body, const RefinementBasis& local, const std::vector<int>& used,
                const Points& U, const Points& V) {
  Eigen::VectorXd moved = Eigen::Map<const Eigen::VectorXd>(U.data(), U.size());
  double energy = 0;
  for (const int a : used) {
    moved += local.Coupling(a) * V.row(a).transpose();
    for (const int b : used) {
      energy += 0.5 * V.row(a) * local.ReducedStiffness(a, b) * V.row(b).transpose();
    }
  }
  return energy + 0.5 * moved.dot(body.K * moved);
}

class RefinementBasisTest : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(PoissonRatios, RefinementBasisTest, testing::Values(0.3, 0.45));

TEST_P(RefinementBasisTest, CouplingAndReducedStiffnessHoldTheEnergy) {
  const LatticeBody body(GetParam());
  const RefinementBasis local = body.Local();
  std::srand(1);
  const Points U = 1e-3 * Points::Random(body.lattice.size(), 3);
  Points V = Points::Zero(local.size(), 3);
  const std::vector<int> used = {3, 40, 41, local.size() / 2, local.size() - 5};
  for (const int a : used) V.row(a) = 1e-3 * Eigen::RowVector3d::Random();

  const double energy = EnergyOf(body, local, used, U, V);
  const double exact = EnergyAtPoints(body, local.finer(), U, V);
  // Round-off times the condition of K, and the damping of nearly dependent coarser splines.
  EXPECT_NEAR(energy, exact, 1e-7 * exact);
}

TEST_P(RefinementBasisTest, FillingsAndLayersAreInTheEnergyInFull) {
  LatticeBody body(GetParam());
  OrganOptions organ;
  organ.lumens.emplace_back().bulk_modulus = 3e4;
  organ.layers = {{.region = {}, .stiffness = 20, .poisson = 0.3, .strength = {}}};
  const SurfaceMesh hollow = Joined(body.mesh, Reversed(Ellipsoid(Vector3d(0.07, 0.05, 0.03), 2)));
  const FillingsAndLayers surface(organ, hollow, hollow.vertices, 0.01);
  surface.AddTo(body.lattice, &body.K);
  const RefinementBasis local(body.lattice, {.functions = 20, .refinement = kRefinement},
                              body.tissue, body.material, Dilatation::kProjected, {}, body.K, 0,
                              surface);
  std::srand(2);
  const Points U = 1e-3 * Points::Random(body.lattice.size(), 3);
  Points V = Points::Zero(local.size(), 3);
  // Those that change the lumen's volume most.
  const Eigen::MatrixXd filling = surface.FillingRows(local.finer());
  const auto share = [&filling](int function) {
    return filling.middleCols<3>(3 * function).norm();
  };
  std::vector<int> used(ToSize(local.size()));
  std::iota(used.begin(), used.end(), 0);
  std::ranges::sort(used, std::greater<>(), share);
  used.resize(6);
  for (const int a : used) V.row(a) = 0.1 * Eigen::RowVector3d::Random();
  const auto vector = [](const Points& points) {
    return Eigen::Map<const Eigen::VectorXd>(points.data(), points.size());
  };
  const double of_tissue = EnergyAtPoints(body, local.finer(), U, V);
  const double of_fillings = 0.5 * (surface.FillingRows(body.lattice) * vector(U) +
                                    surface.FillingRows(local.finer()) * vector(V))
                                       .squaredNorm();
  const double of_layers = 0.5 * (surface.LayerRows(body.lattice) * vector(U) +
                                  surface.LayerRows(local.finer()) * vector(V))
                                     .squaredNorm();
  EXPECT_GT(of_fillings, 1e-4 * of_tissue);
  EXPECT_GT(of_layers, 1e-4 * of_tissue);
  const double exact = of_tissue + of_fillings + of_layers;
  EXPECT_NEAR(EnergyOf(body, local, used, U, V), exact, 1e-7 * exact);
}

TEST_P(RefinementBasisTest, NoneTouchesASupportsRegion) {
  const LatticeBody body(GetParam());
  Quadrature region{body.tissue.points.topRows(200), body.tissue.weights.head(200)};
  const RefinementBasis local(body.lattice, {.functions = 20, .refinement = kRefinement},
                              body.tissue, body.material, Dilatation::kProjected, {region}, body.K);
  EXPECT_LT(local.size(), body.Local().size());
  EXPECT_EQ(local.finer().Weights(region.points).nonZeros(), 0);
}

}  // namespace
}  // namespace hpdm
