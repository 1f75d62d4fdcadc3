#include "tools/session/contact_stiffness.h"

#include <gtest/gtest.h>

#include "engine/deformation_loop.h"
#include "tests/support/shapes.h"
#include "tools/shared/felt_bench.h"
#include "tools/shared/one_organ.h"

namespace hpdm {
namespace {

const Vector3d kRadii(0.1, 0.07, 0.05);  // m
const Vector3d kTrocar(0, 0, 0.2);

// An ellipsoid held in its lower part.
std::vector<OrganModel> Organ(double young, const PronySeries& prony = {}) {
  OrganOptions options;
  options.name = "ellipsoid";
  options.energy.type = EnergyType::kStrain;
  options.lattice.local.functions = 0;
  options.material.young = young;
  options.material.prony = prony;
  options.supports.push_back({BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)}, {}});
  return OneOrgan(options, Ellipsoid(kRadii, 3));
}

ImpulseEngineKinematics Kinematics() { return {kTrocar, -Vector3d::UnitZ(), DeviceProfile{}}; }

std::optional<StiffestContact> Find(const OrganModel& organ, const InstrumentOptions& instrument) {
  return FindStiffestContact(organ, instrument, Kinematics(), 1e-3, 0);
}

TEST(ContactStiffness, IsWhatATipFeelsThere) {
  const std::vector<OrganModel> organs = Organ(5000);
  const InstrumentOptions instrument;
  const Eigen::VectorXd stiffness = ContactStiffness(organs[0], instrument);
  TripleBuffer<ToolState> tools;
  TripleBuffer<ContactPatch> patches;
  TripleBuffer<SceneSnapshot> render{SizedSnapshot(organs, 1, true)};
  TripleBuffer<SceneSnapshot> telemetry{SizedSnapshot(organs, 1, false)};
  DeformationLoop loop(organs, {ToolOptions{}}, {tools, patches, render, telemetry});
  const Points& vertices = organs[0].rest().vertices;
  Eigen::Index top = 0;
  vertices.col(2).maxCoeff(&top);
  ToolState state;
  state.tool_count = 1;
  const Vector3d normal = organs[0].rest_normals().row(top);
  state.tools[0].X_WT.translation() =
      Vector3d(vertices.row(top)) + (instrument.geometry.tip_radius - 0.001) * normal;
  state.tools[0].p_trocar_W = kTrocar;
  loop.Step(state, 0);
  patches.Update();
  const ToolPatch& patch = patches.Front().tools[0].main();
  ASSERT_GT(patch.force_on_tissue_W.norm(), 0);
  const double felt = 1 / patch.normal_W.dot(DeepCompliance(patch) * patch.normal_W);
  // The lattice gets the step's force through a kernel, here at the vertex: 5 %.
  EXPECT_NEAR(stiffness[top], felt, 0.05 * felt);
}

// The device must display the force of the first tick, before anything relaxes.
TEST(ContactStiffness, OfViscoelasticTissueIsTheInstantaneousOne) {
  const PronySeries prony = {.count = 2, .terms = {{{0.5, 0.5}, {0.3, 10}}}};
  Eigen::Index top = 0;
  std::vector<double> stiffness, felt;
  for (const PronySeries& law : {PronySeries{}, prony}) {
    std::vector<OrganModel> organs = Organ(5000, law);
    organs[0].rest().vertices.col(2).maxCoeff(&top);
    const Vector3d p_W = organs[0].rest().vertices.row(top);
    stiffness.push_back(ContactStiffness(organs[0], {})[top]);
    FeltBench bench(std::move(organs));
    const auto at = [&](double depth) {
      return FeltBench::At(p_W + (kDefaultToolRadius - depth) * Vector3d::UnitZ());
    };
    bench.Step(at(-1e-4));
    bench.SessionTick(at(-1e-4));
    bench.SessionTick(at(0.002));
    felt.push_back(bench.Hand().norm());
  }
  EXPECT_GT(felt[0], 0.01);
  EXPECT_NEAR(felt[1] / felt[0], 1 / (1 - 0.8), 0.02 / (1 - 0.8));
  EXPECT_NEAR(stiffness[1] / stiffness[0], felt[1] / felt[0], 0.02 * felt[1] / felt[0]);
}

TEST(ContactStiffness, TissueThatIsTooStiffOnlyAtOnceGetsARemark) {
  const PronySeries prony = {.count = 1, .terms = {{{0.9, 1}}}};
  const auto soft = Find(Organ(5000)[0], {});
  ASSERT_TRUE(soft);
  ASSERT_LT(soft->Ratio(), 1);
  // Elastic tissue of this modulus stays below the limit by a factor of two.
  const double young = 5000 * 0.5 / soft->Ratio();
  const auto relaxed = Find(Organ(young)[0], {}), viscous = Find(Organ(young, prony)[0], {});
  ASSERT_TRUE(relaxed && viscous);
  EXPECT_NEAR(relaxed->Ratio(), 0.5, 0.01);
  EXPECT_EQ(StiffnessRemark("probe", "liver", *relaxed), "");
  EXPECT_NEAR(viscous->Ratio(), 5, 0.1);
  EXPECT_NE(StiffnessRemark("probe", "liver", *viscous), "");
}

TEST(ContactStiffness, GrowsWithTheMaterialAndLeavesTheLimit) {
  const auto soft = Find(Organ(5000)[0], {}), stiff = Find(Organ(20000)[0], {});
  ASSERT_TRUE(soft && stiff);
  EXPECT_NEAR(stiff->stiffness, 4 * soft->stiffness, 1e-6 * stiff->stiffness);  // linear
  EXPECT_EQ(stiff->limit.passivity, soft->limit.passivity);
  EXPECT_EQ(stiff->axis, soft->axis);
}

TEST(ContactStiffness, HandSetSpringsAddUpOverTheNeighbours) {
  InstrumentOptions instrument;
  instrument.reaction = ReactionType::kPaper;
  const Eigen::VectorXd stiffness = ContactStiffness(Organ(5000)[0], instrument);
  // A split icosahedron: six neighbours, and five at its own twelve corners.
  EXPECT_EQ(stiffness.maxCoeff(), instrument.k1 + 6 * instrument.k2);
  EXPECT_EQ(stiffness.minCoeff(), instrument.k1 + 5 * instrument.k2);
}

TEST(ContactStiffness, RemarkNamesBothFiguresAndTheRemedyBeyondTheLimitOnly) {
  InstrumentOptions instrument;
  instrument.reaction = ReactionType::kPaper;
  const std::vector<OrganModel> organs = Organ(5000);
  EXPECT_EQ(StiffnessRemark("probe", "liver", *Find(organs[0], instrument)), "");
  instrument.k1 = 4940;
  instrument.device.damping = 0.5;
  const auto contact = Find(organs[0], instrument);
  const std::string remark = StiffnessRemark("probe", "liver", *contact);
  EXPECT_NE(remark.find("instrument \"probe\": organ \"liver\" has a stiffness of up to "),
            remark.npos)
      << remark;
  EXPECT_NE(remark.find(std::to_string(std::lround(contact->stiffness)) + " N/m"), remark.npos);
  EXPECT_NE(remark.find(std::to_string(std::lround(contact->limit.stability)) + " N/m"),
            remark.npos);
  EXPECT_NE(remark.find("raise timing.haptic_hz"), remark.npos);
  EXPECT_EQ(remark.find('\n'), remark.npos);
}

TEST(ContactStiffness, SurfacesThatFaceAwayOrLieOutOfReachAreNotFelt) {
  InstrumentOptions instrument;
  const std::vector<OrganModel> organs = Organ(5000);
  const auto contact = Find(organs[0], instrument);
  ASSERT_TRUE(contact);
  EXPECT_GT(contact->p_W.z(), 0);  // the side of the trocar; below, where it is held, is stiffer
  const ImpulseEngineKinematics far(Vector3d(0, 0, 2), -Vector3d::UnitZ(), DeviceProfile{});
  EXPECT_FALSE(FindStiffestContact(organs[0], instrument, far, 1e-3, 0));
}

TEST(ContactStiffness, ARemarkSaysThatNothingWillBeFelt) {
  StiffestContact faint, felt;
  faint.greatest = 0.2;
  felt.greatest = 50;
  EXPECT_EQ(FaintRemark("probe", "liver", felt), "");
  EXPECT_EQ(FaintRemark("probe", "liver", faint),
            "instrument \"probe\": organ \"liver\" resists with at most 0.2 N/m: nothing will be "
            "felt; add an [[organ.support]] or raise material.young");
}

TEST(ContactStiffness, ADeviceWithoutDampingIsComparedWithTheStiffestContactOnThatAxis) {
  const std::vector<OrganModel> organs = Organ(5000);
  InstrumentOptions damped, bare;
  bare.device.damping = 0;
  const auto contact = Find(organs[0], bare);
  ASSERT_TRUE(contact);
  EXPECT_EQ(contact->axis, kInsertion);
  EXPECT_EQ(contact->limit.Least(), 0);
  Eigen::Index top = 0;
  organs[0].rest().vertices.col(2).maxCoeff(&top);
  EXPECT_GT(contact->stiffness, 0.9 * ContactStiffness(organs[0], bare)[top])
      << "the shaft presses the top along its normal";
  EXPECT_EQ(contact->greatest, Find(organs[0], damped)->greatest)
      << "the organ's, not the device's";
  EXPECT_EQ(FaintRemark("probe", "liver", *contact), "");
  EXPECT_NE(StiffnessRemark("probe", "liver", *contact).find("at most 0 N/m stably"),
            std::string::npos);
}

TEST(ContactStiffness, ARemarkSaysThatTheDeviceDisplaysNoFrictionInTheTrocar) {
  InstrumentOptions instrument;
  instrument.name = "probe";
  instrument.device.damping = 0;
  EXPECT_EQ(TrocarRemark(instrument, 1e-3), "") << "there is none to display";
  instrument.trocar_torque = 0.02;
  EXPECT_EQ(TrocarRemark(instrument, 1e-3), "") << "pitch and yaw have damping";
  instrument.trocar_friction = 0.5;
  EXPECT_EQ(TrocarRemark(instrument, 1e-3),
            "instrument \"probe\": the device displays no trocar_friction; give instrument.device "
            "damping and friction on the same axes");
  instrument.device.damping = 0.5;
  EXPECT_EQ(TrocarRemark(instrument, 1e-3), "");
  instrument.device.friction = 0;
  EXPECT_NE(TrocarRemark(instrument, 1e-3), "") << "nothing dissipates what the encoder generates";
}

}  // namespace
}  // namespace hpdm
