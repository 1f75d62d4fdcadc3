// The force that the hand feels is the lattice's own: deformation loop and tip contact in lockstep.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <memory>

#include "tests/support/felt_bench.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

// The same surface with every triangle in four.
SurfaceMesh SplitFlat(const SurfaceMesh& mesh) {
  std::map<std::pair<int, int>, int> middles;
  std::vector<Vector3d> added;
  SurfaceMesh split;
  split.triangles.resize(4 * mesh.triangles.rows(), 3);
  const auto middle = [&](int a, int b) {
    const auto [it, is_new] = middles.try_emplace(
        std::minmax(a, b), static_cast<int>(mesh.vertices.rows() + added.size()));
    if (is_new) added.push_back((mesh.vertices.row(a) + mesh.vertices.row(b)).transpose() / 2);
    return it->second;
  };
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const int a = mesh.triangles(t, 0), b = mesh.triangles(t, 1), c = mesh.triangles(t, 2);
    const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    split.triangles.row(4 * t) << a, ab, ca;
    split.triangles.row(4 * t + 1) << b, bc, ab;
    split.triangles.row(4 * t + 2) << c, ca, bc;
    split.triangles.row(4 * t + 3) << ab, bc, ca;
  }
  split.vertices.resize(mesh.vertices.rows() + static_cast<Eigen::Index>(added.size()), 3);
  split.vertices.topRows(mesh.vertices.rows()) = mesh.vertices;
  for (std::size_t i = 0; i < added.size(); ++i) {
    split.vertices.row(mesh.vertices.rows() + static_cast<Eigen::Index>(i)) = added[i].transpose();
  }
  return split;
}

// Runs steps and ticks of tools at rest until both loops have the other's contact.
constexpr int kRounds = 4;

class FeltForce : public testing::TestWithParam<std::pair<SolverType, StrainMeasure>> {
 protected:
  static OrganOptions Options() {
    OrganOptions options = SoftOrgan("ellipsoid", 3);
    options.energy.solver = GetParam().first;
    options.energy.strain = GetParam().second;
    options.supports[0].region = BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)};
    return options;
  }
  FeltBench bench_{Options(), Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2), Grasper()};
  static ToolOptions Grasper() {
    ToolOptions tool;
    tool.geometries[0].can_grasp = true;
    return tool;
  }
};

// Holds from the first step of a contact, with every solver.
TEST_P(FeltForce, IsTheStepsOwnIfTheToolsHaveNotMoved) {
  for (double z = 0.056; z > 0.04; z -= 0.003) {
    const ToolPose a = FeltBench::At({0.02, 0.01, z}), c = FeltBench::At({-0.01, 0.01, z + 0.002});
    for (int i = 0; i < kRounds; ++i) {
      bench_.Step(a, c);
      bench_.Settle(a, c);
    }
    for (int t = 0; t < 2; ++t) {
      const Vector3d& force = bench_.Patch(t).force_on_tissue_W;
      // The relaxations leave 1e-6 of the deepest contact's depth, Newton's rounds 1e-4.
      EXPECT_LT((bench_.Hand(t) + force).norm(), 1e-4 * force.norm() + 1e-7) << z << ' ' << t;
    }
  }
  EXPECT_GT(bench_.Hand().z(), 0.2);
  EXPECT_GT(bench_.Hand(1).z(), 0.1);
}

// The hands push each other's tissue aside: the forces of three and four tips on one organ.
TEST_P(FeltForce, IsTheStepsOwnForAsManyHandsAsASceneHas) {
  for (const std::size_t hands : {std::size_t{3}, std::size_t{kMaxInstruments}}) {
    FeltBench bench(Options(), Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2), Grasper(), hands);
    std::vector<ToolPose> poses{
        FeltBench::At({0.02, 0.01, 0.046}), FeltBench::At({-0.012, 0.012, 0.045}),
        FeltBench::At({0.003, -0.02, 0.043}), FeltBench::At({0.045, -0.015, 0.038})};
    poses.resize(hands);
    for (int i = 0; i < 2 * kRounds; ++i) {
      bench.Step(poses);
      bench.Settle(poses);
    }
    for (std::size_t t = 0; t < hands; ++t) {
      const int tool = static_cast<int>(t);
      const Vector3d& force = bench.Patch(tool).force_on_tissue_W;
      EXPECT_GT(force.norm(), 0.05) << t << " of " << hands;
      EXPECT_LT((bench.Hand(tool) + force).norm(), 1e-4 * force.norm() + 1e-7)
          << t << " of " << hands;
    }
  }
}

TEST_P(FeltForce, AGraspBesideAPressFeelsTheStepsOwnForce) {
  const Vector3d top(0, 0, 0.0525);
  const ToolPose press = FeltBench::At({0.03, 0, 0.044});
  bench_.Step(FeltBench::At(top, 1), press);
  bench_.Step(FeltBench::At(top, 0), press);
  for (double lift = 0.003; lift < 0.013; lift += 0.003) {
    const ToolPose jaws = FeltBench::At(top + Vector3d(0.2 * lift, 0, lift), 0);
    for (int i = 0; i < kRounds; ++i) {
      bench_.Step(jaws, press);
      bench_.Settle(jaws, press);
    }
    for (int t = 0; t < 2; ++t) {
      const Vector3d& force = bench_.Patch(t).force_on_tissue_W;
      // Gauss-Seidel leaves 1e-6 of the jaws' motion between the grasped points, which are far
      // stiffer against each other than together.
      const double tolerance = GetParam().first == SolverType::kGaussSeidel ? 1e-3 : 1e-4;
      EXPECT_LT((bench_.Hand(t) + force).norm(), tolerance * force.norm() + 1e-7)
          << lift << ' ' << t;
    }
  }
  EXPECT_EQ(bench_.Patch().kind, ContactKind::kGrasp);
  EXPECT_LT(bench_.Hand().z(), -0.2);
}

// The tick reports the contact, as in a session.
TEST_P(FeltForce, JawsFeelNothingUnlessTheyClosedOnTissue) {
  const Vector3d top = bench_.Top(0, 0);
  for (const double gap : {0.001, 0.002, 0.004, -0.003}) {
    FeltBench bench(Options(), Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2), Grasper());
    Vector3d p = top + Vector3d(0, 0, kDefaultToolRadius + 0.01);
    const auto stay = [&](double jaw) {
      for (int i = 0; i < 100; ++i) bench.SessionTick(FeltBench::At(p, jaw));
    };
    stay(1);
    p.z() += gap - 0.01;
    stay(1);
    stay(0);
    p.z() += 0.01;
    stay(0);
    if (gap > 0) {
      EXPECT_EQ(bench.Patch().kind, ContactKind::kPress) << gap;
      EXPECT_EQ(bench.Hand(), Vector3d::Zero()) << gap;
    } else {  // pressed onto the tissue
      EXPECT_EQ(bench.Patch().kind, ContactKind::kGrasp) << gap;
      EXPECT_LT(bench.Hand().z(), -0.1) << gap;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Relaxations, FeltForce,
                         testing::Values(std::pair(SolverType::kCholesky, StrainMeasure::kSmall),
                                         std::pair(SolverType::kGaussSeidel, StrainMeasure::kSmall),
                                         std::pair(SolverType::kCholesky, StrainMeasure::kFinite)));

// The tick extrapolates between two steps by the compliance: it meets the next step's force.
TEST(FeltForceOfTheLiver, MeetsTheNextStepsAsTheTipGoesDeeper) {
  const OrganOptions options = SoftOrgan("liver_1332.obj", 4);
  FeltBench bench(options, Load(options));
  const ToolPose tool = bench.PressTo(bench.Top(0.03, -0.02), 0.010);
  const ToolPose deeper = FeltBench::At(tool.X_WT.translation() - Vector3d(0, 0, 0.002));
  bench.Tick(deeper);
  const Vector3d felt = bench.Hand();
  bench.Step(deeper);
  const Vector3d force = bench.Patch().force_on_tissue_W;
  // 2 mm of 10, in which the contact slips and the surface turns under it: by their linear laws.
  EXPECT_LT((felt + force).norm(), 0.02 * force.norm());
}

TEST(FeltForceOfTheLiver, DoesNotDependOnTheTriangulation) {
  const OrganOptions options = SoftOrgan("liver_1332.obj", 4);
  const SurfaceMesh coarse = Load(options);
  const SurfaceMesh fine = SplitFlat(SplitFlat(coarse));
  FeltBench on_coarse(options, coarse), on_fine(options, fine);
  const SurfaceTopology topology(coarse.vertices.rows(), coarse.triangles);
  double mean = 0;
  for (const Vector3d& at : {Vector3d(0.03, -0.02, 0), Vector3d(0.02, -0.035, 0),
                             Vector3d(0.01, -0.01, 0), Vector3d(0.045, -0.015, 0)}) {
    const SurfacePoint place =
        SurfaceTree(coarse.vertices, coarse.triangles).Closest(on_coarse.Top(at.x(), at.y()), 1).at;
    const Vector3d top = place.Position(coarse.vertices, coarse.triangles);
    const Vector3d normal = InterpolatedNormal(coarse.vertices, coarse.triangles, topology, place);
    Vector3d felt[2];
    for (int i = 0; i < 2; ++i) {
      FeltBench& bench = i == 0 ? on_coarse : on_fine;
      bench.PressTo(top, 0.010, normal);
      felt[i] = bench.Hand();
      bench.Step(FeltBench::Away());
    }
    const double difference = std::abs(felt[1].norm() / felt[0].norm() - 1);
    std::printf("F %.4f N, %.4f N on the finer surface\n", felt[0].norm(), felt[1].norm());
    mean += difference / 4;
    // The tissue's samples make the stiffness differ by 0.5 %; the thickness that bounds the
    // kernel is interpolated, and the contact slips over facets: 0.4 % at most here. The curved
    // surface over the large triangles lies up to 0.3 mm outside of the finer facets, which keep
    // their planes: 3 % of this depth.
    EXPECT_LT(difference, 0.045) << at.transpose();
  }
  std::printf("mean difference of |F|: %.2f %%\n", 100 * mean);
  EXPECT_LT(mean, 0.03);
}

// Slides 30 mm at 0.1 m/s, 10 mm deep, with the session's delay of 34 ticks.
TEST(FeltForceOfTheLiver, IsContinuousWhileTheTipSlides) {
  const OrganOptions options = SoftOrgan("liver_1332.obj", 6);
  FeltBench bench(options, Load(options));
  const Vector3d top = bench.Top(0.02, -0.02);
  const ToolPose start = bench.PressTo(top, 0.010);
  bench.Tick(start);
  Vector3d last = bench.Hand();
  double largest = 0, largest_force = 0;
  ToolPose seen = start;
  for (int tick = 1; tick <= 300; ++tick) {
    const ToolPose tool = FeltBench::At(start.X_WT.translation() + Vector3d(1e-4 * tick, 0, 0));
    if (tick % 34 == 0) {
      bench.Step(seen);
      seen = tool;
    }
    bench.Tick(tool);
    largest = std::max(largest, (bench.Hand() - last).norm());
    largest_force = std::max(largest_force, bench.Hand().norm());
    last = bench.Hand();
    ASSERT_GT(last.norm(), 0) << tick;
  }
  std::printf("slide: largest tick step %.4f N of %.3f N\n", largest, largest_force);
  // A patch knows the compliance and the turn of the surface where the contact was 3.4 to 6.8 mm
  // before; what it changes is faded in over 20 ticks. The facets turn by 0.2 rad, 7 mm apart.
  EXPECT_LT(largest, 0.015 * largest_force);
}

// A slide with friction of 35 mm, 15 mm deep. Its place follows the tip over the edges of the triangles,
// where the curvature jumps. A contact that such an edge holds back ends 27 mm behind.
TEST(FeltForceOfTheLiver, ASlideWithFrictionFollowsTheTip) {
  const OrganOptions options = SoftOrgan("liver_1332.obj", 4);
  FeltBench bench(options, Load(options));
  bench.friction = 0.3;
  const Vector3d from(0.0195, -0.0195, 0), way(-0.0115, 0.0325, 0);
  const double top = bench.Top(from.x(), from.y()).z(), end = top + kDefaultToolRadius - 0.015;
  for (double z = top + 0.003; z > end; z -= 2e-4) {
    bench.SessionTick(FeltBench::At(Vector3d(from.x(), from.y(), z)));
  }
  constexpr int kTicks = 340;
  Vector3d p = Vector3d::Zero();
  for (int i = 0; i < kTicks; ++i) {
    p = from + way * i / kTicks + Vector3d(0, 0, end);
    bench.SessionTick(FeltBench::At(p));
  }
  const TickContactPoint contact = bench.ContactPoint();
  ASSERT_GE(contact.triangle, 0);
  const SurfaceMesh& rest = bench.model().rest();
  const SurfacePoint at{contact.triangle, contact.weights};
  Vector3d lag = p - at.Position(rest.vertices, rest.triangles);
  lag.z() = 0;
  // Friction of 0.3 leaves about a third of the depth; the normals of the facets add to it.
  EXPECT_LT(lag.norm(), 0.010);
}

// The row of a press depends on the surface, not on its triangles.
TEST(FeltForceOfTheLiver, ItsLatticeRowDoesNotDependOnTheTriangulation) {
  const OrganOptions options = SoftOrgan("liver_1332.obj", 4);
  const SurfaceMesh coarse = Load(options);
  FeltBench on_coarse(options, coarse), on_fine(options, SplitFlat(SplitFlat(coarse)));
  for (const Vector3d& at : {Vector3d(0.03, -0.02, 0), Vector3d(0.02, -0.035, 0),
                             Vector3d(0.01, -0.01, 0), Vector3d(0.045, -0.015, 0)}) {
    // Near, but not yet touching: the contact is the same point of the surface.
    const ToolPose tool = FeltBench::At(on_coarse.Top(at.x(), at.y()) + Vector3d(0, 0, 0.004));
    on_coarse.Step(tool);
    on_fine.Step(tool);
    const ContactConstraints& rows = on_coarse.loop().organ(0).contacts;
    const ContactConstraints& fine_rows = on_fine.loop().organ(0).contacts;
    ASSERT_EQ(rows.size(), 1);
    ASSERT_EQ(fine_rows.size(), 1);
    // Samples of R / 4 may lie differently in large and in small triangles, and the tissue's
    // thickness, which bounds R, is interpolated between other vertices, with other normals.
    EXPECT_LT((fine_rows.Weights() - rows.Weights()).norm(), 0.04 * rows.Weights().norm());
    // The curved surface over the large triangles lies outside of the finer facets.
    EXPECT_LT((fine_rows[0].p_rest_W - rows[0].p_rest_W).norm(), 4e-4);
  }
}

// Presses deeper than the gallbladder's own radius, where the released surface has no foot below
// the tip.
TEST(FeltForceOfTheGallbladder, DoesNotJumpInADeepPress) {
  OrganOptions options = SoftOrgan("gallbladder.obj", 4);
  options.supports[0].region = BoxFraction{Vector3d(0, 0, 0), Vector3d(1, 1, 0.27)};
  FeltBench bench(options, Load(options));
  const Vector3d top = bench.Top(0.0013, 0.0047) + Vector3d(0, 0, kDefaultToolRadius);
  // Down 25 mm at 0.05 m/s, held, and back.
  double largest = 0, largest_force = 0;
  Vector3d last = Vector3d::Zero();
  ToolPose seen = FeltBench::At(top + Vector3d(0, 0, 0.005));
  bench.Step(seen);
  for (int tick = 0; tick <= 1500; ++tick) {
    const double depth = std::min({5e-5 * tick - 0.005, 0.025, 5e-5 * (1400 - tick)});
    const ToolPose tool = FeltBench::At(top - Vector3d(0, 0, depth));
    if (tick % 34 == 0) {
      bench.Step(seen);
      seen = tool;
    }
    bench.Tick(tool);
    largest = std::max(largest, (bench.Hand() - last).norm());
    largest_force = std::max(largest_force, bench.Hand().norm());
    last = bench.Hand();
  }
  std::printf("gallbladder: largest tick step %.4f N of %.3f N\n", largest, largest_force);
  EXPECT_GT(largest_force, 0.1);
  // A tick's motion of 0.05 mm makes 0.003 N at most; the rest is patches that fade in.
  EXPECT_LT(largest, 0.03 * largest_force);
}

// Jaws lift the free end of a bar by 12 mm. A second tip that comes from above meets the bar there, not where
// it would lie without the jaws.
class FeltForceBesideAGrasp : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(TipAndShaft, FeltForceBesideAGrasp, testing::Bool());

TEST_P(FeltForceBesideAGrasp, BeginsWhereTheOtherToolHasMovedTheTissue) {
  const bool by_shaft = GetParam();
  ToolOptions grasper;
  grasper.geometries[0].can_grasp = true;
  OrganOptions options = SoftOrgan("bar", 4);
  options.supports[0].region = BoxFraction{Vector3d(0.8, 0, 0), Vector3d(1, 1, 1)};
  FeltBench bench(options, Ellipsoid(Vector3d(0.05, 0.012, 0.012), 3), grasper);
  bench.feels_shaft = by_shaft;
  constexpr double kGrasped = -0.03, kPressed = -0.012;  // m
  const Vector3d top = bench.Top(kGrasped, 0) + Vector3d(0, 0, kDefaultToolRadius);
  const auto jaws = [&](double lift) { return FeltBench::At(top + Vector3d(0, 0, lift), 0); };
  // The shaft lies across the bar, along y.
  const auto probe_at = [&](double z) {
    if (!by_shaft) return FeltBench::At({kPressed, 0, z});
    ToolPose probe;
    probe.X_WT.linear() << 1, 0, 0, 0, 0, 1, 0, -1, 0;
    probe.X_WT.translation() = Vector3d(kPressed, -0.05, z);
    probe.p_trocar_W = Vector3d(kPressed, 0.2, z);
    return probe;
  };
  const double radius = by_shaft ? grasper.geometries[0].shaft_radius : kDefaultToolRadius;
  bench.Step(FeltBench::At(top, 1), FeltBench::Away());
  for (double lift = 0; lift < 0.0121; lift += 0.003) {
    bench.Step(jaws(lift), FeltBench::Away());
    bench.Settle(jaws(lift), FeltBench::Away());
  }
  double first = 0, z = 0.04;
  for (int tick = 0; first == 0 && z > 0; ++tick) {
    if (tick % 33 == 0) bench.Step(jaws(0.012), probe_at(z));
    z -= 5e-5;
    bench.Tick(jaws(0.012), probe_at(z));
    if (bench.Hand(1).norm() > 1e-3) first = z;
  }
  const OrganState& organ = bench.loop().organ(0);
  const Triangles& triangles = bench.model().rest().triangles;
  const SurfaceTree tree(organ.vertices, triangles);
  const SurfaceHit hit = tree.FirstEntry(Vector3d(kPressed, 0, 1), Vector3d(kPressed, 0, -1));
  const double lifted = hit.at.Position(organ.vertices, triangles).z();
  std::printf("first force %.1f mm over the tissue, which is lifted by %.1f mm\n",
              1e3 * (first - lifted), 1e3 * (lifted - bench.Top(kPressed, 0).z()));
  EXPECT_GT(lifted, bench.Top(kPressed, 0).z() + 0.004) << "the jaws lift it";
  EXPECT_NEAR(first - lifted, radius, 0.0015);
}

// The work of the felt force over a slow press is the energy that the lattice stores.
TEST(FeltForceOfTheLiver, DoesTheWorkThatTheLatticeStores) {
  const OrganOptions options = SoftOrgan("liver_1332.obj", 4);
  FeltBench bench(options, Load(options));
  const Vector3d top = bench.Top(0.03, -0.02) + Vector3d(0, 0, kDefaultToolRadius);
  const auto energy = [&] {
    const Points& U = bench.loop().organ(0).control_displacements;
    const Eigen::Map<const Eigen::VectorXd> u(U.data(), U.size());
    const ContactConstraints& contacts = bench.loop().organ(0).contacts;
    double sum = 0.5 * u.dot(std::get<FullStiffness>(bench.model().stiffness()) * u);
    for (int i = 0; i < contacts.size(); ++i) {  // and the indentation below its resolution
      const ContactConstraints::Row& row = contacts[i];
      const double H = row.normal_W.dot(row.indentation.factor_W() * row.normal_W);
      const double df = row.f_n() / 1000;
      for (double f = df / 2; f < row.f_n(); f += df) {
        sum += f * H * row.indentation.BallYieldRate(f) * df;
      }
    }
    return sum;
  };
  double work = 0;
  Vector3d last = Vector3d::Zero();
  for (double z = -0.003; z < 0.010; z += 1e-4) {
    const ToolPose tool = FeltBench::At(top - Vector3d(0, 0, z));
    bench.Step(tool);
    bench.Tick(tool);
    work += 0.5 * (bench.Hand() + last).dot(Vector3d(0, 0, 1e-4));
    last = bench.Hand();
  }
  EXPECT_GT(work, 1e-4);
  // The contact slips over the tissue without friction, but no farther than its tip's motion.
  EXPECT_NEAR(work, energy(), 0.03 * work);
}

}  // namespace
}  // namespace hpdm
