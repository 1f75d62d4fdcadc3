// Tests a tip between two or three walls of one organ: all are felt, in step and tick.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "tests/support/felt_bench.h"
#include "tests/support/shapes.h"
#include "tools/haptics/contact_trials.h"

namespace hpdm {
namespace {

using std::numbers::pi;

constexpr double kHalfWidth = 0.04, kBottom = -0.05, kLength = 0.06, kEdge = 0.003;  // m

// A block along y with a groove in its top, z = 0. Seen along y the groove's walls rise from (0, -depth)
// at `half_angle` from the vertical.
SurfaceMesh GroovedBlock(double half_angle, double depth) {
  const double rim = depth * std::tan(half_angle);
  const std::vector<Eigen::Vector2d> corners{{-kHalfWidth, kBottom},
                                             {kHalfWidth, kBottom},
                                             {kHalfWidth, 0},
                                             {rim, 0},
                                             {0, -depth},
                                             {-rim, 0},
                                             {-kHalfWidth, 0}};
  std::vector<Eigen::Vector2d> profile;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d from = corners[i], way = corners[(i + 1) % corners.size()] - from;
    const int parts = std::max(1, static_cast<int>(std::lround(way.norm() / kEdge)));
    for (int k = 0; k < parts; ++k) profile.push_back(from + way * k / parts);
  }
  const int around = static_cast<int>(profile.size());
  const int along = static_cast<int>(std::lround(kLength / kEdge));
  SurfaceMesh mesh;
  mesh.vertices.resize((along + 1) * around + 2, 3);
  std::vector<Eigen::RowVector3i> triangles;
  for (int j = 0; j <= along; ++j) {
    for (int i = 0; i < around; ++i) {
      const Eigen::Vector2d& p = profile[static_cast<std::size_t>(i)];
      mesh.vertices.row(j * around + i) << p.x(), kLength * (double(j) / along - 0.5), p.y();
      if (j == along) continue;
      const int a = j * around + i, b = j * around + (i + 1) % around;
      triangles.emplace_back(a, b + around, b);
      triangles.emplace_back(a, a + around, b + around);
    }
  }
  for (const int end : {0, along}) {  // fans
    const int centre = (along + 1) * around + (end > 0);
    mesh.vertices.row(centre) << 0, kLength * (end > 0 ? 0.5 : -0.5), kBottom + 0.002;
    for (int i = 0; i < around; ++i) {
      const int a = end * around + i, b = end * around + (i + 1) % around;
      if (end > 0) {
        triangles.emplace_back(b, a, centre);
      } else {
        triangles.emplace_back(a, b, centre);
      }
    }
  }
  mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    mesh.triangles.row(static_cast<Eigen::Index>(t)) = triangles[t];
  }
  return mesh;
}

// A three-sided block with a three-sided pit in its top, z = 0. The pit's walls rise from (0, 0, -depth)
// at `half_angle` from the vertical; seen from above their normals lie 120 degrees apart, the first
// along -x.
SurfaceMesh PittedBlock(double half_angle, double depth) {
  const double rim = depth * std::tan(half_angle);
  // Distance of the sides from the axis, and height.
  const std::vector<Eigen::Vector2d> corners{
      {0, -depth}, {rim, 0}, {kHalfWidth, 0}, {kHalfWidth, kBottom}, {0, kBottom}};
  std::vector<Eigen::Vector2d> profile;  // without its ends, which are points on the axis
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const Eigen::Vector2d from = corners[i], way = corners[i + 1] - from;
    const int parts = std::max(1, static_cast<int>(std::lround(way.norm() / kEdge)));
    for (int k = i == 0 ? 1 : 0; k < parts; ++k) profile.push_back(from + way * k / parts);
  }
  constexpr int kAlongSide = 12;
  std::vector<Eigen::Vector2d> triangle;  // with sides at the distance 1 from the axis
  for (int side = 0; side < 3; ++side) {
    const double angle = 2 * pi * side / 3;
    const Eigen::Vector2d out(std::cos(angle), std::sin(angle)), along(-out.y(), out.x());
    for (int k = 0; k < kAlongSide; ++k) {
      triangle.push_back(out + std::sqrt(3.0) * (2.0 * k / kAlongSide - 1) * along);
    }
  }
  const auto around = static_cast<int>(triangle.size()), rings = static_cast<int>(profile.size());
  SurfaceMesh mesh;
  mesh.vertices.resize(rings * around + 2, 3);
  std::vector<Eigen::RowVector3i> triangles;
  const int apex = rings * around, bottom = apex + 1;
  mesh.vertices.row(apex) << 0, 0, -depth;
  mesh.vertices.row(bottom) << 0, 0, kBottom;
  for (int r = 0; r < rings; ++r) {
    for (int i = 0; i < around; ++i) {
      const Eigen::Vector2d p = profile[r].x() * triangle[i];
      mesh.vertices.row(r * around + i) << p.x(), p.y(), profile[r].y();
      const int a = r * around + i, b = r * around + (i + 1) % around;
      if (r == 0) triangles.emplace_back(apex, a, b);
      if (r == rings - 1) {
        triangles.emplace_back(a, bottom, b);
      } else {
        triangles.emplace_back(a, a + around, b + around);
        triangles.emplace_back(a, b + around, b);
      }
    }
  }
  mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    mesh.triangles.row(static_cast<Eigen::Index>(t)) = triangles[t];
  }
  return mesh;
}

OrganOptions GrooveOptions(bool rigid) {
  OrganOptions options = SoftOrgan("groove", 4);
  options.supports[0].region = BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.15)};
  if (!rigid) return options;
  options.model = OrganModelType::kRigid;
  options.wall_stiffness = 200;
  options.supports.clear();
  return options;
}

// Depth of a tip's ball in the wall on the side of x = side.
double WallDepth(const Vector3d& p, double side, double half_angle, double groove, double radius) {
  const Vector3d normal(-side * std::cos(half_angle), 0, std::sin(half_angle));
  return radius - normal.dot(p - Vector3d(0, 0, -groove));
}

// The force on a tip in the groove is that of the two springs. The tip comes down off the middle, so
// the walls are touched one after the other, and stays. The walls are flat up to the drawn edges, so 1 %
// is left to the last patch.
TEST(Notch, ARigidNotchGivesTheForceOfBothWalls) {
  for (const double half_angle : {0.15 * pi, 0.2 * pi}) {
    for (const double radius : {0.0025, 0.005}) {
      for (const double off : {0.0, 0.0003}) {
        const double groove = 0.015;
        FeltBench bench(GrooveOptions(true), GroovedBlock(half_angle, groove), BallTip(radius));
        const double end = -groove + (radius - 0.001) / std::sin(half_angle);
        Vector3d p(off, 0.001, end + 0.006);
        for (; p.z() > end; p.z() -= 5e-5) bench.SessionTick(FeltBench::At(p));
        for (int i = 0; i < 200; ++i) bench.SessionTick(FeltBench::At(p));
        Vector3d expected = Vector3d::Zero();
        for (const double side : {-1., 1.}) {
          const Vector3d normal(-side * std::cos(half_angle), 0, std::sin(half_angle));
          expected += 200 * WallDepth(p, side, half_angle, groove, radius) * normal;
        }
        EXPECT_LT((bench.Hand() - expected).norm(), 0.01 * expected.norm())
            << half_angle << ' ' << radius << ' ' << off << " got " << bench.Hand().transpose()
            << " expected " << expected.transpose();
      }
    }
  }
}

int Presses(const FeltBench& bench) {
  int count = 0;
  for (int p = 0; p < kMaxPlaces; ++p) {
    count += bench.Contacts().result(p).kind == ContactKind::kPress;
  }
  return count;
}

// As in the groove, with three walls. The tip comes down off the axis and nearer to one wall.
TEST(Notch, ARigidPitGivesTheForceOfItsThreeWalls) {
  const double half_angle = 0.2 * pi, pit = 0.015;
  for (const double radius : {0.0025, 0.005}) {
    FeltBench bench(GrooveOptions(true), PittedBlock(half_angle, pit), BallTip(radius));
    const double end = -pit + (radius - 0.001) / std::sin(half_angle);
    Vector3d p(0.0002, 0.0001, end + 0.006);
    for (; p.z() > end; p.z() -= 5e-5) bench.SessionTick(FeltBench::At(p));
    for (int i = 0; i < 200; ++i) bench.SessionTick(FeltBench::At(p));
    Vector3d expected = Vector3d::Zero();
    for (int side = 0; side < 3; ++side) {
      const double angle = 2 * pi * side / 3;
      const Vector3d normal(-std::cos(half_angle) * std::cos(angle),
                            -std::cos(half_angle) * std::sin(angle), std::sin(half_angle));
      expected += 200 * (radius - normal.dot(p - Vector3d(0, 0, -pit))) * normal;
    }
    EXPECT_EQ(Presses(bench), 3) << radius;
    EXPECT_LT((bench.Hand() - expected).norm(), 0.01 * expected.norm())
        << radius << " got " << bench.Hand().transpose() << " expected " << expected.transpose();
  }
}

// Results of a slow motion of the tip from pose to pose.
struct Felt {
  double work = 0;          // of the hand, J
  double largest_step = 0;  // of the force between two ticks, N
  double least_force = 1e9, most_force = 0;
  int most_presses = 0;
};
Felt Move(FeltBench* bench, const std::vector<Vector3d>& corners, double way_a_tick) {
  Felt felt;
  Vector3d last_W = bench->Hand();
  for (std::size_t c = 1; c < corners.size(); ++c) {
    const Vector3d way = corners[c] - corners[c - 1];
    const int ticks = std::max(1, static_cast<int>(std::lround(way.norm() / way_a_tick)));
    for (int i = 1; i <= ticks; ++i) {
      bench->SessionTick(FeltBench::At(corners[c - 1] + way * i / ticks));
      const Vector3d now_W = bench->Hand();
      felt.work -= 0.5 * (now_W + last_W).dot(way) / ticks;
      felt.largest_step = std::max(felt.largest_step, (now_W - last_W).norm());
      felt.least_force = std::min(felt.least_force, now_W.norm());
      felt.most_force = std::max(felt.most_force, now_W.norm());
      felt.most_presses = std::max(felt.most_presses, Presses(*bench));
      last_W = now_W;
    }
  }
  return felt;
}

// The tip slides along the one wall into the groove's middle and out along the other one, pressed 1 mm
// into the walls. A wall of 200 N/m changes the force by 200 N/m times the way of a tick; soft tissue
// stiffens under the ball by less than twice. A jump would be half of the force, 5 times as much.
TEST(Notch, ASlideFromOneWallToTheOtherHasNoGapAndNoJump) {
  const double half_angle = 0.2 * pi, groove = 0.015, radius = 0.0025, in = 0.001, way = 1e-4;
  const Vector3d apex(0, 0.001, -groove + (radius - in) / std::sin(half_angle));
  const Vector3d up(0.004 * std::tan(half_angle), 0, 0.004);
  for (const bool rigid : {true, false}) {
    FeltBench bench(GrooveOptions(rigid), GroovedBlock(half_angle, groove), BallTip(radius));
    const Vector3d left = apex + up.cwiseProduct(Vector3d(-1, 1, 1)), right = apex + up;
    Move(&bench, {left + Vector3d(0.006, 0, 0), left, left}, way);
    Move(&bench, std::vector<Vector3d>(300, left), way);
    const double alone = bench.Hand().norm();
    const Felt slide = Move(&bench, {left, apex, right}, way);
    EXPECT_EQ(slide.most_presses, 2);
    EXPECT_GT(slide.least_force, 0.5 * alone) << rigid;
    EXPECT_LT(slide.largest_step, (rigid ? 1.1 : 2) * alone / in * way) << rigid;
  }
}

// Elastic walls without friction: a round trip of the tip in the groove costs no work. It goes down in
// the middle, aside and up along one wall, so that one place begins and ends. Near the bottom the
// kernel is cut by the edge, which its mean normals do not know: the walls give 1.4 % of the work too
// much back under a tip of 5 mm, and 9 % under one of 2.5 mm, which comes nearer to the bottom.
TEST(Notch, ARoundTripInASoftNotchCostsLittleWork) {
  const double half_angle = 0.2 * pi, groove = 0.015;
  for (const auto& [radius, most] : {std::pair(0.005, 0.03), std::pair(0.0025, 0.1)}) {
    FeltBench bench(GrooveOptions(false), GroovedBlock(half_angle, groove), BallTip(radius));
    const Vector3d deep(0, 0.001, -groove + (radius - 0.0012) / std::sin(half_angle));
    const Vector3d free = deep + Vector3d(0, 0, 0.006), aside = deep + Vector3d(0.0015, 0, 0);
    const Felt down = Move(&bench, {free, free, deep}, 2e-5);
    EXPECT_EQ(down.most_presses, 2);
    EXPECT_LT(std::abs(bench.Hand().x()), 0.02 * bench.Hand().z());
    const Felt rest = Move(&bench, {deep, aside, aside + Vector3d(0, 0, 0.007), free}, 2e-5);
    EXPECT_LT(std::abs(down.work + rest.work), most * down.work) << radius;
  }
}

// A round organ, a groove whose walls differ by 18 degrees, a deep dent: one place only.
TEST(Notch, ASmoothOrganIsPressedAtOnePlace) {
  const auto deepest = [](FeltBench* bench, const Vector3d& top) {
    const Vector3d in = top - Vector3d(0.002, 0, 0.012);
    return Move(bench, {top + Vector3d(0, 0, 0.01), in, in + Vector3d(0.01, 0.004, 0)}, 2e-4);
  };
  FeltBench groove(GrooveOptions(false), GroovedBlock(0.45 * pi, 0.004), BallTip(0.005));
  EXPECT_EQ(deepest(&groove, Vector3d(0, 0.001, 0)).most_presses, 1);
  FeltBench round(EllipsoidOptions(), Ellipsoid(kEllipsoidAxes, 3), BallTip(0.005));
  EXPECT_EQ(deepest(&round, round.Top(0.01, 0.005)).most_presses, 1);
}

}  // namespace
}  // namespace hpdm
