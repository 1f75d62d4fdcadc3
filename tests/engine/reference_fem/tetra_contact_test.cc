#include "engine/reference_fem/tetra_contact.h"

#include <gtest/gtest.h>

#include <cmath>

namespace hpdm {
namespace {

/// A box of tetrahedra, its nodes moved by `map`, and springs on some nodes.
struct PressedBox {
  template <typename Map>
  PressedBox(const Vector3d& low, const Vector3d& high, const std::array<int, 3>& cells,
             const MaterialOptions& material, const Map& map)
      : body(Mapped(BoxTetraMesh(low, high, cells), map), material, TetraLaw::kSmallStrain),
        problem(EmptyProblem(body)) {}

  template <typename Map>
  static TetraMesh Mapped(TetraMesh mesh, const Map& map) {
    for (Eigen::Index i = 0; i < mesh.nodes.rows(); ++i) {
      mesh.nodes.row(i) = map(Vector3d(mesh.nodes.row(i)));
    }
    return Quadratic(MakeTetraMesh(mesh.nodes, mesh.elements, "box"));
  }

  /// Holds the nodes at x_axis = value along that axis.
  void Roll(int axis, double value, double stiffness) {
    for (int i = 0; i < body.mesh().nodes.rows(); ++i) {
      if (std::abs(body.mesh().nodes(i, axis) - value) < 1e-9) {
        problem.springs.At(i, i)(axis, axis) += stiffness;
      }
    }
  }
  /// The faces all of whose nodes pass the test.
  template <typename Test>
  CondensedTetraBody Condensed(const Test& test) const {
    std::vector<TetraFace> zone;
    for (const TetraFace& face : BoundaryFaces(body.mesh())) {
      bool in = true;
      for (const int node : face) in = in && test(Vector3d(body.mesh().nodes.row(node)));
      if (in) zone.push_back(face);
    }
    return {body, problem, zone};
  }

  TetraBody body;
  TetraProblem problem;
};

const auto kAsItIs = [](const Vector3d& p) { return p; };

// Two bars of different stiffness and mesh overlap by delta and hold each other's other end: both
// shorten as springs in series, under an even pressure (patch test).
TEST(TetraContact, TwoBlocksPressEachOtherEvenlyAsBarsInSeries) {
  constexpr double kSide = 0.04, kLow = 0.05, kHigh = 0.03, kDelta = 0.0008;
  for (const double ratio : {1.0, 4.0}) {
    const MaterialOptions low{.young = 5000, .poisson = 0.3};
    const MaterialOptions high{.young = 5000 * ratio, .poisson = 0.45};
    PressedBox a(Vector3d(0, 0, -kLow), Vector3d(kSide, kSide, 0), {3, 3, 3}, low, kAsItIs);
    PressedBox b(Vector3d(0, 0, -kDelta), Vector3d(kSide, kSide, kHigh - kDelta), {4, 4, 2}, high,
                 kAsItIs);
    for (PressedBox* box : {&a, &b}) {
      for (const int axis : {0, 1}) box->Roll(axis, 0, 1e6);
    }
    a.Roll(2, -kLow, 1e6);
    b.Roll(2, kHigh - kDelta, 1e6);
    const CondensedTetraBody upper =
        b.Condensed([](const Vector3d& p) { return p.z() < 1e-9 - kDelta; });
    const CondensedTetraBody lower = a.Condensed([](const Vector3d& p) { return p.z() > -1e-9; });
    const TetraContactSolution solution = SolveTetraContact(lower, upper, {.penalty = 1e3});
    ASSERT_TRUE(solution.converged);
    const double pressure = kDelta / (kLow / low.young + kHigh / high.young);
    EXPECT_NEAR(solution.force_W.z(), pressure * kSide * kSide, 0.001 * pressure * kSide * kSide);
    // A point's own pressure alternates where the meshes do not match; that of a quarter does not.
    double quarter = 0;
    for (const TetraContactPoint& point : solution.points) {
      if (point.p_W.x() > kSide / 2 && point.p_W.y() < kSide / 2) {
        quarter += point.pressure * point.area;
      }
    }
    EXPECT_NEAR(quarter, pressure * kSide * kSide / 4, 0.02 * pressure * kSide * kSide / 4);
    // The free sides move out evenly: u_x = nu p / E x.
    const Points& nodes = a.body.mesh().nodes;
    for (Eigen::Index i = 0; i < nodes.rows(); ++i) {
      EXPECT_NEAR(solution.u[0](i, 0), 0.3 * pressure / low.young * nodes(i, 0), 0.005 * kDelta);
      EXPECT_NEAR(solution.u[0](i, 2), -pressure / low.young * (nodes(i, 2) + kLow),
                  0.005 * kDelta);
    }
  }
}

// A quarter of two equal bodies with spherical caps, by an approach of 0.01 of the effective
// radius, held 25 contact radii away.
TEST(TetraContact, TwoSpheresPressEachOtherAsHertzHasIt) {
  constexpr double kRadius = 0.1, kEffective = kRadius / 2, kApproach = 0.01 * kEffective;
  const double contact = std::sqrt(kEffective * kApproach), depth = 25 * contact;
  const MaterialOptions material{.young = 5000, .poisson = 0.3};
  const auto body = [&](double side, std::array<int, 3> cells) {
    // Graded from a sixth of the contact's radius to a third of the depth.
    const auto graded = [&](double t) {
      return contact * 25 * (std::sinh(4.6 * t) / std::sinh(4.6));
    };
    return PressedBox(
        Vector3d(0, 0, 0), Vector3d(1, 1, 1), cells, material, [&](const Vector3d& p) {
          Vector3d x(graded(p.x()), graded(p.y()), graded(p.z()));
          if (side > 0) x = Vector3d(x.y(), x.x(), x.z());
          // A mirrored box would turn the elements inside out: MakeTetraMesh turns them back.
          const double sag = (x.x() * x.x() + x.y() * x.y()) / (2 * kRadius);
          const double fade = std::max(0.0, 1 - x.z() / (0.5 * depth));
          const double far =
              std::min(1.0, 16 * contact * contact / std::max(1e-12, x.head<2>().squaredNorm()));
          x.z() = side * (x.z() + sag * fade * far - kApproach / 2);
          return x;
        });
  };
  PressedBox low = body(-1, {7, 7, 6}), high = body(1, {6, 6, 6});
  std::vector<CondensedTetraBody> zones;
  for (PressedBox* box : {&low, &high}) {
    for (const int axis : {0, 1}) box->Roll(axis, 0, 1e7);
    const double side = box == &low ? -1 : 1;
    box->Roll(2, side * (depth - kApproach / 2), 1e7);
    zones.push_back(box->Condensed([&](const Vector3d& p) {
      return p.head<2>().norm() < 3 * contact && std::abs(p.z()) < 0.2 * contact;
    }));
  }
  const TetraContactSolution solution = SolveTetraContact(zones[0], zones[1]);
  ASSERT_TRUE(solution.converged);
  const double modulus = material.young / (1 - 0.3 * 0.3) / 2;
  const double hertz = 4.0 / 3 * modulus * std::sqrt(kEffective) * std::pow(kApproach, 1.5);
  // Hertz's pressure sqrt(1 - r^2 / a^2) has the mean r^2 = 2/5 a^2.
  double moment = 0, sum = 0;
  for (const TetraContactPoint& point : solution.points) {
    moment += point.pressure * point.area * point.p_W.head<2>().squaredNorm();
    sum += point.pressure * point.area;
  }
  const double radius = std::sqrt(2.5 * moment / sum);
  RecordProperty("force_over_hertz", std::to_string(4 * solution.force_W.z() / hertz));
  RecordProperty("radius_over_hertz", std::to_string(radius / contact));
  EXPECT_NEAR(4 * solution.force_W.z(), hertz, 0.05 * hertz);
  EXPECT_NEAR(radius, contact, 0.08 * contact);
  EXPECT_LT(solution.largest_penetration, 0.01 * kApproach);
}

}  // namespace
}  // namespace hpdm
