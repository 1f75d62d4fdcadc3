#include "engine/reference_fem/tetra_fem.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <fstream>
#include <random>

#include "engine/base/error.h"
#include "engine/reference_fem/tetra_solver.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

MaterialOptions Material(double young, double poisson) {
  MaterialOptions material;
  material.young = young;
  material.poisson = poisson;
  return material;
}

/// A box whose inner nodes are shifted, so that no two elements are alike.
TetraMesh DistortedBox(bool quadratic) {
  TetraMesh mesh = BoxTetraMesh(Vector3d(0, 0, 0), Vector3d(0.3, 0.2, 0.2), {3, 2, 2});
  std::mt19937 random(1);
  std::uniform_real_distribution<double> shift(-0.02, 0.02);
  for (Eigen::Index n = 0; n < mesh.nodes.rows(); ++n) {
    for (int d = 0; d < 3; ++d) mesh.nodes(n, d) += shift(random);
  }
  mesh = MakeTetraMesh(mesh.nodes, mesh.elements, "test");
  return quadratic ? Quadratic(mesh) : mesh;
}

Points RandomDisplacements(Eigen::Index nodes, double size) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> value(-size, size);
  Points u(nodes, 3);
  for (Eigen::Index i = 0; i < u.size(); ++i) u.data()[i] = value(random);
  return u;
}

struct Kind {
  bool quadratic;
  TetraLaw law;
};
class TetraFemTest : public testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(Elements, TetraFemTest,
                         testing::Values(Kind{false, TetraLaw::kSmallStrain},
                                         Kind{true, TetraLaw::kSmallStrain},
                                         Kind{false, TetraLaw::kNeoHookean},
                                         Kind{true, TetraLaw::kNeoHookean}));

TEST_P(TetraFemTest, GradientAndHessianAreDerivatives) {
  const TetraBody body(DistortedBox(GetParam().quadratic), Material(5000, 0.45), GetParam().law);
  const Eigen::Index nodes = body.mesh().nodes.rows();
  // 0.05 m inverts some elements, which the Neo-Hookean law must survive.
  const Points u = RandomDisplacements(nodes, 0.05);
  const Points direction = RandomDisplacements(nodes, 1).rowwise().reverse();
  constexpr double kStep = 1e-6;  // m; central differences: error about kStep^2
  const Points ahead = u + kStep * direction, behind = u - kStep * direction;
  const Points gradient = body.Gradient(u);
  const double slope = (body.Energy(ahead) - body.Energy(behind)) / (2 * kStep);
  EXPECT_NEAR(gradient.cwiseProduct(direction).sum(), slope, 1e-6 * std::abs(slope));
  BlockMatrix K = EmptyProblem(body).springs;
  body.SetHessian(u, false, &K);
  Points product;
  K.Multiply(direction, &product);
  const Points difference = (body.Gradient(ahead) - body.Gradient(behind)) / (2 * kStep);
  EXPECT_LT((product - difference).norm(), 1e-6 * difference.norm());
}

TEST_P(TetraFemTest, RestCostsNothingAndNoForce) {
  const TetraBody body(DistortedBox(GetParam().quadratic), Material(5000, 0.3), GetParam().law);
  const Points rest = Points::Zero(body.mesh().nodes.rows(), 3);
  // Young's modulus x area is 200 N: rounding of 1e-13 of it.
  EXPECT_LT(body.Gradient(rest).norm(), 1e-11);
  EXPECT_NEAR(body.Energy(rest), 0, 1e-12);
}

TEST_P(TetraFemTest, TangentAtRestIsHookesLaw) {
  const TetraMesh mesh = DistortedBox(GetParam().quadratic);
  const TetraBody body(mesh, Material(5000, 0.45), GetParam().law);
  const TetraBody hooke(mesh, Material(5000, 0.45), TetraLaw::kSmallStrain);
  const Points rest = Points::Zero(mesh.nodes.rows(), 3);
  const Points direction = RandomDisplacements(mesh.nodes.rows(), 1);
  BlockMatrix K = EmptyProblem(body).springs, K_hooke = K;
  body.SetHessian(rest, false, &K);
  hooke.SetHessian(rest, false, &K_hooke);
  Points a, b;
  K.Multiply(direction, &a);
  K_hooke.Multiply(direction, &b);
  EXPECT_LT((a - b).norm(), 1e-12 * b.norm());  // rounding
}

TEST_P(TetraFemTest, LinearMapsPassThePatchTest) {
  // A constant strain is in balance at every inner node, however the elements are shaped.
  TetraMesh mesh = BoxTetraMesh(Vector3d(0, 0, 0), Vector3d(0.3, 0.3, 0.3), {3, 3, 3});
  std::mt19937 random(3);
  std::uniform_real_distribution<double> shift(-0.02, 0.02);
  const auto inner = [&](const Vector3d& p) {
    return p.minCoeff() > 0.05 && p.maxCoeff() < 0.25;  // nodes at 0.1 and 0.2, shifted
  };
  for (Eigen::Index n = 0; n < mesh.nodes.rows(); ++n) {
    if (!inner(mesh.nodes.row(n).transpose())) continue;
    for (int d = 0; d < 3; ++d) mesh.nodes(n, d) += shift(random);
  }
  if (GetParam().quadratic) mesh = Quadratic(mesh);
  const TetraBody body(mesh, Material(5000, 0.45), GetParam().law);
  Matrix3d A;
  A << 0.1, 0.05, -0.02, 0.01, -0.08, 0.03, 0.04, 0, 0.06;
  const Points gradient = body.Gradient(body.mesh().nodes * A.transpose());
  double most = 0, inside = 0;
  for (Eigen::Index n = 0; n < gradient.rows(); ++n) {
    most = std::max(most, gradient.row(n).norm());
    if (inner(mesh.nodes.row(n).transpose())) inside = std::max(inside, gradient.row(n).norm());
  }
  EXPECT_LT(inside, 1e-12 * most);  // rounding
}

TEST(TetraFem, RotationCostsNothingInFiniteStrain) {
  const TetraBody body(DistortedBox(true), Material(5000, 0.45), TetraLaw::kNeoHookean);
  const Points u = RandomDisplacements(body.mesh().nodes.rows(), 0.01);
  const Isometry3d X = SomePose();
  const Points moved = (body.mesh().nodes + u) * X.linear().transpose();
  const Points turned = (moved.rowwise() + X.translation().transpose()) - body.mesh().nodes;
  EXPECT_NEAR(body.Energy(turned), body.Energy(u), 1e-9 * body.Energy(u));
  const Points force = body.Gradient(u) * X.linear().transpose();
  EXPECT_LT((body.Gradient(turned) - force).norm(), 1e-9 * force.norm());
}

/// Tetrahedra between concentric triangulated spheres: each prism between two layers is split along
/// the diagonals that start at the lower vertex number, so that neighbours agree.
TetraMesh SphericalShell(double inner, double outer, int splits, int layers) {
  const SurfaceMesh sphere = Ellipsoid(Vector3d::Ones(), splits);
  const int count = static_cast<int>(sphere.vertices.rows());
  Points nodes(count * (layers + 1), 3);
  for (int l = 0; l <= layers; ++l) {
    nodes.middleRows(l * count, count) =
        sphere.vertices * (inner * std::pow(outer / inner, static_cast<double>(l) / layers));
  }
  Tetrahedra elements(sphere.triangles.rows() * layers * 3, 4);
  Eigen::Index next = 0;
  for (Eigen::Index t = 0; t < sphere.triangles.rows(); ++t) {
    std::array<int, 3> v = {sphere.triangles(t, 0), sphere.triangles(t, 1), sphere.triangles(t, 2)};
    std::sort(v.begin(), v.end());
    for (int l = 0; l < layers; ++l) {
      const int low = l * count, high = low + count;
      elements.row(next++) << low + v[0], low + v[1], low + v[2], high + v[2];
      elements.row(next++) << low + v[0], low + v[1], high + v[1], high + v[2];
      elements.row(next++) << low + v[0], high + v[0], high + v[1], high + v[2];
    }
  }
  return MakeTetraMesh(nodes, elements, "shell");
}

/// Springs of the given stiffness (N/m) that tie a node to rest.
void Hold(int node, double stiffness, TetraProblem* problem) {
  problem->springs.At(node, node) += stiffness * Matrix3d::Identity();
}

TEST(TetraFem, HollowSphereUnderPressureIsLames) {
  constexpr double kInner = 0.05, kOuter = 0.1, kPressure = 100, kYoung = 5000, kPoisson = 0.45;
  constexpr int kLayers = 3, kSplits = 3;
  const TetraMesh mesh = Quadratic(SphericalShell(kInner, kOuter, kSplits, kLayers));
  const TetraBody body(mesh, Material(kYoung, kPoisson), TetraLaw::kSmallStrain);
  TetraProblem problem = EmptyProblem(body);
  // The pressure on the inner sphere's facets: a third of each at the middles of its sides.
  const SurfaceMesh sphere = Ellipsoid(Vector3d::Constant(kInner), kSplits);
  std::map<std::pair<int, int>, int> middle;
  for (std::size_t m = 0; m < mesh.parents.size(); ++m) {
    middle[{mesh.parents[m][0], mesh.parents[m][1]}] = mesh.corners + static_cast<int>(m);
  }
  for (Eigen::Index t = 0; t < sphere.triangles.rows(); ++t) {
    const Vector3d a = sphere.vertices.row(sphere.triangles(t, 0)),
                   b = sphere.vertices.row(sphere.triangles(t, 1)),
                   c = sphere.vertices.row(sphere.triangles(t, 2));
    for (int k = 0; k < 3; ++k) {
      const int node = middle.at(
          std::minmax(int{sphere.triangles(t, k)}, int{sphere.triangles(t, (k + 1) % 3)}));
      problem.forces.row(node) += kPressure / 6 * (b - a).cross(c - a).transpose();
    }
  }
  // Balanced: weak springs only keep it in place. 1e-3 N/m against about E x radius = 500 N/m.
  for (int n = 0; n < mesh.corners; ++n) Hold(n, 1e-3 / mesh.corners, &problem);
  const TetraSolution solution = SolveTetra(body, problem);
  ASSERT_TRUE(solution.converged);
  const double a3 = std::pow(kInner, 3), b3 = std::pow(kOuter, 3);
  const auto lame = [&](double r) {
    return kPressure * a3 / (b3 - a3) *
           ((1 - 2 * kPoisson) * r / kYoung + (1 + kPoisson) * b3 / (2 * kYoung * r * r));
  };
  const Eigen::Index layer = sphere.vertices.rows();
  for (const auto& [first, radius] : {std::pair<Eigen::Index, double>(0, kInner),
                                      std::pair<Eigen::Index, double>(kLayers * layer, kOuter)}) {
    double mean = 0;
    for (Eigen::Index n = first; n < first + layer; ++n) {
      mean += solution.u.row(n).dot(mesh.nodes.row(n)) / radius / static_cast<double>(layer);
    }
    // Facets lie up to 0.6 % inside the sphere: four times less than with a split less, as the
    // error (4.3 % with one less).
    EXPECT_NEAR(mean, lame(radius), 0.015 * lame(radius)) << "r = " << radius;
  }
}

/// A bar along x, held where x < 0, with a force spread over its end.
struct Bar {
  static constexpr double kLength = 0.2, kSide = 0.02, kHeld = 0.02;
  TetraBody body;
  TetraProblem problem;
  std::vector<int> end;

  Bar(bool quadratic, const MaterialOptions& material, TetraLaw law, const Vector3d& force,
      double scale = 1)
      : body(Mesh(quadratic, scale), material, law), problem(EmptyProblem(body)) {
    const SurfaceMesh box =
        MakeBox(scale * Vector3d(-kHeld, 0, 0), scale * Vector3d(kLength, kSide, kSide));
    SupportOptions support;
    support.region = Box{scale * Vector3d(-1, -1, -1), scale * Vector3d(0, 1, 1)};
    problem = MakeTetraProblem(body, box, {support}, {});
    TetraLoad load;
    const TetraMesh& mesh = body.mesh();
    // Equal shares are not an even traction; by Saint-Venant's principle that matters over a width.
    // Corners of a quadratic face carry nothing under even traction.
    for (int n = quadratic ? mesh.corners : 0; n < mesh.nodes.rows(); ++n) {
      if (mesh.nodes(n, 0) > scale * (kLength - 1e-9)) end.push_back(n);
    }
    for (const int n : end) load.patch.emplace_back(n, 1.0 / static_cast<double>(end.size()));
    load.force = force;
    problem.loads.push_back(load);
  }

 private:
  static TetraMesh Mesh(bool quadratic, double scale) {
    const TetraMesh mesh = BoxTetraMesh(scale * Vector3d(-kHeld, 0, 0),
                                        scale * Vector3d(kLength, kSide, kSide), {22, 2, 2});
    return quadratic ? Quadratic(mesh) : mesh;
  }
};

TEST(TetraFem, PulledBarIsHookes) {
  constexpr double kYoung = 5000, kForce = 0.02;
  for (const bool quadratic : {false, true}) {
    const Bar bar(quadratic, Material(kYoung, 0.3), TetraLaw::kSmallStrain, Vector3d(kForce, 0, 0));
    const TetraSolution solution = SolveTetra(bar.body, bar.problem);
    ASSERT_TRUE(solution.converged);
    const double stretch = kForce * Bar::kLength / (kYoung * Bar::kSide * Bar::kSide);
    // The clamp holds the bar's sides over about its width, 10 % of its length, by a tenth.
    EXPECT_NEAR(solution.displacements[0].x(), stretch, 0.02 * stretch);
  }
}

TEST(TetraFem, CantileverIsTimoshenkos) {
  constexpr double kYoung = 5000, kPoisson = 0, kForce = 1e-4;
  const Bar beam(true, Material(kYoung, kPoisson), TetraLaw::kSmallStrain, Vector3d(0, 0, kForce));
  const TetraSolution solution = SolveTetra(beam.body, beam.problem);
  ASSERT_TRUE(solution.converged);
  const double L = Bar::kLength, area = Bar::kSide * Bar::kSide, I = area * area / 12;
  const double shear = kYoung / (2 * (1 + kPoisson));
  const double kappa = 10 * (1 + kPoisson) / (12 + 11 * kPoisson);  // Cowper 1966
  const double sag = kForce * L * L * L / (3 * kYoung * I) + kForce * L / (kappa * shear * area);
  // Without a Poisson effect the clamp hinders warping only, over about one width.
  EXPECT_NEAR(solution.displacements[0].z(), sag, 0.005 * sag);
}

TEST(TetraFem, ScaledBodyTakesTheSameShape) {
  // Lengths x 1,000 and forces x 1e6 leave all strains as they were.
  for (const TetraLaw law : {TetraLaw::kSmallStrain, TetraLaw::kNeoHookean}) {
    const Vector3d force(0.02, 0, 0.003);
    TetraSolveOptions options;
    options.tolerance = 1e-9;
    const Bar bar(true, Material(5000, 0.45), law, force);
    const Bar large(true, Material(5000, 0.45), law, 1e6 * force, 1000);
    const TetraSolution a = SolveTetra(bar.body, bar.problem, options);
    const TetraSolution b = SolveTetra(large.body, large.problem, options);
    ASSERT_TRUE(a.converged && b.converged);
    EXPECT_LT((b.u - 1000 * a.u).norm(), 1e-6 * b.u.norm());
  }
}

TEST(TetraFem, SmallLoadsAgreeBetweenTheLaws) {
  const Vector3d force(0, 0, 1e-5);  // a sag of 0.4 mm on 0.2 m
  const Bar small(true, Material(5000, 0.45), TetraLaw::kSmallStrain, force);
  const Bar finite(true, Material(5000, 0.45), TetraLaw::kNeoHookean, force);
  const TetraSolution a = SolveTetra(small.body, small.problem);
  const TetraSolution b = SolveTetra(finite.body, finite.problem);
  ASSERT_TRUE(a.converged && b.converged);
  // They differ by terms quadratic in the slope, 3e-3.
  EXPECT_LT((b.u - a.u).norm(), 2e-3 * a.u.norm());
}

TEST(TetraFem, PrescribedMeanDisplacementReturnsItsForce) {
  // The force that moves the end by what a force moved it is that force, at large bending.
  const Vector3d force(0, 0, 2e-3);
  for (const TetraLaw law : {TetraLaw::kSmallStrain, TetraLaw::kNeoHookean}) {
    Bar bar(true, Material(5000, 0.45), law, force);
    const TetraSolution pushed = SolveTetra(bar.body, bar.problem);
    ASSERT_TRUE(pushed.converged);
    bar.problem.loads[0].force.reset();
    bar.problem.loads[0].displacement = pushed.displacements[0];
    TetraSolveOptions options;
    options.load_steps = law == TetraLaw::kSmallStrain ? 1 : 4;
    const TetraSolution moved = SolveTetra(bar.body, bar.problem, options);
    ASSERT_TRUE(moved.converged);
    EXPECT_LT((moved.forces[0] - force).norm(), 1e-4 * force.norm());  // both to 1e-7 in force
    EXPECT_NEAR(moved.Compliance(), pushed.Compliance(), 1e-4 * pushed.Compliance());
  }
}

TEST(TetraFem, UnheldBodyIsRefused) {
  const TetraBody body(DistortedBox(false), Material(5000, 0.3), TetraLaw::kSmallStrain);
  TetraProblem problem = EmptyProblem(body);
  problem.forces(0, 0) = 1;
  EXPECT_THROW(SolveTetra(body, problem), InputError);
}

TEST(TetraLaw, ConvexTangentKeepsThePositivePart) {
  const TetraMaterial material(Material(5000, 0.45), TetraLaw::kNeoHookean);
  const Matrix3d squeezed = Vector3d(0.3, 1, 1).asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix9d> exact(material.Tangent(squeezed, false));
  const Eigen::SelfAdjointEigenSolver<Matrix9d> convex(material.Tangent(squeezed, true));
  ASSERT_LT(exact.eigenvalues()[0], 0);  // so that there is something to remove
  EXPECT_LT((convex.eigenvalues() - exact.eigenvalues().cwiseMax(0.0)).norm(),
            1e-12 * exact.eigenvalues().norm());  // rounding
}

TEST(TetraMesh, FaultyGmshFilesAreRefused) {
  const std::string head = "$NOD\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$ENDNOD\n$ELM\n1\n";
  const std::string path = testing::TempDir() + "hpdm_tetra.msh";
  const auto read = [&](const std::string& text) {
    std::ofstream(path) << text;
    return ReadGmsh(path);
  };
  EXPECT_NEAR(TetraVolume(read(head + "1 4 1 1 4 1 2 3 4\n$ENDELM\n")), 1.0 / 6, 1e-15);
  EXPECT_NEAR(TetraVolume(read(head + "1 4 1 1 4 1 3 2 4\n")), 1.0 / 6, 1e-15);  // turned round
  EXPECT_THROW(read(head), InputError);                                          // ends early
  EXPECT_THROW(read(head + "1 4 1 1 4 1 2 3 9\n"), InputError);                  // no such node
  EXPECT_THROW(read(head + "1 4 1 1 4 1 2 3 3\n"), InputError);                  // no volume
  EXPECT_THROW(read("$NOD\n999999999\n"), InputError);                           // senseless count
  EXPECT_THROW(read(""), InputError);
  EXPECT_THROW(ReadGmsh("/nonexistent.msh"), InputError);
}

TEST(TetraMesh, PointsAreFoundAndAffineFieldsInterpolated) {
  const TetraMesh mesh = DistortedBox(true);
  Points points = RandomDisplacements(200, 0.12);  // some of them outside
  points.rowwise() += Eigen::RowVector3d(0.15, 0.1, 0.1);
  Matrix3d A;
  A << 1, 2, 3, -4, 5, 6, 7, 8, -9;
  const Points values = ApplyRows(PointRows(mesh, points), mesh.nodes * A);
  EXPECT_LT((values - points * A).norm(), 1e-12 * values.norm());  // rounding
  int outside = 0;
  for (const TetraPoint& point : Locate(mesh, points)) outside += point.distance > 0;
  EXPECT_GT(outside, 0);
  EXPECT_LT(outside, 150);
}

}  // namespace
}  // namespace hpdm
