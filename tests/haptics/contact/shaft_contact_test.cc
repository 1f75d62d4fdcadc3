// Tests the contact of an instrument's shaft: it is found at any speed, and felt on the device's axes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "haptics/device/impulse_engine.h"
#include "tests/support/felt_bench.h"
#include "tests/support/shapes.h"
#include "tools/haptics/shaft_trials.h"

namespace hpdm {
namespace {

// The wall's force is its stiffness times the depth of the shaft in the lobe, at every moment. The
// facets lie below the sphere, and a fast shaft first meets the coarse surface: 0.03 N are 0.1 mm.
TEST(ShaftContact, SweepIntoARigidLobeIsStoppedAtEverySpeedOnEveryMesh) {
  for (const double radius : {0.01, 0.02}) {
    for (const int level : {2, 3, 4}) {  // edges of 5, 2.5 and 1.25 mm on the larger lobe
      const SurfaceMesh lobe = Ellipsoid(Vector3d::Constant(radius), level);
      const double facets = kLobeWall * radius * (level == 2 ? 0.02 : 0.005);
      for (const double speed : {0.1, 0.3, 1.0, 3.0}) {
        FeltBench bench(RigidLobe(), lobe);
        bench.feels_shaft = true;
        const ShaftSweep sweep = SweepShaftDown(&bench, radius, 0.006, speed);
        EXPECT_EQ(sweep.late, 0) << radius << ' ' << level << ' ' << speed;
        EXPECT_LT(sweep.worst, facets + 0.03) << radius << ' ' << level << ' ' << speed;
        EXPECT_LT(sweep.largest_step,
                  1.1 * kShaftToLobe / kShaftInserted * kLobeWall * 1e-3 * speed);
      }
    }
  }
}

TEST(ShaftContact, SweepPastALobesMiddleIsStillPushedBack) {
  for (const double speed : {0.3, 1.0, 3.0}) {
    FeltBench bench(RigidLobe(), Ellipsoid(Vector3d::Constant(0.01), 3));
    bench.feels_shaft = true;
    const double depth = 0.02;
    const ShaftSweep sweep = SweepShaftDown(&bench, 0.01, depth, speed);
    EXPECT_NEAR(sweep.last * kShaftInserted / kShaftToLobe, kLobeWall * depth,
                0.1 * kLobeWall * depth)
        << speed;
    EXPECT_GT(bench.Hand().z(), 0) << speed;
  }
}

// The normals at the border of a thin wall lie along the shaft, which is not end on there.
TEST(ShaftContact, SweepDownOnTheBorderOfAThinWallIsFeltAtEveryTick) {
  constexpr double kHalf = 0.0015, kLength = 0.02, kHeight = 0.03;
  double slow = 0;
  for (const double speed : {0.1, 1.0, 3.0}) {
    OrganOptions wall = SoftLobe();
    wall.lattice.cells = {1, 4, 6};
    wall.lattice.margin = 0.001;
    FeltBench bench(
        wall, GridBox(Vector3d(-kHalf, -kLength, 0), Vector3d(kHalf, kLength, kHeight), {2, 8, 8}));
    bench.feels_shaft = true;
    const ShaftSweep sweep = SweepShaftDown(&bench, kHeight, 0.005, speed);
    EXPECT_GT(sweep.least_held, 0) << speed;
    if (speed == 0.1) slow = sweep.last;
    EXPECT_NEAR(sweep.last, slow, 0.15 * slow) << speed;
  }
}

// A tip press's force grows by its stiffness times its way in each tick; so does a shaft's.
TEST(ShaftContact, SweepIntoASoftLobeHasTheForceOfASlowPressWithoutSteps) {
  for (const double radius : {0.01, 0.02}) {
    for (const int level : {2, 3}) {
      const SurfaceMesh lobe = Ellipsoid(Vector3d(radius, radius, 0.03), level);
      ShaftSweep slow;
      for (const double speed : {0.1, 0.3, 1.0, 3.0}) {
        FeltBench bench(SoftLobe(), lobe);
        bench.feels_shaft = true;
        const ShaftSweep sweep = SweepShaftDown(&bench, 0.03, 0.006, speed);
        if (speed == 0.1) slow = sweep;
        EXPECT_LE(sweep.late, 1) << "the facets lie below the ellipsoid";
        EXPECT_NEAR(sweep.last, slow.last, 0.03 * slow.last)
            << radius << ' ' << level << ' ' << speed;
        EXPECT_LT(sweep.largest_step, 1.15 * speed / 0.1 * slow.largest_step)
            << radius << ' ' << level << ' ' << speed;
      }
    }
  }
}

// The efforts of the felt force are those of the force where it acts: J_s is a finite difference of
// the place on the shaft.
TEST(ShaftContact, ForceActsOnTheDevicesAxesByItsLever) {
  const ImpulseEngineKinematics kinematics(Vector3d(0.1, 0.2, 0.3), Vector3d(1, -0.5, -2),
                                           DeviceProfile{});
  for (const double from_trocar : {0.02, 0.08, 0.15}) {
    for (const double angle : {-0.6, 0.1, 0.8}) {
      JointVector joints;
      joints << angle, 0.3 - angle, 0.16, 0.4, 1;
      const double along = joints[kInsertion] - from_trocar;  // from the tip
      const auto place = [&](int joint, double step) {
        JointVector moved = joints;
        moved[joint] += step;
        return Vector3d(kinematics.Forward(moved) * Vector3d(0, 0, along));
      };
      const Vector3d force_W(0.7, -1.1, 0.4);
      const Vector3d on_tip_W = OnTip(force_W, kinematics.Forward(joints).linear().col(2),
                                      from_trocar / joints[kInsertion]);
      const Vector3d effort = kinematics.Jacobian(joints).transpose() * on_tip_W;
      for (int joint = 0; joint < 3; ++joint) {
        const Vector3d column = (place(joint, 1e-6) - place(joint, -1e-6)) / 2e-6;
        EXPECT_NEAR(effort[joint], column.dot(force_W), 1e-8);
      }
    }
  }
}

// Slides the shaft along its axis by `way`, m.
ToolPose Inserted(ToolPose tool, double way) {
  tool.X_WT.translation() -= way * tool.X_WT.linear().col(2);
  return tool;
}

TEST(ShaftContact, FrictionHoldsTheShaftUntilItsConeEnds) {
  for (const double friction : {0.0, 0.3}) {
    FeltBench bench(RigidLobe(), Ellipsoid(Vector3d::Constant(0.02), 3));
    bench.feels_shaft = true;
    bench.friction = friction;
    SweepShaftDown(&bench, 0.02, 0.004, 0.1);
    const ToolPose start = ShaftAcross(0.02 + kDefaultToolRadius - 0.004);
    const Vector3d axis = start.X_WT.linear().col(2);
    const auto across = [&](double way) {  // without the lever
      const double lever = kShaftToLobe / (kShaftInserted + way);
      return (bench.Hand() - axis.dot(bench.Hand()) * axis).norm() / lever;
    };
    double way = 0;
    const double before = axis.dot(bench.Hand());  // left by the sweep
    for (int i = 0; i < 10; ++i) bench.SessionTick(Inserted(start, way += 2e-5));
    EXPECT_NEAR(axis.dot(bench.Hand()) - before, friction > 0 ? kLobeWall * way : 0, 2e-3);
    for (int i = 0; i < 400; ++i) {
      bench.SessionTick(Inserted(start, way += 5e-5));
      EXPECT_LT(axis.dot(bench.Hand()), 1.02 * friction * across(way) + 1e-9);
    }
    EXPECT_NEAR(axis.dot(bench.Hand()), friction * across(way),
                0.02 * friction * across(way) + 1e-9);
    EXPECT_NEAR(across(way), kLobeWall * 0.004, 0.02 * kLobeWall * 0.004);
  }
}

SurfaceMesh LobeAt(double x) {
  Isometry3d X_WO = Isometry3d::Identity();
  X_WO.translation().x() = x;
  return Ellipsoid(Vector3d::Constant(0.01), 3, X_WO);
}

SurfaceMesh Together(const SurfaceMesh& a, const SurfaceMesh& c) {
  SurfaceMesh both;
  both.vertices.resize(a.vertices.rows() + c.vertices.rows(), 3);
  both.vertices << a.vertices, c.vertices;
  both.triangles.resize(a.triangles.rows() + c.triangles.rows(), 3);
  both.triangles << a.triangles,
      (c.triangles.array() + static_cast<int>(a.vertices.rows())).matrix();
  return both;
}

// Two lobes 50 mm apart, of two organs or of one: each pushes with its own lever.
TEST(ShaftContact, TwoLobesAddUpOnOneOrganAndOnTwo) {
  const auto press = [](std::vector<OrganModel> organs) {
    FeltBench bench(std::move(organs));
    bench.feels_shaft = true;
    SweepShaftDown(&bench, 0.01, 0.005, 0.1);
    return bench.Hand();
  };
  const auto organs = [](const std::vector<SurfaceMesh>& meshes) {
    std::vector<OrganModel> models;
    for (const SurfaceMesh& mesh : meshes) models.emplace_back(RigidLobe(), mesh);
    return models;
  };
  const SurfaceMesh near = LobeAt(-0.05), far = LobeAt(0);
  const Vector3d both = press(organs({near})) + press(organs({far}));
  EXPECT_GT(press(organs({near})).z(), 0.1);
  EXPECT_GT(press(organs({far})).z(), 0.1);
  EXPECT_LT((press(organs({near, far})) - both).norm(), 1e-3 * both.norm());
  EXPECT_LT((press(organs({Together(near, far)})) - both).norm(), 1e-3 * both.norm());
}

// The step solves all contacts by its active set, the tick by rounds over tip and shaft.
// A shaft lies over the top of a lobe, pressed into it, and its tip 45 mm behind, on the slope.
class TipAndShaft : public testing::Test {
 protected:
  void SetUp() override {
    bench.feels_shaft = true;
    for (double down = 0; down < 0.007; down += 2e-5) bench.SessionTick(Pose(down));
    for (int i = 0; i < 400; ++i) bench.SessionTick(last);
  }
  static ToolPose Pose(double down) {
    ToolPose tool;
    tool.X_WT.linear() = Eigen::AngleAxisd(-M_PI / 2 - 0.35, Vector3d::UnitY()).toRotationMatrix();
    const Vector3d out = tool.X_WT.linear().col(2);
    tool.X_WT.translation() = Vector3d(0, 0, 0.034 - down) - 0.045 * out;
    tool.p_trocar_W = tool.X_WT.translation() + 0.2 * out;
    return tool;
  }

  FeltBench bench{SoftLobe(), Ellipsoid(Vector3d(0.06, 0.03, 0.03), 4)};
  const ToolPose last = Pose(0.007);
};

TEST_F(TipAndShaft, TickAndStepAgreeOnOneOrgan) {
  int pressing = 0;
  for (int p = 0; p < kToolPlaces; ++p) {
    const ToolPatch& patch = bench.Patches().places[static_cast<std::size_t>(p)];
    if (patch.organ < 0) continue;
    const TickContactPoint point = bench.Contacts().contact_points()[static_cast<std::size_t>(p)];
    const Vector3d meant = OnTip(-patch.force_on_tissue_W, last.X_WT.linear().col(2),
                                 p < kMaxPlaces ? 1 : point.from_trocar / 0.2);
    EXPECT_LT((bench.Contacts().result(p).reaction_W - meant).norm(), 0.01 * meant.norm() + 1e-6)
        << p;
    pressing += patch.force_on_tissue_W.norm() > 0.01;
  }
  EXPECT_GE(pressing, 2);
}

// Couplings beyond the contacts' own compliances belong to no tissue. They come about where contacts have
// moved since the step. Here each contact pushes the tissue against the other, and the rounds would
// diverge. The largest coupling that tissue could have raises forces by up to 1 / (1 - 0.95).
TEST_F(TipAndShaft, CouplingsThatAreTooLargeKeepForcesBounded) {
  ToolPatches patches = bench.Patches();
  for (ToolPatch& place : patches.places) {
    for (int i = 0; i < place.coupling_count; ++i) place.couplings[i].compliance_W *= -300;
  }
  const double force = bench.Hand().norm();
  TipContacts contacts = bench.Contacts();
  contacts.SetPatches(patches);
  for (int i = 0; i < 50; ++i) {
    bench.TickOf(&contacts, last);
    EXPECT_LT(contacts.result().reaction_W.norm(), 20 * force) << i;
  }
}

// The hand presses, rubs to and fro across the lobe and along the shaft, and comes back. On soft
// tissue each new patch changes the force a little: in a tenth of a second across the lobe the hand
// gets back 0.06 mJ more than it gave, 0.02 mJ at a quarter of the speed. A tip on the same path
// gets 0.04 mJ.
TEST(ShaftContact, AClosedPathGivesTheHandNoEnergy) {
  for (const double friction : {0.0, 0.3}) {
    for (const bool rigid : {false, true}) {
      FeltBench bench(rigid ? RigidLobe() : SoftLobe(), Ellipsoid(Vector3d(0.02, 0.02, 0.03), 3));
      bench.feels_shaft = true;
      bench.friction = friction;
      const double touch = 0.03 + kDefaultToolRadius;
      double work = 0, most = 0;
      ToolPose last = ShaftAcross(touch + 0.002);
      const auto move = [&](const ToolPose& tool) {
        const Vector3d before = bench.Hand();
        bench.SessionTick(tool);
        if (rigid) {
          EXPECT_EQ(bench.Felt().wall_W, bench.Hand()) << "the wall is all that is felt";
        }
        work -=
            0.5 * (before + bench.Hand()).dot(tool.X_WT.translation() - last.X_WT.translation());
        most = std::max(most, work);
        last = tool;
      };
      const auto path = [&](double share) {  // down, to and fro twice, up
        const double down = 0.008 * std::min(1.0, 5 * std::min(share, 1 - share));
        const double swing = std::clamp((share - 0.2) / 0.6, 0.0, 1.0);
        ToolPose tool =
            Inserted(ShaftAcross(touch + 0.002 - down), 0.01 * std::sin(4 * M_PI * swing));
        const Eigen::AngleAxisd turn(0.03 * std::sin(6 * M_PI * swing), Vector3d::UnitZ());
        tool.X_WT.linear() = turn * tool.X_WT.linear();
        tool.X_WT.translation() =
            tool.p_trocar_W + turn * (tool.X_WT.translation() - tool.p_trocar_W);
        return tool;
      };
      for (int i = 0; i < 100; ++i) move(path(0));
      for (int i = 0; i <= 3000; ++i) move(path(i / 3000.0));
      EXPECT_TRUE(bench.Hand().isZero(0));
      EXPECT_GT(most, 1e-4);
      if (friction == 0) {
        EXPECT_NEAR(work, 0, rigid ? 0.03 * most : 1e-4) << rigid;
      } else {
        EXPECT_GT(work, 0.2 * most) << rigid;
      }
    }
  }
}

// A shaft that touches nothing leaves the force of its tip the same to the last bit.
TEST(ShaftContact, AShaftThatTouchesNothingIsNotFelt) {
  const auto press = [](bool feels_shaft) {
    FeltBench bench(SoftLobe(), Ellipsoid(Vector3d(0.03, 0.03, 0.03), 3));
    bench.feels_shaft = feels_shaft;
    for (double z = 0.036; z > 0.027; z -= 1e-4)
      bench.SessionTick(FeltBench::At({0.002, 0.001, z}));
    return bench.Hand();
  };
  EXPECT_EQ(press(true), press(false));
  EXPECT_GT(press(true).z(), 0.01);
}

}  // namespace
}  // namespace hpdm
