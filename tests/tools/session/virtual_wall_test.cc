#include "tools/session/virtual_wall.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "engine/base/error.h"
#include "engine/deformation_loop.h"
#include "haptics/safety/stability.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/shapes.h"
#include "tools/session/lockstep.h"
#include "tools/session/session.h"
#include "tools/shared/one_organ.h"

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

TEST(VirtualWall, IsStiffAlongTheShaftAndSoftestWhereALongLeverMeetsItAcross) {
  const std::vector<OrganModel> organs = Organ({0.1, 0.07, 0.05});
  const DeviceProfile device;
  const VirtualWall wall = Find(organs);
  EXPECT_TRUE(wall.reachable);
  // The top lies straight under the trocar, so the shaft meets it along its normal: 2 f_c / step of
  // the insertion, 8 kN/m.
  const SurfaceMesh& rest = organs[0].rest();
  Eigen::Index top = 0;
  rest.vertices.col(2).maxCoeff(&top);
  const double shaft = 2 * device.friction / device.encoder_step;
  EXPECT_NEAR(wall.fields[0](top, 0), shaft, 1e-4 * shaft);
  EXPECT_NEAR(wall.greatest, shaft, 1e-4 * shaft);
  EXPECT_GT(wall.median, 3000);
  // The rim, 0.2 m away, is met at a grazing angle: near the figures of pitch and yaw at its lever.
  EXPECT_GT(wall.lever, 0.19);
  EXPECT_LT(wall.lever, std::hypot(0.2, 0.1) + 0.0025);
  const double turning =
      2 * device.rotational_friction / (device.angle_encoder_step * wall.lever * wall.lever);
  EXPECT_GE(wall.least, turning * (1 - 1e-9));
  EXPECT_LT(wall.least, 3 * turning);
  EXPECT_LE(wall.limit, wall.least);
  for (Eigen::Index v = 0; v < wall.fields[0].rows(); ++v) {
    EXPECT_GE(wall.fields[0](v, 0), wall.fields[0](v, 1) * (1 - 1e-9)) << "softer than across";
  }
}

TEST(VirtualWall, OfADeviceWithDelayIsHalfOfItsStability) {
  const std::vector<OrganModel> organs = Organ({0.1, 0.07, 0.05});
  DeviceProfile late;
  late.delay = 0.003;
  const VirtualWall wall = Find(organs, late);
  Eigen::Index top = 0;
  organs[0].rest().vertices.col(2).maxCoeff(&top);
  const double lag = 2e-3 + late.delay;  // half of window and period, and the samples' age
  const double damping = std::min(0.5 * late.mass / lag, 0.1 * 3e-3 / late.encoder_step);
  const double stable =
      StabilityLimit({late.mass, late.damping}, kPeriod, late.delay, {damping, 3});
  EXPECT_NEAR(wall.fields[0](top, 0), 0.5 * stable, 1e-6 * stable);
  EXPECT_LT(wall.greatest, 2 * late.friction / late.encoder_step);
}

TEST(VirtualWall, StomachOfTheAbdomenHasThreeKilonewtonsAMetreWhereItFacesTheShaft) {
  // The old wall had 174 N/m everywhere. Beyond 55 degrees from the shaft no device of these
  // figures displays as much: 2 f_c / step is 694 N/m across a shaft of 0.24 m.
  const Session session(
      LoadScene(std::string(HPDM_SOURCE_DIR) + "/scenes/abdomen_on_springs.toml"));
  ASSERT_EQ(session.walls().size(), 2u);
  const auto stomach = std::find_if(session.organs().begin(), session.organs().end(),
                                    [](const OrganModel& organ) { return organ.rigid(); });
  ASSERT_NE(stomach, session.organs().end());
  const auto index = static_cast<std::size_t>(stomach - session.organs().begin());
  for (std::size_t i = 0; i < 2; ++i) {
    const VirtualWall& wall = session.walls()[i];
    EXPECT_GT(wall.least, 694);
    EXPECT_GT(wall.median, 2500);
    EXPECT_GT(wall.greatest, 7000);
    int facing = 0;
    for (Eigen::Index v = 0; v < wall.fields[index].rows(); ++v) {
      const Vector3d p_W = stomach->rest().vertices.row(v);
      const Vector3d n_W = stomach->rest_normals().row(v);
      const Vector3d shaft_W = session.scene().instruments[i].p_trocar_W - p_W;
      if (shaft_W.norm() > 0.24 || n_W.dot(shaft_W) < 0.57 * shaft_W.norm()) continue;
      EXPECT_GT(wall.fields[index](v, 0), 3000) << v;
      ++facing;
    }
    EXPECT_GT(facing, 100);
  }
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

TEST(VirtualWall, ATipThatReachesNothingGetsTheFiguresOfTheFarthestInsertion) {
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
  EXPECT_NO_THROW(Find(Organ(radii), undamped)) << "the controller damps";
  undamped.passivity_control = false;
  EXPECT_THROW(Find(Organ(radii), undamped), InputError);
  EXPECT_NO_THROW(Find(Organ(radii, 100), undamped));
  DeviceProfile frictionless;
  frictionless.rotational_friction = 0;
  EXPECT_THROW(Find(Organ(radii), frictionless), InputError);
}

// A hand that means to go 15 mm deep, with the device's own friction and encoders.
std::string SceneOf(const char* script) {
  return std::string("[[organ]]\nname = \"stomach\"\nmodel = \"rigid\"\nmesh = \"") +
         HPDM_SOURCE_DIR + "/scenes/meshes/stomach_2132.obj\"\n" +
         "[[instrument]]\nname = \"probe\"\ntrocar = [0.03, -0.03, 0.2]\nfriction = 0.2\n"
         "[instrument.device]\nmax_insertion = 0.24\n"
         "[instrument.hand]\nscript = \"" +
         script + "\"\ndepth = 0.015\nstiffness = 500\nspeed = 0.3\n";
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
    EXPECT_LE(peak, 8.9 + 1e-9) << script;
    EXPECT_GT(least, -1e-3) << script << ": 1 mJ at most";
  }
}

}  // namespace
}  // namespace hpdm
