#include "tools/session/virtual_wall.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "engine/base/error.h"
#include "engine/deformation_loop.h"
#include "haptics/safety/stability.h"
#include "tests/support/one_organ.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/shapes.h"
#include "tools/session/lockstep.h"
#include "tools/session/session.h"

namespace hpdm {
namespace {

constexpr double kPeriod = 1e-3;  // s
const Vector3d kWallTrocar(0, 0, 0.2);

std::vector<OrganModel> Organ(const Vector3d& radii, std::optional<double> wall_stiffness = {}) {
  OrganOptions options;
  options.name = "stone";
  options.model = OrganModelType::kRigid;
  options.wall_stiffness = wall_stiffness;
  return OneOrgan(options, Ellipsoid(radii, 3));
}

VirtualWall Find(const std::vector<OrganModel>& organs, const DeviceProfile& device = {}) {
  InstrumentOptions instrument;
  instrument.name = "probe";
  instrument.device = device;
  return FindVirtualWall(organs, instrument, {kWallTrocar, -Vector3d::UnitZ(), device}, kPeriod);
}

TEST(VirtualWall, IsHalfOfTheExactLimitWhereTheLeverIsLongest) {
  const std::vector<OrganModel> organs = Organ({0.1, 0.07, 0.05});
  for (const double delay : {0.0, 0.002}) {
    DeviceProfile device;
    device.delay = delay;
    const VirtualWall wall = Find(organs, device);
    EXPECT_TRUE(wall.reachable);
    EXPECT_NE(wall.axis, kInsertion);  // at 15 cm and more a turning axis is the weaker one
    // The wall reaches as far as the line of sight past the ellipsoid's rim, 0.2 m behind which the
    // organ is hidden.
    EXPECT_GT(wall.lever, 0.19);
    EXPECT_LT(wall.lever, std::hypot(0.2, 0.1) + 0.0025);
    // About the trocar, the wall is k lever^2: on the edge of stability at the limit, to the 1e-6
    // of its bisection, and stable at half of it.
    const AxisDynamics axis{device.rotational_inertia, device.rotational_damping};
    const double square = wall.lever * wall.lever;
    EXPECT_NEAR(SpectralRadius(axis, wall.limit * square, kPeriod, delay), 1, 1e-5);
    EXPECT_LT(SpectralRadius(axis, wall.stiffness * square, kPeriod, delay), 1 - 1e-4);
    EXPECT_EQ(wall.stiffness, wall.limit / 2);
  }
}

TEST(VirtualWall, IsTheInsertionAxisNearTheTrocar) {
  // The whole organ lies within 12 cm, where K / lever^2 of the turning axes, 1,390 N/m, exceeds 2
  // b / T.
  DeviceProfile device;
  device.max_insertion = 0.12;
  const VirtualWall wall = Find(Organ(Vector3d::Constant(0.1)), device);
  EXPECT_EQ(wall.axis, kInsertion);
  // Damping dominates: 2 b / T; the mass adds less than 1 %.
  EXPECT_NEAR(wall.limit, 2 * device.damping / kPeriod, 0.01 * wall.limit);
}

TEST(VirtualWall, AnOrganBetweenTrocarAndWallKeepsTheTipAway) {
  std::vector<OrganModel> organs = Organ(Vector3d::Constant(0.04));
  const double alone = Find(organs).lever;
  // A second stone above the first hides all of it but a rim: the shaft is straight.
  Isometry3d X_above = Isometry3d::Identity();
  X_above.translation().z() = 0.09;
  OrganOptions options;
  options.name = "above";
  options.model = OrganModelType::kRigid;
  std::vector<OrganModel> two = Organ(Vector3d::Constant(0.04));
  two.emplace_back(options, Ellipsoid(Vector3d::Constant(0.045), 3, X_above));
  const VirtualWall wall = Find(two);
  EXPECT_LT(wall.lever, alone);
  EXPECT_LT(wall.lever, 0.13);  // the nearer stone's own horizon: sqrt(0.11^2 - 0.045^2) + edges
}

TEST(VirtualWall, ATipThatReachesNothingGetsTheWallOfTheFarthestInsertion) {
  DeviceProfile device;
  device.max_insertion = 0.1;
  const VirtualWall wall = Find(Organ(Vector3d::Constant(0.02)), device);
  EXPECT_FALSE(wall.reachable);
  EXPECT_EQ(wall.lever, 0.1);
}

TEST(VirtualWall, AWallBeyondTheDeviceIsReportedOrRefused) {
  const Vector3d radii(0.1, 0.07, 0.05);
  const VirtualWall wall = Find(Organ(radii));
  EXPECT_TRUE(WallRemarks(Organ(radii), "probe", wall).empty());
  EXPECT_TRUE(WallRemarks(Organ(radii, 0.99 * wall.limit), "probe", wall).empty());
  const auto remarks = WallRemarks(Organ(radii, 1.01 * wall.limit), "probe", wall);
  ASSERT_EQ(remarks.size(), 1u);
  EXPECT_NE(remarks[0].find("wall_stiffness"), std::string::npos);
  DeviceProfile undamped;
  undamped.rotational_damping = 0;
  EXPECT_THROW(Find(Organ(radii), undamped), InputError);
  EXPECT_NO_THROW(Find(Organ(radii, 100), undamped));
}

// A hand that means to go 4 cm deep, with the device's own friction and encoders.
std::string SceneOf(const char* script) {
  return std::string("[[organ]]\nname = \"stomach\"\nmodel = \"rigid\"\nmesh = \"") +
         HPDM_SOURCE_DIR + "/scenes/meshes/stomach_2132.obj\"\n" +
         "[[instrument]]\nname = \"probe\"\ntrocar = [0.03, -0.03, 0.2]\nfriction = 0.2\n"
         "[instrument.device]\nmax_insertion = 0.24\npassivity_control = false\n"
         "[instrument.hand]\nscript = \"" +
         script + "\"\ndepth = 0.04\nstiffness = 500\nspeed = 0.3\n";
}

TEST(VirtualWall, HandThatPressesHardGetsNoEnergyThroughTheDevice) {
  const ScratchFolder folder;
  for (const char* script : {"palpate", "tap", "slide"}) {
    std::ofstream(folder / "scene.toml") << SceneOf(script);
    Session session(LoadScene(folder / "scene.toml"));
    ASSERT_EQ(session.walls().size(), 1u);
    session.EnableForces(true);
    HapticLoop haptics(session.HapticInstruments(), session.haptic_period_ns(),
                       {session.tool_states, session.patches, session.samples});
    DeformationLoop deformation(session.organs(), session.DeformationTools(),
                                {session.tool_states, session.patches, *session.render_scenes,
                                 *session.telemetry_scenes, &session.steps});
    Lockstep clock(session.scene().timing, &haptics, &deformation);
    const DeviceAxes axes = AxesOf(session.scene().instruments[0].device);
    // Counts from the first free tick after the guard's start-up ramp, which releases more force
    // than it admitted: the hand's work, and the device's own dissipation in contact.
    std::optional<double> energy_before;
    double dissipated = 0, least = 0, peak = 0;
    JointVector last = JointVector::Zero();
    int pressing = 0;
    while (clock.tick() < 6000) {
      if (clock.StepIfDue()) {
        StepSample step;
        while (session.steps.Pop(&step)) EXPECT_EQ(step.step.flags, kStepOk);
      }
      clock.Tick();
      HapticSample sample;
      ASSERT_TRUE(session.samples.Pop(&sample));
      const ToolSample& tool = sample.tools[0];
      ASSERT_TRUE(tool.force_W.allFinite());
      const bool presses = tool.kind == ContactKind::kPress;
      if (!energy_before && sample.tick > 600 && !presses) energy_before = tool.energy;
      if (energy_before && presses) {
        for (int i = 0; i < 3; ++i) {
          const double dq = tool.joints[i] - last[i];
          // The wall uses half of the limit, its margin.
          dissipated +=
              0.5 * (axes.damping[i] * dq * dq / kPeriod + axes.friction[i] * std::abs(dq));
        }
        least = std::min(least, tool.energy - *energy_before + dissipated);
        ++pressing;
      }
      peak = std::max(peak, tool.force_W.norm());
      last = tool.joints;
    }
    ASSERT_TRUE(energy_before) << script;
    EXPECT_GT(pressing, 700) << script;
    EXPECT_GT(peak, 2) << script;
    EXPECT_LT(peak, 8.9) << script;
    // The tick in which a contact ends moves under a force that the sum above no longer answers:
    // 0.6 mm at 0.1 N, beside the 100 mJ that a press stores.
    EXPECT_GT(least, -6e-5) << script;
  }
}

}  // namespace
}  // namespace hpdm
