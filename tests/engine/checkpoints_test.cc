// An exercise restarts at one of its steps: the tissue returns to the state in which the step began.

#include "engine/checkpoints.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/support/counted_allocations.h"
#include "tests/support/shapes.h"
#include "tools/shared/organ_bench.h"

namespace hpdm {
namespace {

// A block of 60 x 60 x 30 mm that is held at its bottom, under a grasper.
class HeldBlock : public testing::Test {
 protected:
  static constexpr double kTop = 0.03;  // m

  HeldBlock() {
    OrganOptions block;
    block.name = "block";
    block.material = {.young = 5000, .poisson = 0.4};
    block.lattice.cells = {4, 4, 2};
    block.supports.push_back({hpdm::Box{Vector3d(-1, -1, -1), Vector3d(1, 1, 0.005)}, {}});
    bench_.Add(block, GridBox(Vector3d(-0.03, -0.03, 0), Vector3d(0.03, 0.03, kTop), {12, 12, 6}));
    ToolOptions grasper;
    grasper.geometries[0].can_grasp = true;
    bench_.Start({grasper});
    bench_.KeepSteps(3);
  }
  static ToolPose Over(double height, double jaw = 1) {
    ToolPose tool = OrganBench::Above({0.004, 0.003, kTop + height});
    tool.jaw = jaw;
    return tool;
  }
  void Press(double depth, int steps) {
    for (int i = 0; i < steps; ++i) bench_.Step(Over(kDefaultToolRadius - depth));
  }
  void Leave(int steps = 1) {
    for (int i = 0; i < steps; ++i) bench_.Step();
  }
  const Points& Shape() const { return bench_.organ(0).vertices; }

  OrganBench bench_;
};

// The first steps after a press still move, so the states are not those of rest.
TEST_F(HeldBlock, ReturnsToTheLastBitAndGoesOnAsIfNothingHadBeen) {
  Press(0.006, 5);
  Leave();
  bench_.Reach(1);
  std::vector<Points> first;
  for (int i = 0; i < 4; ++i) {
    Leave();
    first.push_back(Shape());
  }
  Press(0.008, 6);
  ASSERT_GT((Shape() - first[0]).norm(), 0.001);
  bench_.Restart(1);
  for (const Points& shape : first) {
    Leave();
    EXPECT_EQ((Shape() - shape).norm(), 0);
  }
}

TEST_F(HeldBlock, TheStepOfARestartIsRecordedAndDrawn) {
  Leave();
  EXPECT_EQ(bench_.record().kept_step, 0) << "an exercise begins at its first step";
  bench_.Reach(1);
  Leave();
  EXPECT_EQ(bench_.record().kept_step, 1);
  const Points rest = Shape();
  Press(0.006, 5);
  EXPECT_EQ(bench_.record().kept_step, -1);
  EXPECT_GT((bench_.Drawn(0).vertices - rest).norm(), 0.001);
  bench_.Restart(1);
  Leave();
  EXPECT_EQ(bench_.record().restarted_step, 1);
  EXPECT_LT((bench_.Drawn(0).vertices - rest).norm(), 1e-6) << "in single precision";
  Leave();
  EXPECT_EQ(bench_.record().restarted_step, -1) << "each request restarts once";
}

// The closed jaws stand where they were, 8 mm above the tissue that they held.
TEST_F(HeldBlock, ClosedJawsLetGoAndHoldNothingUntilTheyOpen) {
  bench_.Step(Over(0.001));
  for (int i = 0; i < 3; ++i) bench_.Step(Over(0.001, 0));
  bench_.Reach(1);
  bench_.Step(Over(0.001, 0));
  for (int i = 1; i <= 8; ++i) bench_.Step(Over(0.001 * (1 + i), 0));
  ASSERT_GT(bench_.ToolForce(0).norm(), 0.05) << "it holds";
  bench_.Restart(1);
  for (int i = 0; i < 5; ++i) {
    bench_.Step(Over(0.009, 0));
    EXPECT_EQ(bench_.ToolForce(0).norm(), 0);
    EXPECT_NE(bench_.patch.Front().tools[0].main().kind, ContactKind::kGrasp);
  }
  bench_.Step(Over(0.001, 1));
  bench_.Step(Over(0.001, 0));
  bench_.Step(Over(0.004, 0));
  EXPECT_EQ(bench_.patch.Front().tools[0].main().kind, ContactKind::kGrasp);
}

// The tool stands 8 mm deep in a dent when the tissue returns onto it.
TEST_F(HeldBlock, TissueThatReturnsOntoAToolMeetsItOnlyOnceTheToolIsOut) {
  Leave();
  bench_.Reach(1);
  Leave();
  const Points rest = Shape();
  Press(0.008, 5);
  ASSERT_GT(bench_.ToolForce(0).norm(), 0.05);
  bench_.Restart(1);
  for (const double height : {-0.008, -0.008, -0.012, -0.006, -0.001}) {
    bench_.Step(Over(height));
    EXPECT_EQ(bench_.ToolForce(0).norm(), 0) << height;
    EXPECT_EQ((Shape() - rest).norm(), 0);
  }
  bench_.Step(Over(0.006));
  bench_.Step(Over(-0.004));
  EXPECT_GT(bench_.ToolForce(0).norm(), 0.02) << "it has been out";
}

TEST_F(HeldBlock, AReplayKeepsTheRecordedQualityInTheStepThatReturns) {
  Leave();
  bench_.Reach(1);
  Leave();
  Press(0.006, 3);
  StepSample recorded = bench_.loop().sample();
  ++recorded.step.number;
  recorded.organs[0].refinement_weight = 0.25;
  bench_.Restart(1);
  bench_.ApplyRecorded(recorded);
  Leave();
  EXPECT_EQ(bench_.record().restarted_step, 1);
  EXPECT_EQ(bench_.loop().sample().organs[0].refinement_weight, 0.25);
}

TEST_F(HeldBlock, AllocatesNothingToKeepAndToReturn) {
  if (!kCountsAllocations) GTEST_SKIP() << "a sanitizer's allocator is not counted";
  Press(0.006, 5);
  bench_.Reach(1);
  bench_.Restart(0);
  const long before = AllocationsOfThisThread();
  Press(0.006, 1);
  ASSERT_EQ(bench_.record().restarted_step, 0);
  bench_.Reach(1, 1);
  Press(0.006, 1);
  ASSERT_EQ(bench_.record().kept_step, 1);
  EXPECT_EQ(AllocationsOfThisThread(), before);
}

TEST_F(HeldBlock, OnlyAStepThatHasBegunRestarts) {
  Leave();
  bench_.Restart(1);
  Leave();
  EXPECT_EQ(bench_.record().restarted_step, -1) << "it has not begun";
  bench_.Reach(1);
  Leave();
  bench_.Reach(2);
  Leave();
  bench_.Restart(RestartRequest::kPresent);
  Leave();
  EXPECT_EQ(bench_.record().restarted_step, 2);
  bench_.Reach(2, 1);
  bench_.Restart(RestartRequest::kPresent - 1);
  Leave();
  EXPECT_EQ(bench_.record().restarted_step, 1);
  bench_.Restart(2);
  Leave();
  EXPECT_EQ(bench_.record().restarted_step, -1) << "it has not begun again";
  bench_.Restart(RestartRequest::kPresent - 7);
  Leave();
  EXPECT_EQ(bench_.record().restarted_step, -1) << "there is no such step";
}

// The judge of the exercise hears of a restart a few steps later. Until then its step is an old one.
TEST_F(HeldBlock, AStepThatEndedBeforeARestartKeepsNothing) {
  Leave();
  bench_.Reach(1);
  Leave();
  bench_.Restart(0);
  Leave();
  EXPECT_EQ(bench_.record().restarted_step, 0);
  Leave();
  EXPECT_EQ(bench_.record().kept_step, -1);
  bench_.Reach(0, 1);
  Leave();
  EXPECT_EQ(bench_.record().kept_step, -1) << "its beginning is kept already";
  bench_.Reach(1, 1);
  Leave();
  EXPECT_EQ(bench_.record().kept_step, 1) << "it begins once more";
}

}  // namespace
}  // namespace hpdm
