#include "engine/step/inversion_recovery.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "engine/deformation_loop.h"
#include "tests/support/counted_allocations.h"
#include "tests/support/shapes.h"
#include "tools/shared/one_organ.h"

namespace hpdm {
namespace {

// Returns an organ of finite strain, small enough to be quick.
OrganOptions FiniteOptions(MaterialLaw law = MaterialLaw::kStVenantKirchhoff) {
  OrganOptions options;
  options.name = "ellipsoid";
  options.energy.type = EnergyType::kStrain;
  options.energy.strain = StrainMeasure::kFinite;
  options.energy.law = law;
  options.lattice.cells = {2, 2, 2};
  options.lattice.local.functions = 0;
  options.supports = {{BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)}, {}}};
  return options;
}

// Holds one point at the top at a given place.
void Hold(const OrganModel& model, const Vector3d& move, ContactConstraints* contacts) {
  contacts->Clear();
  ContactConstraints::Row* row = contacts->Add();
  row->kind = ContactConstraints::RowKind::kGrasp;
  row->p_rest_W = Vector3d(0, 0, 0.05);
  row->target_W = row->p_rest_W + move;
  auto weights = contacts->WeightRow(0);
  model.lattice_organ()->lattice().ForEachFunction(
      row->p_rest_W, [&](int column, double value) { weights[column] = value; });
}

// Stage B of a step for an organ alone.
void RelaxAlone(InversionRecovery* inversion_recovery, OrganState* state) {
  const auto relax = [&] {
    return state->relaxation->Relax(&state->contacts, &state->control_displacements,
                                    inversion_recovery->input());
  };
  inversion_recovery->Begin(1. / 30, state);
  RelaxationResult result = relax();
  if (inversion_recovery->Rejects(result, state)) result = relax();
  inversion_recovery->End(result, state);
}

class InversionRecoveryTest : public testing::Test {
 protected:
  void Hold(const Vector3d& move) { hpdm::Hold(models_[0], move, &state_.contacts); }
  void Relax() { RelaxAlone(&inversion_recovery_, &state_); }
  InversionDetector::Inversion Evaluate() const {
    return models_[0].lattice_organ()->inversion_detector().EvaluateAll(
        state_.contacts.refinement, state_.control_displacements);
  }
  double Height() const {  // of the point above its rest
    return (state_.contacts.Weights().row(0) * state_.control_displacements)[2];
  }

  std::vector<OrganModel> models_ =
      OneOrgan(FiniteOptions(), Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2));
  OrganState state_{models_[0], 1};
  InversionRecovery inversion_recovery_{models_[0], state_};
};

TEST_F(InversionRecoveryTest, AFeasibleStepIsFollowedAtOnce) {
  Hold(Vector3d(0, 0, 0.01));
  Relax();
  EXPECT_FALSE(inversion_recovery_.inverted());
  EXPECT_FALSE(inversion_recovery_.recovering());
  EXPECT_NEAR(Height(), 0.01, 1e-9);  // the pad compliance's share
}

TEST_F(InversionRecoveryTest, AnInvertingStepIsRejectedAndApproachedWithinASecond) {
  Hold(Vector3d(0, 0, -0.12));
  Relax();
  EXPECT_TRUE(inversion_recovery_.inverted());
  EXPECT_TRUE(inversion_recovery_.recovering());
  EXPECT_NEAR(Height(), 0, 1e-9) << "the last sound state was rest";
  for (int step = 0; step < 30; ++step) {
    Hold(Vector3d(0, 0, -0.12));
    Relax();
    ASSERT_EQ(state_.contacts.size(), 1) << step;
    ASSERT_GT(Evaluate().least, 0) << step;
    EXPECT_TRUE(state_.contacts[0].force_W.allFinite());
  }
  EXPECT_LT(Height(), -0.01);
  EXPECT_FALSE(inversion_recovery_.inverted()) << "no load step fails any more";
  EXPECT_TRUE(inversion_recovery_.recovering());
  EXPECT_NEAR(state_.contacts[0].target_W.z(), -0.07, 1e-12) << "what is asked is left alone";
}

TEST_F(InversionRecoveryTest, ASmallerDemandEndsIt) {
  for (int step = 0; step < 30; ++step) {
    Hold(Vector3d(0, 0, -0.12));
    Relax();
  }
  const double reached = Height();
  Hold(Vector3d(0, 0, 0.9 * reached));
  Relax();
  EXPECT_FALSE(inversion_recovery_.recovering());
  EXPECT_NEAR(Height(), 0.9 * reached, 1e-9);
  state_.contacts.Clear();
  Relax();
  EXPECT_EQ(state_.control_displacements.norm(), 0);
}

TEST_F(InversionRecoveryTest, AStepThatIsNotFiniteGoesBackToTheLastSoundState) {
  Hold(Vector3d(0, 0, 0.01));
  for (int step = 0; step < 5; ++step) Relax();
  const Points sound = state_.control_displacements;
  state_.contacts.WeightRow(0)[3] = std::numeric_limits<double>::quiet_NaN();
  Relax();
  EXPECT_TRUE(inversion_recovery_.not_finite());
  EXPECT_TRUE(state_.control_displacements.allFinite());
  Hold(Vector3d(0, 0, 0.01));
  for (int step = 0; step < 30; ++step) Relax();
  EXPECT_FALSE(inversion_recovery_.recovering());
  // Iterations end at a residual of 1e-3, from different starts.
  EXPECT_LT((state_.control_displacements - sound).norm(), 1e-3 * sound.norm());
}

TEST(InversionRecovery, AllocatesNothing) {
  if (!kCountsAllocations) GTEST_SKIP() << "the sanitizer's allocator";
  OrganOptions options = FiniteOptions();
  options.energy.strain = StrainMeasure::kSmall;  // Newton's method has Eigen's scratch space
  const std::vector<OrganModel> models = OneOrgan(options, Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2));
  OrganState state(models[0], 1);
  InversionRecovery inversion_recovery(models[0], state);
  Hold(models[0], Vector3d(0, 0, -0.12), &state.contacts);
  RelaxAlone(&inversion_recovery, &state);  // allocates the solver
  const long before = AllocationsOfThisThread();
  for (int step = 0; step < 10; ++step) RelaxAlone(&inversion_recovery, &state);
  EXPECT_EQ(AllocationsOfThisThread(), before);
  EXPECT_TRUE(inversion_recovery.inverted());
}

// One of the two loops has a clock that lets it make one or two iterations, the other applies its
// log.
TEST(InversionRecovery, AReplayRejectsTheSameSteps) {
  const std::vector<OrganModel> models =
      OneOrgan(FiniteOptions(MaterialLaw::kNeoHookean), Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2));
  Nanoseconds now = 0, longer = 0;
  const auto clock = [&] { return now += 4'000'000 + (longer += 7'000'001) % 9'000'000; };
  struct LoopAndEdges {
    LoopAndEdges(const std::vector<OrganModel>& organs, std::function<Nanoseconds()> stopwatch)
        : render(SizedSnapshot(organs, 1, false)),
          telemetry(SizedSnapshot(organs, 1, false)),
          loop(organs, {ToolOptions{.geometries = {{.tip_radius = 0.02, .can_grasp = true}}}},
               {tools, patch, render, telemetry, &steps}, std::move(stopwatch)) {}
    TripleBuffer<ToolState> tools;
    TripleBuffer<ContactPatch> patch;
    TripleBuffer<SceneSnapshot> render, telemetry;
    SpscQueue<StepSample> steps{4};
    DeformationLoop loop;
  } live(models, clock), replay(models, nullptr);
  bool out_of_time = false;
  std::uint32_t flags = 0;
  for (int step = 0; step < 40; ++step) {
    ToolState state;
    state.tool_count = 1;
    ToolPose& tool = state.tools[0];
    tool.jaw = step > 1 ? 0 : 1;
    tool.X_WT.translation() = Vector3d(0, 0, step < 4 ? 0.07 : -0.07);
    tool.p_trocar_W = Vector3d(0, 0, 0.3);
    const Nanoseconds at = step * kNanosecondsPerSecond / 30;
    live.loop.Step(state, at);
    StepSample recorded, repeated;
    ASSERT_TRUE(live.steps.Pop(&recorded));
    out_of_time = out_of_time || recorded.organs[0].out_of_time;
    flags |= recorded.step.flags;
    replay.loop.ApplyRecorded(recorded);
    replay.loop.Step(state, at);
    ASSERT_TRUE(replay.steps.Pop(&repeated));
    ASSERT_EQ(recorded.step.flags, repeated.step.flags) << step;
    ASSERT_EQ(live.loop.organ(0).vertices, replay.loop.organ(0).vertices) << step;
    ASSERT_EQ(recorded.contacts[0].force_on_tissue_W, repeated.contacts[0].force_on_tissue_W);
  }
  EXPECT_TRUE(out_of_time);
  EXPECT_NE(flags & kStepRecovering, 0u);
  EXPECT_NE(flags & kStepInverted, 0u);
}

}  // namespace
}  // namespace hpdm
