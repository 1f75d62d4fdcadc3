#include "engine/baselines/surface_continuum.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <limits>

#include "engine/base/error.h"
#include "tests/support/counted_allocations.h"
#include "tests/support/shapes.h"
#include "tests/support/surface_rows.h"

namespace hpdm {
namespace {

constexpr double kForever = std::numeric_limits<double>::infinity();
using enum ContactConstraints::RowKind;

// A flat body with obtuse triangles in a general pose: 162 vertices.
SurfaceMesh Body(int splits = 2) {
  return Ellipsoid(Vector3d(0.1, 0.07, 0.03), splits, SomePose());
}

Eigen::VectorXd Ground(const SurfaceMesh& rest, const std::vector<SupportOptions>& supports) {
  return GroundSprings(rest, MeasureSkin(rest, "body"), supports, 2000, "body");
}

SurfaceContinuum Model(const SurfaceMesh& rest, double time_step,
                       const std::vector<SupportOptions>& supports = {OneEnd()}) {
  SurfaceContinuumOptions options;
  options.time_step = time_step;
  return SurfaceContinuum(rest, Ground(rest, supports), options, "body");
}

TEST(SurfaceContinuum, StiffnessIsSymmetricSemiDefiniteWithZeroRowSums) {
  const SurfaceMesh rest = Body(1);
  const Eigen::MatrixXd K = SurfaceStiffness(rest, VertexAreas(rest), 30, 0.003);
  const double size = K.cwiseAbs().maxCoeff();
  EXPECT_EQ((K - K.transpose()).cwiseAbs().maxCoeff(), 0);
  EXPECT_LT(K.rowwise().sum().cwiseAbs().maxCoeff(), 1e-12 * size);  // round-off
  const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(K).eigenvalues();
  EXPECT_GT(values[0], -1e-12 * size);  // round-off below zero
  EXPECT_GT(values[1], 1e-6 * size);    // one zero mode only: translation
}

TEST(SurfaceContinuum, EnergyOfASphereIsThatOfTheSmoothSurface) {
  const double R = 0.1;
  const SurfaceMesh rest = Ellipsoid(Vector3d::Constant(R), 4);
  const Eigen::VectorXd u = rest.vertices.col(0);
  const auto energy = [&](double tension, double bending) {
    const ScalarStiffness K = SurfaceStiffness(rest, VertexAreas(rest), tension, bending);
    return 0.5 * u.dot(K * u);
  };
  // u = x has |grad u|^2 = 1 - n_x^2, of mean 2/3, and Laplace u = -2 x / R^2. Chords of 0.07 R
  // take about 0.2 % of the area.
  EXPECT_NEAR(energy(30, 0) / (0.5 * 30 * 2. / 3 * 4 * M_PI * R * R), 1, 0.005);
  EXPECT_NEAR(energy(0, 0.003) / (0.5 * 0.003 * 16 * M_PI / 3), 1, 0.01);
}

// The metric energy of Terzopoulos et al., int eta |G - G0|^2 da, of a mesh moved to `p`, and its
// force by Eq. 17: minus the sum over triangles of area alpha_ij d_i phi_a d_j p.
double MetricEnergy(const SurfaceMesh& rest, const Points& p, double eta, double factor,
                    Points* forces) {
  using Frame = Eigen::Matrix<double, 3, 2>;
  double energy = 0;
  forces->setZero(p.rows(), 3);
  for (Eigen::Index t = 0; t < rest.triangles.rows(); ++t) {
    const Eigen::RowVector3i corner = rest.triangles.row(t);
    Frame X, x;  // two edges at rest and now
    for (int k = 0; k < 2; ++k) {
      X.col(k) = (rest.vertices.row(corner[k + 1]) - rest.vertices.row(corner[0])).transpose();
      x.col(k) = (p.row(corner[k + 1]) - p.row(corner[0])).transpose();
    }
    const Frame tangents = Eigen::HouseholderQR<Frame>(X).householderQ() * Frame::Identity();
    const Eigen::Matrix2d inverse = (tangents.transpose() * X).inverse();
    const double area = X.col(0).cross(X.col(1)).norm() / 2;
    const Frame gradient = x * inverse;  // columns d_j p, in coordinates where G0 is the identity
    const Eigen::Matrix2d change = gradient.transpose() * gradient - Eigen::Matrix2d::Identity();
    energy += area * eta * change.squaredNorm();
    const Frame stress = factor * eta * area * gradient * change * inverse.transpose();
    for (int k = 0; k < 2; ++k) {
      forces->row(corner[k + 1]) -= stress.col(k).transpose();
      forces->row(corner[0]) += stress.col(k).transpose();
    }
  }
  return energy;
}

TEST(SurfaceContinuum, TheMetricsWeightIsFourEtaTimesItsChange) {
  // This is why the header differs from the printed alpha = eta (G - G0).
  const SurfaceMesh rest = Body(1);
  srand(3);
  const Points p = rest.vertices + 0.005 * Points::Random(rest.vertices.rows(), 3);
  const Points direction = Points::Random(p.rows(), 3);
  Points forces, unused;
  MetricEnergy(rest, p, 5, 4, &forces);
  const double step = 1e-6;  // m: truncation and round-off are both below 1e-6 of the slope
  const double slope = (MetricEnergy(rest, p + step * direction, 5, 4, &unused) -
                        MetricEnergy(rest, p - step * direction, 5, 4, &unused)) /
                       (2 * step);
  EXPECT_NEAR(-forces.cwiseProduct(direction).sum() / slope, 1, 1e-6);
}

TEST(SurfaceContinuum, SmallGrowthCostsWhatTheMetricEnergySays) {
  const SurfaceMesh rest = Body();
  const double growth = 1e-6, eta = 5;
  const Points u = growth * rest.vertices;
  Points unused;
  const double metric = MetricEnergy(rest, rest.vertices + u, eta, 4, &unused);
  const ScalarStiffness K = SurfaceStiffness(rest, VertexAreas(rest), 8 * eta, 0);
  // Second-order terms of the growth, and 1e-16 / growth of round-off.
  EXPECT_NEAR(0.5 * (u.transpose() * (K * u)).trace() / metric, 1, 1e-5);
}

TEST(SurfaceContinuum, TranslationCostsNothingAndRotationDoesNot) {
  // The second half is the model's defect, shared with the lattice's "metric" energy.
  const SurfaceMesh rest = Body();
  const ScalarStiffness K = SurfaceStiffness(rest, VertexAreas(rest), 30, 0.003);
  const auto energy = [&](const Points& U) { return 0.5 * (U.transpose() * (K * U)).trace(); };
  const Points shift = Eigen::RowVector3d(0.03, -0.02, 0.01).replicate(rest.vertices.rows(), 1);
  const Matrix3d R = Eigen::AngleAxisd(0.5, Vector3d::UnitZ()).toRotationMatrix();
  const Points turn = rest.vertices * R.transpose() - rest.vertices;
  EXPECT_LT(energy(shift), 1e-12 * energy(turn));  // round-off
  EXPECT_GT(energy(turn), 1e-3);                   // J; a 1 cm press on this body costs as much
}

TEST(SurfaceContinuum, SurfaceForcesSumToZero) {
  const SurfaceMesh rest = Body();
  const ScalarStiffness K = SurfaceStiffness(rest, VertexAreas(rest), 30, 0.003);
  srand(1);
  const Points forces = K * (0.01 * Points::Random(rest.vertices.rows(), 3));
  EXPECT_LT(forces.colwise().sum().norm(), 1e-12 * forces.norm() * forces.rows());  // round-off
}

TEST(SurfaceContinuum, BodyRescaledByAThousandHasTheScaledStiffness) {
  SurfaceMesh rest = Body(1);
  const Eigen::MatrixXd K = SurfaceStiffness(rest, VertexAreas(rest), 30, 0.003);
  rest.vertices *= 1000;
  // tension keeps its unit N/m; bending grows by the square of the length.
  const Eigen::MatrixXd large = SurfaceStiffness(rest, VertexAreas(rest), 30, 0.003e6);
  EXPECT_LT((large - K).norm(), 1e-9 * K.norm());
}

TEST(SurfaceContinuum, RestIsEquilibrium) {
  const SurfaceMesh rest = Body();
  for (const double dt : {1e-3, 1. / 30, kForever}) {
    SurfaceContinuum model = Model(rest, dt);
    ContactConstraints contacts(static_cast<int>(rest.vertices.rows()));
    Points U = Points::Constant(rest.vertices.rows(), 3, 0.01);
    for (int step = 0; step < 10; ++step) EXPECT_EQ(model.Relax(&contacts, &U).residual, 0);
    EXPECT_EQ(U.norm(), 0);
  }
}

TEST(SurfaceContinuum, OneStepIsTheSemiImplicitSchemeSolvedDensely) {
  const SurfaceMesh rest = Body(1);
  const double dt = 0.02, damping = 20;
  SurfaceContinuum model = Model(rest, dt);
  srand(1);
  const Points u0 = 0.01 * Points::Random(rest.vertices.rows(), 3);
  model.Reset(u0);
  ContactConstraints contacts(static_cast<int>(rest.vertices.rows()));
  Points u1, u2;
  model.Relax(&contacts, &u1);
  model.Relax(&contacts, &u2);
  const Eigen::VectorXd m = 1060 * MeasureSkin(rest, "body").Volumes();
  const Eigen::MatrixXd K = model.stiffness();
  const Eigen::MatrixXd M = m.asDiagonal();
  const Eigen::MatrixXd A = K + M / (dt * dt) + damping * M / (2 * dt);
  const Points v1 = (u1 - u0) / dt;
  const Points g = (M / (dt * dt) + damping * M / (2 * dt)) * u1 + (M / dt - damping * M / 2) * v1;
  const Points expected = A.partialPivLu().solve(Eigen::MatrixXd(g));
  EXPECT_LT((u2 - expected).norm(), 1e-10 * expected.norm());  // round-off times the condition
}

TEST(SurfaceContinuum, ContactsHoldExactlyAfterEveryStep) {
  const SurfaceMesh rest = Body();
  const int v = FarEnd(rest);
  for (const double dt : {1e-3, 1. / 30, kForever}) {
    SurfaceContinuum model = Model(rest, dt);
    ContactConstraints contacts(static_cast<int>(rest.vertices.rows()));
    AddVertex(&contacts, rest, kGrasp, v, Vector3d(0.005, 0.002, -0.01));
    AddVertex(&contacts, rest, kPress, (v + 40) % 162, Vector3d(0, 0, -0.004));
    Points U;
    for (int step = 0; step < 5; ++step) {
      EXPECT_TRUE(model.Relax(&contacts, &U).converged);
      // A part in 1e9 is the contacts' padding (contact_forces.cc).
      EXPECT_LT((U.row(v).transpose() - Vector3d(0.005, 0.002, -0.01)).norm(), 1e-9);
      EXPECT_LT(U((v + 40) % 162, 2), -0.004 + 1e-9);
    }
  }
}

TEST(SurfaceContinuum, PressesPushAndNeverPull) {
  const SurfaceMesh rest = Body();
  SurfaceContinuum model = Model(rest, kForever);
  ContactConstraints contacts(static_cast<int>(rest.vertices.rows()));
  const Vector3d n = Vector3d::UnitX();
  AddVertex(&contacts, rest, kPress, FarEnd(rest), -0.01 * n, n);
  AddVertex(&contacts, rest, kPress, 0, Vector3d(0.01, 0, 0), n);  // free
  Points U;
  const RelaxationResult result = model.Relax(&contacts, &U);
  EXPECT_LT(contacts[0].force_W.x(), -1e-3);
  EXPECT_EQ(contacts[0].force_W.tail<2>().norm(), 0);
  EXPECT_EQ(contacts[1].force_W.norm(), 0);
  EXPECT_LT(result.residual, 1e-9);  // round-off times the condition
}

TEST(SurfaceContinuum, StaticSolutionIsThatOfTheDenseRelaxation) {
  const SurfaceMesh rest = Body();
  SurfaceContinuum model = Model(rest, kForever);
  const std::unique_ptr<Relaxation> dense = MakeCholeskyRelaxation(model.stiffness());
  srand(2);
  ContactConstraints contacts(static_cast<int>(rest.vertices.rows()));
  for (int i = 0; i < 12; ++i) {
    AddVertex(&contacts, rest, i % 3 ? kPress : kGrasp, 13 * i, 0.01 * Vector3d::Random(),
              Vector3d::Random().normalized());
  }
  Points U, U_dense = Points::Zero(rest.vertices.rows(), 3);
  EXPECT_TRUE(model.Relax(&contacts, &U).converged);
  std::vector<Vector3d> forces;
  for (int i = 0; i < contacts.size(); ++i) forces.push_back(contacts[i].force_W);
  dense->Relax(&contacts, &U_dense);
  EXPECT_LT((U - U_dense).norm(), 1e-7 * U.norm());  // the padding of both, times the condition
  for (int i = 0; i < contacts.size(); ++i) {
    EXPECT_LT((forces[i] - contacts[i].force_W).norm(), 1e-6 * (1 + forces[i].norm()));
  }
}

TEST(SurfaceContinuum, SemiImplicitSchemeConvergesToTheStaticSolution) {
  const SurfaceMesh rest = Body();
  Points expected;
  ContactConstraints contacts(static_cast<int>(rest.vertices.rows()));
  AddVertex(&contacts, rest, kGrasp, FarEnd(rest), Vector3d(0.005, 0.002, -0.01));
  Model(rest, kForever).Relax(&contacts, &expected);
  const Vector3d force = contacts[0].force_W;
  for (const double dt : {0.005, 1. / 30}) {
    SurfaceContinuum model = Model(rest, dt);
    Points U;
    RelaxationResult result;
    for (double t = 0; t < 5; t += dt) result = model.Relax(&contacts, &U);
    EXPECT_LT(result.residual, 1e-6);  // 5 s are 50 times 2 / damping
    EXPECT_LT((U - expected).norm(), 1e-6 * expected.norm());
    EXPECT_LT((contacts[0].force_W - force).norm(), 1e-6 * force.norm());
  }
}

TEST(SurfaceContinuum, ReleaseReturnsToRestWhateverTheTimeStep) {
  const SurfaceMesh rest = Body();
  for (const double dt : {1e-3, 1. / 30, 1.}) {
    SurfaceContinuum model = Model(rest, dt);
    ContactConstraints contacts(static_cast<int>(rest.vertices.rows()));
    AddVertex(&contacts, rest, kGrasp, FarEnd(rest), Vector3d(0, 0, -0.03));
    Points U;
    model.Relax(&contacts, &U);
    EXPECT_NEAR(U(FarEnd(rest), 2), -0.03, 1e-9);
    contacts.Clear();
    const int steps = dt < 0.01 ? 3000 : 400;
    for (int step = 0; step < steps; ++step) model.Relax(&contacts, &U);
    EXPECT_LT(U.norm(), 1e-6) << dt;  // of 0.03
  }
}

TEST(SurfaceContinuum, FixedRegionStaysAndTheRestMoves) {
  const SurfaceMesh rest = Body();
  SurfaceContinuum model = Model(rest, kForever);
  const Eigen::VectorXd ground = Ground(rest, {OneEnd()});
  ContactConstraints contacts(static_cast<int>(rest.vertices.rows()));
  AddVertex(&contacts, rest, kGrasp, FarEnd(rest), Vector3d(0, 0, -0.01));
  Points U;
  model.Relax(&contacts, &U);
  double held = 0;
  for (Eigen::Index v = 0; v < U.rows(); ++v) {
    if (ground[v] > 0) held = std::max(held, U.row(v).norm());
  }
  // The tie of a fixed region (support.h) is soft enough to give 1 % of the press at its edge.
  EXPECT_LT(held, 0.02 * 0.01);
  // The supports balance the tool's force.
  const Vector3d reaction = (ground.asDiagonal() * U).colwise().sum();
  EXPECT_LT((reaction - contacts[0].force_W).norm(), 1e-9 * reaction.norm());
}

TEST(SurfaceContinuum, StepAllocatesNothing) {
  if (!kCountsAllocations) GTEST_SKIP() << "a sanitizer's allocator is in use";
  const SurfaceMesh rest = Body();
  SurfaceContinuum model = Model(rest, 1. / 30);
  Points U = Points::Zero(rest.vertices.rows(), 3);
  ContactConstraints contacts(static_cast<int>(rest.vertices.rows()));
  for (int i = 0; i < kMaxToolRows; ++i) {
    AddVertex(&contacts, rest, i % 2 ? kPress : kGrasp, 5 * i, Vector3d(0, 0, -0.002));
  }
  const long before = AllocationsOfThisThread();
  for (int step = 0; step < 3; ++step) model.Relax(&contacts, &U);
  contacts.Clear();
  for (int step = 0; step < 3; ++step) model.Relax(&contacts, &U);
  EXPECT_EQ(AllocationsOfThisThread(), before);
}

TEST(SurfaceContinuum, MassIsThatOfTheEnclosedTissue) {
  const SurfaceMesh rest = Body();
  EXPECT_NEAR(Model(rest, 0.01).Mass() / (1060 * EnclosedVolume(rest.vertices, rest.triangles)), 1,
              1e-12);  // round-off
}

TEST(SurfaceContinuum, StepCostGrowsNearlyLinearlyWithTheVertices) {
  // The factor of a planar graph has V log V numbers at best (George 1973), an exponent of 1.15 at
  // these sizes; minimum degree leaves 1.30. A dense factor would give 2.
  const double coarse = static_cast<double>(Model(Body(3), 0.01).StepMultiplications());
  const double fine = static_cast<double>(Model(Body(4), 0.01).StepMultiplications());
  EXPECT_LT(std::log(fine / coarse) / std::log(2562. / 642), 1.4);
}

TEST(SurfaceContinuum, ImpossibleModelsAreRefusedWithTheReason) {
  const SurfaceMesh rest = Body(1);
  const Eigen::VectorXd nothing = Eigen::VectorXd::Zero(rest.vertices.rows());
  SurfaceContinuumOptions options;
  options.time_step = kForever;
  EXPECT_THROW(SurfaceContinuum(rest, nothing, options, "body"), InputError);
  SurfaceMesh inside_out = rest;
  inside_out.triangles.col(0).swap(inside_out.triangles.col(1));
  EXPECT_THROW(MeasureSkin(inside_out, "body"), InputError);
  const SupportOptions elsewhere{Sphere{Vector3d(9, 9, 9), 0.1}, {}};
  EXPECT_THROW(Ground(rest, {elsewhere}), InputError);
}

}  // namespace
}  // namespace hpdm
