// Every key of a scene file reaches its option.

#include "tests/support/scene_fixture.h"

namespace hpdm {
namespace {

/// Gives every key a value that is not its default.
constexpr char kEveryKey[] = R"(
[scene]
name = "all keys"
background = "t.png"
[timing]
haptic_hz = 500
deformation_hz = 25
render_hz = 60
patch_delay_ticks = 7
step_budget = 0.5
[[organ]]
name = "a"
mesh = "m.obj"
unit = 0.031
model = "hpdm"
texture = "t.png"
pose = { position = [1, 2, 3], rotation_deg = [90, 0, 90] }
motion = { displacement = [0.001, 0.002, 0.003], frequency = 0.3 }
lattice = { basis = "bspline", degree = [1, 2, 3], cells = [5, 6, 7], margin = 0.01, split = false }
energy = { type = "strain", strain = "finite", law = "stvk", solver = "cholesky", newton_iterations = 5, newton_budget = 0.01 }
material = { young = 1000, poisson = 0.3, density = 900, prony = [ { share = 0.25, time = 0.5 }, { share = 0.125, time = 10 } ], relaxation_time = 0 }
region = [ { sphere = { centre = [1, 2, 3], radius = 0.25 }, young = 1e5 },
           { box_fraction = { min = [0, 0, 0], max = [1, 1, 0.5] }, young = 10 } ]
support = [ { box = { min = [0, 0, 0], max = [1, 2, 3] }, fixed = true },
            { sphere = { centre = [1, 2, 3], radius = 0.5 }, stiffness = 1e6, viscoelastic = true },
            { box_fraction = { min = [0, 0.5, 0], max = [1, 1, 1] }, fixed = true } ]
[[organ]]
name = "b"
mesh = "m.obj"
unit = "mm"
lattice = { basis = "bernstein", degree = 4 }
energy = { type = "metric", strain = "finite", solver = "gauss_seidel", domain = "box", alpha = 11, beta = 0.5 }
[[instrument]]
name = "left"
type = "grasper"
trocar = [0.1, 0.2, 0.3]
mesh = "m.obj"
tip_radius = 0.003
shaft_radius = 0.004
friction = 0.2
trocar_friction = 0.7
trocar_torque = 0.03
reaction = "paper"
k1 = 99
k2 = 9
[instrument.device]
profile = "impulse_engine"
mass = 1.01
rotational_inertia = 1.02
damping = 1.03
rotational_damping = 1.04
friction = 1.05
rotational_friction = 1.06
encoder_step = 1e-5
angle_encoder_step = 2e-5
jaw_encoder_step = 3e-5
max_force = 4
max_torque = 5
max_force_rate = 6
max_angle = 0.7
min_insertion = 0.08
max_insertion = 0.09
passivity_control = false
[instrument.hand]
script = "grasp_pull"
seed = 4294967295
organ = "b"
target = [0.4, 0.5, 0.6]
depth = 0.01
spread = 0.03
speed = 0.02
stiffness = 30
damping = 4
tremor = 0.005
[[instrument]]
name = "right"
type = "hook"
trocar = [0, 0, 0]
mesh = "m.obj"
jaws = { meshes = ["m.obj", "meshes/liver_1332.obj"], pivot = 0.012, opening_deg = 30 }
insulated_from = 0.02
reaction = "lattice"
[[instrument.exchange]]
name = "cutter"
type = "scissors"
mesh = "m.obj"
jaws = { meshes = ["m.obj"], pivot = 0.013, opening_deg = 20 }
insulated_from = 0.03
tip_radius = 0.001
shaft_radius = 0.0015
friction = 0.3
[[instrument.exchange]]
name = "finger"
[[load]]
organ = "a"
point = [1, 0, 0]
radius = 0.015
force = [0, 0, -1]
[[load]]
organ = "b"
point = [0, 1, 0]
radius = 0.012
displacement = [0, 0, 0.04]
[[load]]
organ = "b"
pressure = -250
sphere = { centre = [0, 1, 0], radius = 0.5 }
[laparoscope]
position = [0.1, -0.2, 0.3]
target = [0.01, 0.02, 0.03]
trocar = [0.1, -0.25, 0.35]
distortion = -0.1
angle_deg = 30
focal_length = 0.0024
)";

class SceneKeys : public SceneTest {
 protected:
  const Scene scene_ = Read(kEveryKey);
};

TEST_F(SceneKeys, SceneAndTimingKeysReachTheirOptions) {
  EXPECT_EQ(scene_.name, "all keys");
  EXPECT_EQ(scene_.background, (folder_.path() / "t.png").string());
  EXPECT_EQ(scene_.timing.haptic_hz, 500);
  EXPECT_EQ(scene_.timing.deformation_hz, 25);
  EXPECT_EQ(scene_.timing.render_hz, 60);
  EXPECT_EQ(scene_.timing.patch_delay_ticks, 7);
  EXPECT_EQ(scene_.timing.step_budget, 0.5);
}

TEST_F(SceneKeys, OrganKeysReachTheirOptions) {
  ASSERT_EQ(scene_.organs.size(), 2u);
  const OrganOptions& a = scene_.organs[0];
  EXPECT_EQ(a.name, "a");
  EXPECT_EQ(a.mesh, (folder_.path() / "m.obj").string());
  EXPECT_EQ(a.unit_m, 0.031);
  EXPECT_EQ(a.model, OrganModelType::kHpdm);
  EXPECT_EQ(a.texture, (folder_.path() / "t.png").string());
  // The turn about x takes y to z; the one about z keeps z. 1e-15: rounding of a sine.
  EXPECT_TRUE((a.X_WO * Vector3d(0, 1, 0)).isApprox(Vector3d(1, 2, 4), 1e-15));
  EXPECT_TRUE((a.X_WO * Vector3d(1, 0, 0)).isApprox(Vector3d(1, 3, 3), 1e-15));
  EXPECT_EQ(a.motion.displacement_W, Vector3d(0.001, 0.002, 0.003));
  EXPECT_EQ(a.motion.frequency, 0.3);
}

TEST_F(SceneKeys, LatticeAndEnergyKeysReachTheirOptions) {
  const OrganOptions& a = scene_.organs.at(0);
  EXPECT_EQ(a.lattice.basis, BasisType::kBSpline);
  EXPECT_EQ(a.lattice.degree, (std::array{1, 2, 3}));
  EXPECT_EQ(a.lattice.cells, (std::array{5, 6, 7}));
  EXPECT_EQ(a.lattice.margin, 0.01);
  EXPECT_FALSE(a.lattice.split);
  EXPECT_EQ(a.energy.type, EnergyType::kStrain);
  EXPECT_EQ(a.energy.strain, StrainMeasure::kFinite);
  EXPECT_EQ(a.energy.law, MaterialLaw::kStVenantKirchhoff);
  EXPECT_EQ(a.energy.newton_iterations, 5);
  EXPECT_EQ(a.energy.newton_budget, 0.01);
  const OrganOptions& b = scene_.organs.at(1);
  EXPECT_EQ(b.unit_m, 1e-3);
  EXPECT_EQ(b.lattice.basis, BasisType::kBernstein);
  EXPECT_EQ(b.lattice.degree, (std::array{4, 4, 4}));
  EXPECT_EQ(b.lattice.cells, (std::array{1, 1, 1}));
  EXPECT_EQ(b.energy.domain, EnergyDomain::kBox);
  EXPECT_EQ(b.energy.solver, SolverType::kGaussSeidel);
  EXPECT_EQ(b.energy.strain, StrainMeasure::kFinite);
  EXPECT_EQ(b.energy.alpha, 11);
  EXPECT_EQ(b.energy.beta, 0.5);
}

TEST_F(SceneKeys, MaterialRegionAndSupportKeysReachTheirOptions) {
  const OrganOptions& a = scene_.organs.at(0);
  EXPECT_EQ(a.material.young, 1000);
  EXPECT_EQ(a.material.poisson, 0.3);
  EXPECT_EQ(a.material.density, 900);
  ASSERT_EQ(a.material.prony.count, 2);
  EXPECT_EQ(a.material.prony.terms[0].share, 0.25);
  EXPECT_EQ(a.material.prony.terms[0].time, 0.5);
  EXPECT_EQ(a.material.prony.terms[1].share, 0.125);
  EXPECT_EQ(a.material.prony.terms[1].time, 10);
  ASSERT_EQ(a.regions.size(), 2u);
  EXPECT_EQ(std::get<Sphere>(a.regions[0].region).radius, 0.25);
  EXPECT_EQ(a.regions[0].young, 1e5);
  EXPECT_EQ(std::get<BoxFraction>(a.regions[1].region).max, Vector3d(1, 1, 0.5));
  EXPECT_EQ(a.regions[1].young, 10);
  ASSERT_EQ(a.supports.size(), 3u);
  EXPECT_EQ(std::get<Box>(a.supports[0].region).max, Vector3d(1, 2, 3));
  EXPECT_EQ(a.supports[0].stiffness, std::nullopt);
  EXPECT_EQ(std::get<Sphere>(a.supports[1].region).centre, Vector3d(1, 2, 3));
  EXPECT_EQ(std::get<Sphere>(a.supports[1].region).radius, 0.5);
  EXPECT_EQ(a.supports[1].stiffness, 1e6);
  EXPECT_TRUE(a.supports[1].viscoelastic);
  EXPECT_FALSE(a.supports[2].viscoelastic);
  EXPECT_EQ(std::get<BoxFraction>(a.supports[2].region).min, Vector3d(0, 0.5, 0));
}

TEST_F(SceneKeys, InstrumentKeysReachTheirOptions) {
  ASSERT_EQ(scene_.instruments.size(), 2u);
  const InstrumentOptions& i = scene_.instruments[0];
  EXPECT_EQ(i.name, "left");
  EXPECT_EQ(i.type, InstrumentType::kGrasper);
  EXPECT_EQ(i.p_trocar_W, Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(i.mesh, (folder_.path() / "m.obj").string());
  EXPECT_EQ(i.geometry.tip_radius, 0.003);
  EXPECT_EQ(i.geometry.shaft_radius, 0.004);
  EXPECT_EQ(i.geometry.friction, 0.2);
  EXPECT_EQ(i.trocar_friction, 0.7);
  EXPECT_EQ(i.trocar_torque, 0.03);
  EXPECT_EQ(i.reaction, ReactionType::kPaper);
  EXPECT_EQ(i.k1, 99);
  EXPECT_EQ(i.k2, 9);
}

TEST_F(SceneKeys, DeviceKeysReachTheirOptions) {
  const DeviceProfile& d = scene_.instruments.at(0).device;
  EXPECT_EQ(d.mass, 1.01);
  EXPECT_EQ(d.rotational_inertia, 1.02);
  EXPECT_EQ(d.damping, 1.03);
  EXPECT_EQ(d.rotational_damping, 1.04);
  EXPECT_EQ(d.friction, 1.05);
  EXPECT_EQ(d.rotational_friction, 1.06);
  EXPECT_EQ(d.encoder_step, 1e-5);
  EXPECT_EQ(d.angle_encoder_step, 2e-5);
  EXPECT_EQ(d.jaw_encoder_step, 3e-5);
  EXPECT_EQ(d.max_force, 4);
  EXPECT_EQ(d.max_torque, 5);
  EXPECT_EQ(d.max_force_rate, 6);
  EXPECT_EQ(d.max_angle, 0.7);
  EXPECT_EQ(d.min_insertion, 0.08);
  EXPECT_EQ(d.max_insertion, 0.09);
  EXPECT_FALSE(d.passivity_control);
}

TEST_F(SceneKeys, HandKeysReachTheirOptions) {
  const HandOptions& hand = scene_.instruments.at(0).hand;
  EXPECT_EQ(hand.script, HandScript::kGraspPull);
  EXPECT_EQ(hand.seed, 4294967295u);
  EXPECT_EQ(hand.organ, "b");
  EXPECT_EQ(hand.target, Vector3d(0.4, 0.5, 0.6));
  EXPECT_EQ(hand.depth, 0.01);
  EXPECT_EQ(hand.spread, 0.03);
  EXPECT_EQ(hand.speed, 0.02);
  EXPECT_EQ(hand.stiffness, 30);
  EXPECT_EQ(hand.damping, 4);
  EXPECT_EQ(hand.tremor, 0.005);
}

TEST_F(SceneKeys, JawAndExchangeKeysReachTheirOptions) {
  const InstrumentOptions& i = scene_.instruments.at(1);
  EXPECT_EQ(i.type, InstrumentType::kHook);
  EXPECT_EQ(i.reaction, ReactionType::kLattice);
  EXPECT_EQ(i.jaws.meshes, (std::vector{(folder_.path() / "m.obj").string(),
                                        (folder_.path() / "meshes/liver_1332.obj").string()}));
  EXPECT_EQ(i.jaws.pivot, 0.012);
  EXPECT_DOUBLE_EQ(i.jaws.opening, Radians(30));
  EXPECT_EQ(i.insulated_from, 0.02);
  ASSERT_EQ(i.HeldCount(), 3);
  EXPECT_EQ(i.Held(0).type, InstrumentType::kHook);
  const InstrumentDescription& e = i.Held(1);
  EXPECT_EQ(e.name, "cutter");
  EXPECT_EQ(e.type, InstrumentType::kScissors);
  EXPECT_EQ(e.mesh, (folder_.path() / "m.obj").string());
  EXPECT_EQ(e.jaws.meshes.size(), 1u);
  EXPECT_EQ(e.jaws.pivot, 0.013);
  EXPECT_EQ(e.insulated_from, 0.03);
  EXPECT_EQ(e.geometry.tip_radius, 0.001);
  EXPECT_EQ(e.geometry.shaft_radius, 0.0015);
  EXPECT_EQ(e.geometry.friction, 0.3);
  EXPECT_EQ(i.Held(2).name, "finger");
  EXPECT_EQ(i.Held(2).type, InstrumentType::kProbe);
}

TEST_F(SceneKeys, LoadKeysReachTheirOptions) {
  ASSERT_EQ(scene_.loads.size(), 3u);
  EXPECT_EQ(scene_.loads[0].organ, "a");
  EXPECT_EQ(scene_.loads[0].p_centre_W, Vector3d(1, 0, 0));
  EXPECT_EQ(scene_.loads[0].radius, 0.015);
  EXPECT_EQ(scene_.loads[0].force_W, Vector3d(0, 0, -1));
  EXPECT_EQ(scene_.loads[0].displacement_W, std::nullopt);
  EXPECT_EQ(scene_.loads[1].displacement_W, Vector3d(0, 0, 0.04));
  EXPECT_EQ(scene_.loads[1].pressure, std::nullopt);
  EXPECT_EQ(scene_.loads[2].pressure, -250);
  EXPECT_EQ(std::get<Sphere>(scene_.loads[2].region.value()).radius, 0.5);
}

TEST_F(SceneKeys, LaparoscopeKeysReachTheirOptions) {
  EXPECT_EQ(scene_.laparoscope.p_scope_W, Vector3d(0.1, -0.2, 0.3));
  EXPECT_EQ(scene_.laparoscope.p_target_W, Vector3d(0.01, 0.02, 0.03));
  EXPECT_EQ(scene_.laparoscope.p_trocar_W, Vector3d(0.1, -0.25, 0.35));
  EXPECT_EQ(scene_.laparoscope.distortion, -0.1);
  EXPECT_DOUBLE_EQ(scene_.laparoscope.angle, Radians(30));
  // A focal length of half the picture's diameter sees 45 degrees to each side.
  EXPECT_DOUBLE_EQ(scene_.laparoscope.field_of_view, Radians(90));
}

}  // namespace
}  // namespace hpdm
