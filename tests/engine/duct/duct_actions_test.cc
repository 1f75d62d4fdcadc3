// Instruments on a duct between two blocks: a grasper holds and pulls it, scissors cut it, a clip
// applier closes it.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "tests/support/shapes.h"
#include "tools/shared/organ_bench.h"

namespace hpdm {
namespace {

constexpr double kLength = 0.03;  // m, of the duct, along z from the origin

OrganOptions Block(const char* name, double young) {
  OrganOptions block;
  block.name = name;
  block.material = {.young = young, .poisson = 0.3};
  block.lattice.cells = {3, 3, 2};
  block.lattice.margin = 0.0005;
  block.lattice.local.functions = 0;
  return block;
}

/// Two blocks whose far sides are held, and a tool that comes from +x.
struct JoinedBlocks {
  // `exchanges`: the hand's further instruments.
  explicit JoinedBlocks(const ToolGeometry& geometry, double young = 2e4,
                        const std::vector<ToolGeometry>& exchanges = {}) {
    OrganOptions below = Block("below", young), above = Block("above", young);
    below.supports.push_back({hpdm::Box{Vector3d(-1, -1, -1), Vector3d(1, 1, -0.009)}, {}});
    above.supports.push_back({hpdm::Box{Vector3d(-1, -1, kLength + 0.009), Vector3d(1, 1, 1)}, {}});
    bench.Add(below,
              GridBox(Vector3d(-0.012, -0.012, -0.012), Vector3d(0.012, 0.012, 0), {6, 6, 4}));
    bench.Add(above, GridBox(Vector3d(-0.012, -0.012, kLength),
                             Vector3d(0.012, 0.012, kLength + 0.012), {6, 6, 4}));
    DuctOptions duct;
    duct.name = "duct";
    duct.a = "below";
    duct.b = "above";
    duct.path_W.resize(2, 3);
    duct.path_W << 0, 0, 0, 0, 0, kLength;
    duct.radius = 0.002;
    duct.wall = 0.0008;
    duct.young = 3e5;
    bench.Join(duct);
    ToolOptions tool;
    tool.geometries[0] = geometry;
    for (const ToolGeometry& exchange : exchanges) tool.geometries.push_back(exchange);
    bench.Start({tool});
  }
  // Jaws whose plane y = 0 of the tool frame is across the duct, at `height` on it (m), and whose
  // middle is `beside` (m) off it.
  static ToolPose Jaws(double height, double jaw, const Vector3d& beside = Vector3d::Zero()) {
    ToolPose tool;
    // Tool axes x, y, z along the world's y, z, x.
    tool.X_WT.linear() << 0, 0, 1, 1, 0, 0, 0, 1, 0;
    tool.X_WT.translation() = Vector3d(-0.005, 0, height) + beside;
    tool.p_trocar_W = tool.X_WT * Vector3d(0, 0, 0.3);
    tool.jaw = jaw;
    return tool;
  }
  // Jaws that are turned about their own axis x or z, rad.
  static ToolPose Turned(double about_x, double about_z, double jaw,
                         const Vector3d& beside = Vector3d::Zero()) {
    ToolPose tool = Jaws(kLength / 2, jaw, beside);
    tool.X_WT.linear() = tool.X_WT.linear() * Eigen::AngleAxisd(about_x, Vector3d::UnitX()) *
                         Eigen::AngleAxisd(about_z, Vector3d::UnitZ());
    return tool;
  }
  const DuctAction& action() const { return bench.loop().sample().duct_actions[0]; }
  void Step(const ToolPose& tool, int steps = 1) {
    for (int step = 0; step < steps; ++step) bench.Step(tool);
  }
  const ToolReadout& Readout() {
    bench.render->Update();
    return bench.render->Front().readouts[0];
  }
  const DuctState& duct() const { return bench.loop().links()[0].state().ducts()[0]; }
  SegmentState SegmentAt(double arc) const {
    DuctSnapshot snapshot;
    duct().FillSnapshot(&snapshot);
    for (int i = 0; i + 1 < snapshot.nodes; ++i) {
      if (duct().rod().ArcLength(i + 1) > arc) return snapshot.segments[ToSize(i)];
    }
    return SegmentState::kOpen;
  }

  OrganBench bench;
};

ToolGeometry Grasper() {
  ToolGeometry geometry;
  geometry.can_grasp = true;
  return geometry;
}
ToolGeometry Scissors() {
  ToolGeometry geometry;
  geometry.action = ToolAction::kCut;
  return geometry;
}
ToolGeometry ClipApplier(int clips) {
  ToolGeometry geometry;
  geometry.action = ToolAction::kClip;
  geometry.clips = clips;
  return geometry;
}

TEST(DuctActions, ARestartTakesClipsAndCutsBackAndFillsTheMagazineAgain) {
  JoinedBlocks blocks(ClipApplier(5), 2e4, {Scissors()});
  blocks.bench.KeepSteps(2);
  const auto close = [&](double height, int instrument_index) {
    for (const double jaw : {1.0, 0.0}) {
      ToolPose tool = JoinedBlocks::Jaws(height, jaw);
      tool.instrument_index = instrument_index;
      blocks.Step(tool, 2);
    }
  };
  close(0.008, 0);
  ASSERT_EQ(blocks.duct().Outcome().clips, 1);
  blocks.bench.Reach(1);
  close(0.020, 0);
  close(0.014, 1);
  ASSERT_EQ(blocks.duct().Outcome().clips, 2);
  ASSERT_EQ(blocks.duct().Outcome().cuts, 1);
  blocks.bench.Restart(1);
  blocks.Step(JoinedBlocks::Jaws(0.020, 0));
  EXPECT_EQ(blocks.duct().Outcome().clips, 1) << "the jaws were closed before";
  EXPECT_EQ(blocks.duct().Outcome().cuts, 0);
  EXPECT_EQ(blocks.SegmentAt(0.008), SegmentState::kClipped);
  EXPECT_EQ(blocks.SegmentAt(0.014), SegmentState::kOpen);
  EXPECT_EQ(blocks.Readout().clips_left, 4) << "as then";
}

TEST(DuctActions, ARestartLetsGoOfADuct) {
  JoinedBlocks blocks(Grasper());
  blocks.bench.KeepSteps(2);
  blocks.Step(JoinedBlocks::Jaws(0.012, 1));
  blocks.Step(JoinedBlocks::Jaws(0.012, 0.05), 3);
  blocks.bench.Reach(1);
  blocks.Step(JoinedBlocks::Jaws(0.012, 0.05));
  ASSERT_TRUE(blocks.duct().rod().HoldsNode());
  blocks.bench.Restart(1);
  blocks.Step(JoinedBlocks::Jaws(0.012, 0.05), 2);
  EXPECT_FALSE(blocks.duct().rod().HoldsNode());
  EXPECT_NE(blocks.bench.patch.Front().tools[0].main().kind, ContactKind::kGrasp);
}

// The angle of the clip that closes then is the one that was shown, and a roll by what was shown makes it
// square.
TEST(DuctActions, AnOpenClipApplierShowsTheClipThatItWouldPutOn) {
  for (const double roll : {0.6, -0.3}) {
    JoinedBlocks blocks(ClipApplier(5));
    blocks.Step(JoinedBlocks::Turned(0, roll, 1), 2);
    const ToolReadout shown = blocks.Readout();
    EXPECT_EQ(shown.clip_ahead.duct, 0);
    EXPECT_NEAR(shown.clip_ahead.angle, std::abs(roll), 1e-9);
    EXPECT_NEAR(shown.clip_ahead.coverage, 1, 1e-9);
    EXPECT_NEAR(shown.clip_roll, -roll, 1e-9);
    blocks.Step(JoinedBlocks::Turned(0, roll + shown.clip_roll, 1));
    EXPECT_LT(blocks.Readout().clip_ahead.angle, 1e-6);
    blocks.Step(JoinedBlocks::Turned(0, roll, 1));
    blocks.Step(JoinedBlocks::Turned(0, roll, 0));
    EXPECT_EQ(blocks.action().kind, DuctActionKind::kClip);
    EXPECT_NEAR(blocks.action().angle, shown.clip_ahead.angle, 1e-3);
    EXPECT_EQ(blocks.Readout().clip_ahead.duct, -1) << "the jaws are closed";
  }
  JoinedBlocks blocks(ClipApplier(5));
  blocks.Step(JoinedBlocks::Jaws(kLength / 2, 1, Vector3d(0, 0.02, 0)), 2);
  EXPECT_EQ(blocks.Readout().clip_ahead.duct, -1) << "beside it";
  JoinedBlocks scissors(Scissors());
  scissors.Step(JoinedBlocks::Jaws(kLength / 2, 1), 2);
  EXPECT_EQ(scissors.Readout().clip_ahead.duct, 0);
  JoinedBlocks grasper(Grasper());
  grasper.Step(JoinedBlocks::Jaws(kLength / 2, 1), 2);
  EXPECT_EQ(grasper.Readout().clip_ahead.duct, -1);
}

TEST(DuctActions, AGrasperHoldsAndPullsADuct) {
  JoinedBlocks blocks(Grasper());
  blocks.Step(JoinedBlocks::Jaws(0.012, 1));
  blocks.Step(JoinedBlocks::Jaws(0.012, 0.05), 3);
  EXPECT_TRUE(blocks.duct().rod().HoldsNode());
  EXPECT_LT(blocks.duct().Outcome().tension, 1e-5) << "closing jaws do not pull";
  for (int step = 1; step <= 20; ++step) {
    blocks.Step(JoinedBlocks::Jaws(0.012, 0.05, Vector3d(0, 0.0004 * step, 0)));
  }
  blocks.Step(JoinedBlocks::Jaws(0.012, 0.05, Vector3d(0, 0.008, 0)), 6);
  const ToolPatch& patch = blocks.bench.patch.Front().tools[0].main();
  EXPECT_EQ(patch.kind, ContactKind::kGrasp);
  EXPECT_EQ(patch.organ, 0) << "the organ that holds its end a";
  const Vector3d force_W = patch.force_on_tissue_W;
  EXPECT_GT(force_W.y(), 0.02);
  // The hand, and the ends on both organs.
  const Vector3d of_b_W = blocks.duct().Outcome().load_W;
  EXPECT_GT(of_b_W.y(), 0.1 * force_W.y());
  EXPECT_NEAR(blocks.duct().rod().node(16).y(), 0.008, 1e-12);
  EXPECT_GT(blocks.bench.organ(0).control_displacements.norm(), 1e-4) << "the organs follow";
}

// The patch's law against three solved steps.
TEST(DuctActions, TheHandFeelsTheDuctAndTheOrgansThatHoldIt) {
  for (const double young : {5e3, 1e5}) {
    JoinedBlocks blocks(Grasper(), young);
    blocks.Step(JoinedBlocks::Jaws(0.012, 1));
    blocks.Step(JoinedBlocks::Jaws(0.012, 0.05));
    for (int step = 1; step <= 20; ++step) {
      blocks.Step(JoinedBlocks::Jaws(0.012, 0.05, Vector3d(0, 0.0002 * step, 0)));
    }
    const Vector3d place(0, 0.004, 0);
    blocks.Step(JoinedBlocks::Jaws(0.012, 0.05, place), 8);
    const ToolPatch before = blocks.bench.patch.Front().tools[0].main();
    for (const Vector3d& way : {Vector3d(1e-5, 0, 0), Vector3d(0, 1e-5, 0), Vector3d(0, 0, 1e-5)}) {
      blocks.Step(JoinedBlocks::Jaws(0.012, 0.05, place + way), 8);
      const Vector3d force_W = blocks.bench.patch.Front().tools[0].main().force_on_tissue_W;
      const Vector3d moved = before.compliance_W * (force_W - before.force_on_tissue_W);
      EXPECT_LT((moved - way).norm(), 0.02 * way.norm()) << young << " " << way.transpose();
      blocks.Step(JoinedBlocks::Jaws(0.012, 0.05, place), 8);
    }
    const Vector3d law_W = before.compliance_W.inverse() * (before.contact_W - before.p_original_W);
    EXPECT_LT((law_W - before.force_on_tissue_W).norm(), 1e-9);
  }
}

TEST(DuctActions, OpenJawsLetGo) {
  JoinedBlocks blocks(Grasper());
  blocks.Step(JoinedBlocks::Jaws(0.012, 1));
  blocks.Step(JoinedBlocks::Jaws(0.012, 0.05));
  blocks.Step(JoinedBlocks::Jaws(0.012, 0.05, Vector3d(0, 0.004, 0)), 4);
  blocks.Step(JoinedBlocks::Jaws(0.012, 1, Vector3d(0, 0.004, 0)), 12);
  EXPECT_FALSE(blocks.duct().rod().HoldsNode());
  EXPECT_EQ(blocks.duct().Outcome().tension, 0);
  EXPECT_FALSE(blocks.bench.organ(0).awake);
}

TEST(DuctActions, JawsThatCloseBesideADuctDoNothing) {
  for (const ToolGeometry& geometry : {Grasper(), Scissors(), ClipApplier(3)}) {
    for (const Vector3d& beside :
         {Vector3d(0, 0.012, 0), Vector3d(0.008, 0, 0), Vector3d(-0.009, 0, 0)}) {
      JoinedBlocks blocks(geometry);
      blocks.Step(JoinedBlocks::Jaws(0.012, 1, beside));
      blocks.Step(JoinedBlocks::Jaws(0.012, 0.05, beside), 2);
      EXPECT_FALSE(blocks.duct().rod().HoldsNode());
      EXPECT_EQ(blocks.duct().Outcome().cuts, 0);
      EXPECT_EQ(blocks.duct().Outcome().clips, 0);
    }
  }
}

TEST(DuctActions, ScissorsCutADuctOnceForEachTimeThatTheyClose) {
  JoinedBlocks blocks(Scissors());
  blocks.Step(JoinedBlocks::Jaws(0.012, 1));
  EXPECT_EQ(blocks.duct().Outcome().cuts, 0);
  blocks.Step(JoinedBlocks::Jaws(0.012, 0.05), 3);
  EXPECT_EQ(blocks.duct().Outcome().cuts, 1);
  EXPECT_EQ(blocks.duct().rod().nodes(), kDuctSegments + 2);
  EXPECT_EQ(blocks.duct().Outcome().load_W, Vector3d::Zero());
  blocks.Step(JoinedBlocks::Jaws(0.02, 1));
  blocks.Step(JoinedBlocks::Jaws(0.02, 0.05), 3);
  EXPECT_EQ(blocks.duct().Outcome().cuts, 2);
}

TEST(DuctActions, AnEmptyMagazineIsShownAndFullAgainAfterAnExchange) {
  JoinedBlocks blocks(ClipApplier(2), 2e4, {Grasper()});
  blocks.Step(JoinedBlocks::Jaws(0.01, 1));
  EXPECT_EQ(blocks.Readout().clips_left, 2);
  for (const double height : {0.01, 0.014}) {
    blocks.Step(JoinedBlocks::Jaws(height, 1));
    blocks.Step(JoinedBlocks::Jaws(height, 0.05), 2);
  }
  EXPECT_EQ(blocks.Readout().clips_left, 0);
  EXPECT_FALSE(blocks.Readout().closed_empty) << "the last one put a clip";
  blocks.Step(JoinedBlocks::Jaws(0.018, 1));
  blocks.Step(JoinedBlocks::Jaws(0.018, 0.05), 2);
  EXPECT_TRUE(blocks.Readout().closed_empty);
  blocks.Step(JoinedBlocks::Jaws(0.018, 1));
  EXPECT_FALSE(blocks.Readout().closed_empty) << "until they open";
  ToolPose grasper = JoinedBlocks::Jaws(0.018, 1, Vector3d(0.05, 0, 0));
  grasper.instrument_index = 1;
  blocks.Step(grasper);
  EXPECT_EQ(blocks.Readout().clips_left, -1);
  blocks.Step(JoinedBlocks::Jaws(0.018, 1));
  EXPECT_EQ(blocks.Readout().clips_left, 2);
  blocks.Step(JoinedBlocks::Jaws(0.018, 0.05), 2);
  EXPECT_EQ(blocks.duct().Outcome().clips, 3);
}

TEST(DuctActions, JawsThatMissADuctSayHowFarItIs) {
  for (const ToolGeometry& geometry : {Scissors(), ClipApplier(3)}) {
    JoinedBlocks blocks(geometry);
    const Vector3d beside(0, 0.012, 0);
    blocks.Step(JoinedBlocks::Jaws(0.012, 1, beside));
    EXPECT_EQ(blocks.Readout().missed_duct, -1);
    blocks.Step(JoinedBlocks::Jaws(0.012, 0.05, beside), 2);
    EXPECT_EQ(blocks.Readout().missed_duct, 0);
    EXPECT_NEAR(blocks.Readout().missed_by, 0.012 - 0.002, 1e-4) << "from its surface";
    blocks.Step(JoinedBlocks::Jaws(0.012, 1));
    blocks.Step(JoinedBlocks::Jaws(0.012, 0.05), 2);
    EXPECT_EQ(blocks.Readout().missed_duct, -1) << "they hit it";
  }
}

TEST(DuctActions, AClipApplierClosesTheLumenUntilItsMagazineIsEmpty) {
  JoinedBlocks blocks(ClipApplier(2));
  for (const double height : {0.01, 0.014, 0.018}) {
    blocks.Step(JoinedBlocks::Jaws(height, 1));
    blocks.Step(JoinedBlocks::Jaws(height, 0.05), 2);
  }
  EXPECT_EQ(blocks.duct().Outcome().clips, 2);
  EXPECT_EQ(blocks.SegmentAt(0.0101), SegmentState::kClipped);
  EXPECT_EQ(blocks.SegmentAt(0.0141), SegmentState::kClipped);
  EXPECT_EQ(blocks.SegmentAt(0.0181), SegmentState::kOpen);
}

TEST(DuctActions, AHeldPartFollowsTheJawsAfterACut) {
  JoinedBlocks blocks(Grasper());
  blocks.Step(JoinedBlocks::Jaws(0.02, 1));
  blocks.Step(JoinedBlocks::Jaws(0.02, 0.05), 2);
  // A copy of the engine's state is cut; the loop has its own.
  DuctState duct = blocks.duct();
  int held = 0;
  while (!duct.rod().IsHeld(held)) ++held;
  const int node = duct.Cut(0.01);
  ASSERT_GT(node, 0);
  ASSERT_TRUE(duct.rod().IsHeld(held + 1));
  const Vector3d place_W = duct.rod().node(held + 1) + Vector3d(0.002, 0, 0);
  duct.MoveHeld(held + 1, place_W);
  const Eigen::VectorXd w = Eigen::VectorXd::Zero(duct.unknowns());
  duct.Follow(w);
  EXPECT_EQ(duct.rod().node(held + 1), place_W);
  EXPECT_LT((duct.rod().node(node) - Vector3d(0, 0, duct.rod().ArcLength(node))).norm(), 1e-6);
  EXPECT_EQ(duct.Cut(duct.rod().ArcLength(held + 1)), -1) << "in the jaws";
}

// A cut is at a node. The middle node is the nearest one here, but a clip lies between it and the jaws.
TEST(DuctActions, ACutStaysOnItsSideOfAClip) {
  JoinedBlocks blocks(Scissors());
  const Rod& rod = blocks.duct().rod();
  const int middle = rod.nodes() / 2;
  const double at = rod.ArcLength(middle), part = rod.ArcLength(middle + 1) - at;
  for (const double side : {-1.0, 1.0}) {
    for (const double off : {0.1, 0.3, 0.45}) {
      DuctState duct = blocks.duct();
      ASSERT_TRUE(duct.Clip(at + side * off * part));
      const double wanted = at + side * (off + 0.02) * part;
      const double planned = duct.rod().ArcLength(duct.NodeToCut(wanted));
      const int node = duct.Cut(wanted);
      ASSERT_GT(node, 0);
      const double cut = duct.rod().ArcLength(node);
      EXPECT_EQ(cut, planned);
      EXPECT_GT(side * (cut - at), off * part) << side << " " << off;
      EXPECT_LT(std::abs(cut - wanted), part);
      EXPECT_EQ(duct.Cut(wanted), -1) << "in the gap";
    }
  }
}

// The plane of the jaws and the straight duct by hand.
TEST(DuctActions, AClipIsRecordedWithItsPlaceAngleAndCoverage) {
  constexpr double kDegree = std::numbers::pi / 180;
  for (const double angle : {0.0, 19 * kDegree, 21 * kDegree, -21 * kDegree}) {
    JoinedBlocks blocks(ClipApplier(2));
    blocks.Step(JoinedBlocks::Turned(angle, 0, 1));
    EXPECT_EQ(blocks.action().kind, DuctActionKind::kNone);
    blocks.Step(JoinedBlocks::Turned(angle, 0, 0.05));
    const DuctAction clip = blocks.action();
    ASSERT_EQ(clip.kind, DuctActionKind::kClip);
    EXPECT_EQ(clip.duct, 0);
    EXPECT_NEAR(clip.length, kLength, 1e-12);
    EXPECT_NEAR(clip.angle, std::abs(angle), 1e-6);
    // The tip is 5 mm in front of the duct.
    const double height = kLength / 2 - 0.005 * std::tan(angle);
    EXPECT_NEAR(clip.arc, height, 1e-9);
    EXPECT_LT((clip.place_W - Vector3d(0, 0, height)).norm(), 1e-9);
    EXPECT_EQ(clip.coverage, 1);
    blocks.Step(JoinedBlocks::Turned(angle, 0, 0.05));
    EXPECT_EQ(blocks.action().kind, DuctActionKind::kNone) << "once";
  }
  JoinedBlocks rolled(ClipApplier(1));
  rolled.Step(JoinedBlocks::Turned(0, 25 * kDegree, 1));
  rolled.Step(JoinedBlocks::Turned(0, 25 * kDegree, 0.05));
  EXPECT_NEAR(rolled.action().angle, 25 * kDegree, 1e-6);
}

// The lumen of radius 1.2 mm is pi 1.2 mm wide when it is flat.
TEST(DuctActions, JawsMustReachPastTheFlattenedLumen) {
  const double half = std::numbers::pi / 2 * 0.0012;
  for (const double past : {0.7 * half, 0.99 * half, 1.01 * half}) {
    JoinedBlocks blocks(ClipApplier(1));
    const Vector3d beside(0.005 - past, 0, 0);
    blocks.Step(JoinedBlocks::Turned(0, 0, 1, beside));
    blocks.Step(JoinedBlocks::Turned(0, 0, 0.05, beside));
    ASSERT_EQ(blocks.action().kind, DuctActionKind::kClip);
    EXPECT_NEAR(blocks.action().coverage, std::min(1.0, (past / half + 1) / 2), 1e-6);
  }
}

TEST(DuctActions, ACutIsRecordedAtItsNode) {
  JoinedBlocks blocks(Scissors());
  blocks.Step(JoinedBlocks::Jaws(0.0121, 1));
  blocks.Step(JoinedBlocks::Jaws(0.0121, 0.05));
  EXPECT_EQ(blocks.action().kind, DuctActionKind::kCut);
  EXPECT_NEAR(blocks.action().arc, 0.012, 1e-12) << "the nearest of the nodes, 0.75 mm apart";
  EXPECT_NEAR(blocks.action().length, kLength, 1e-12);
}

TEST(DuctActions, OpenJawsTellTheClipsOnBothSides) {
  JoinedBlocks blocks(ClipApplier(3));
  const auto put = [&](double height) {
    blocks.Step(JoinedBlocks::Jaws(height, 1));
    blocks.Step(JoinedBlocks::Jaws(height, 0.05));
  };
  blocks.Step(JoinedBlocks::Jaws(0.012, 1), 2);
  EXPECT_TRUE(std::isinf(blocks.Readout().clips_beside.gap)) << "no clip yet";
  put(0.006);
  put(0.018);
  blocks.Step(JoinedBlocks::Jaws(0.0145, 1), 2);
  const ClipsBeside between = blocks.Readout().clips_beside;
  EXPECT_NEAR(between.gap, 0.0035, 5e-4);
  EXPECT_EQ(between.before, 1);
  EXPECT_EQ(between.after, 1);
  blocks.Step(JoinedBlocks::Jaws(0.003, 1), 2);
  EXPECT_EQ(blocks.Readout().clips_beside.before, 0);
  EXPECT_EQ(blocks.Readout().clips_beside.after, 2);
}

TEST(DuctActions, AnApplierLosesItsClipBesideTheDuctAndOnAClip) {
  const Vector3d beside(0, 0.012, 0);
  JoinedBlocks blocks(ClipApplier(3));
  blocks.Step(JoinedBlocks::Jaws(0.012, 1, beside));
  blocks.Step(JoinedBlocks::Jaws(0.012, 0.05, beside));
  EXPECT_EQ(blocks.action().kind, DuctActionKind::kLostClip);
  EXPECT_EQ(blocks.action().duct, -1);
  EXPECT_EQ(blocks.action().place_W, JoinedBlocks::Jaws(0.012, 1, beside).X_WT.translation());
  for (const DuctActionKind kind : {DuctActionKind::kClip, DuctActionKind::kLostClip,
                                    DuctActionKind::kNone}) {  // the magazine is empty
    blocks.Step(JoinedBlocks::Jaws(0.0121, 1));
    blocks.Step(JoinedBlocks::Jaws(0.0121, 0.05));
    EXPECT_EQ(blocks.action().kind, kind);
  }
  EXPECT_EQ(blocks.duct().Outcome().clips, 1);
  JoinedBlocks scissors(Scissors());
  scissors.Step(JoinedBlocks::Jaws(0.012, 1, beside));
  scissors.Step(JoinedBlocks::Jaws(0.012, 0.05, beside));
  EXPECT_EQ(scissors.action().kind, DuctActionKind::kNone);
}

}  // namespace
}  // namespace hpdm
