#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "engine/deformation_loop.h"
#include "tests/support/counted_allocations.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

constexpr Nanoseconds kPeriod = kNanosecondsPerSecond / 30;
const Vector3d kAxes(0.06, 0.05, 0.04);  // m, half of each organ's
constexpr double kApart = 0.2;           // m, beyond a tip's reach of the next organ

OrganOptions Tissue(const char* name = "tissue") {
  OrganOptions options;
  options.name = name;
  options.energy.type = EnergyType::kMetric;
  options.lattice.cells = {2, 2, 2};
  options.supports.push_back({BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)}, {}});
  return options;
}

OrganOptions WithLocalFunctions() {
  OrganOptions options = Tissue("refined");
  options.energy.type = EnergyType::kStrain;
  options.lattice.local.functions = 8;
  return options;
}

OrganOptions Viscous(StrainMeasure strain) {
  OrganOptions options = Tissue("viscous");
  options.energy.strain = strain;
  options.material.prony = {.count = 1, .terms = {{{.share = 0.5, .time = 0.05}}}};
  return options;
}

OrganOptions Of(OrganModelType model) {
  OrganOptions options = Tissue("surface");
  options.model = model;
  if (model == OrganModelType::kRigid) options.supports.clear();
  return options;
}

/// Organs in a row along x, kApart from middle to middle, and one tool.
class Row {
 public:
  explicit Row(const std::vector<OrganOptions>& options) {
    for (std::size_t o = 0; o < options.size(); ++o) {
      Isometry3d X = Isometry3d::Identity();
      X.translation().x() = kApart * static_cast<double>(o);
      organs_.emplace_back(options[o], Ellipsoid(kAxes, 2, X));
    }
    render = std::make_unique<TripleBuffer<SceneSnapshot>>(SizedSnapshot(organs_, 1, true));
    telemetry_ = std::make_unique<TripleBuffer<SceneSnapshot>>(SizedSnapshot(organs_, 1, false));
    loop_ =
        std::make_unique<DeformationLoop>(organs_, std::vector<ToolOptions>{ToolOptions()},
                                          DeformationEdges{tools_, patches, *render, *telemetry_});
  }

  /// Runs a step with the tip `depth` (m) below the top of an organ; negative: above.
  void Step(double depth, int organ = 0) {
    const Vector3d tip(kApart * organ + 0.01, 0.005, kAxes.z() - depth);
    StepAt(tip, tip + Vector3d(0, 0, 0.3));
  }
  void StepAt(const Vector3d& tip, const Vector3d& trocar) {
    ToolState state;
    state.tick = ++number_;
    state.time_ns = static_cast<Nanoseconds>(number_) * kPeriod;
    state.tool_count = 1;
    state.tools[0].X_WT.linear() =
        Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), trocar - tip).toRotationMatrix();
    state.tools[0].X_WT.translation() = tip;
    state.tools[0].p_trocar_W = trocar;
    loop_->Step(state, state.time_ns);
    patches.Update();
  }
  /// Runs steps with the tip out of every organ's reach until `organ` sleeps. Returns their number,
  /// or -1 after `most`.
  int StepsToSleep(int organ, int most) {
    for (int steps = 1; steps <= most; ++steps) {
      Step(-1);
      if (!loop_->organ(organ).awake) return steps;
    }
    return -1;
  }
  const OrganState& state(int organ) const { return loop_->organ(organ); }
  const Points& rest(int organ) const { return organs_[organ].rest().vertices; }
  const StepRecord& record() const { return loop_->record(); }
  std::uint64_t number() const { return number_; }

  TripleBuffer<ContactPatch> patches;
  std::unique_ptr<TripleBuffer<SceneSnapshot>> render;

 private:
  std::vector<OrganModel> organs_;
  TripleBuffer<ToolState> tools_;
  std::unique_ptr<TripleBuffer<SceneSnapshot>> telemetry_;
  std::unique_ptr<DeformationLoop> loop_;
  std::uint64_t number_ = 0;
};

// m below the top: down, sideways and back, out of reach, and down again.
const std::vector<double> kPalpation = {-0.03, -0.004, 0.002, 0.008, 0.012, 0.009, 0.004,
                                        -0.01, -1,     -1,    0.003, 0.006, -0.02, -1};

TEST(SleepingOrgan, LeavesTheStepsOfATouchedOneAsTheyAre) {
  for (const OrganOptions& touched :
       {WithLocalFunctions(), Viscous(StrainMeasure::kSmall), Viscous(StrainMeasure::kFinite),
        Of(OrganModelType::kMassSpring)}) {
    SCOPED_TRACE(touched.name);
    Row alone({touched});
    Row among({touched, Of(OrganModelType::kRigid), Of(OrganModelType::kContinuum)});
    for (const double depth : kPalpation) {
      alone.Step(depth);
      among.Step(depth);
      ASSERT_EQ(among.state(0).vertices, alone.state(0).vertices);
      ASSERT_EQ(among.state(0).control_displacements, alone.state(0).control_displacements);
      ASSERT_EQ(among.record().flags, alone.record().flags);
      ASSERT_EQ(among.record().iterations, alone.record().iterations);
      ASSERT_EQ(among.record().residual, alone.record().residual);
      const ToolPatch &a = among.patches.Front().tools[0].main(),
                      &b = alone.patches.Front().tools[0].main();
      ASSERT_EQ(a.force_on_tissue_W, b.force_on_tissue_W);
      ASSERT_EQ(a.p_original_W, b.p_original_W);
      ASSERT_EQ(a.compliance_W, b.compliance_W);
      for (int o = 1; o < 3; ++o) {
        EXPECT_FALSE(among.state(o).awake) << o;
        EXPECT_EQ(among.state(o).vertices, among.rest(o));
      }
    }
  }
}

TEST(SleepingOrgan, WakesInTheStepThatTouchesItAndSleepsInTheOneThatLetsGo) {
  Row row({Tissue(), WithLocalFunctions(), Of(OrganModelType::kRigid)});
  for (const int organ : {0, 1, 0, 1}) {
    row.Step(-0.02, organ);
    EXPECT_FALSE(row.state(organ).awake) << "a tip is near, and no more";
    row.Step(0.006, organ);
    EXPECT_TRUE(row.state(organ).awake);
    EXPECT_EQ(row.state(organ).version, row.number());
    EXPECT_GT(row.patches.Front().tools[0].main().force_on_tissue_W.norm(), 0.05);
    EXPECT_GT((row.state(organ).vertices - row.rest(organ)).cwiseAbs().maxCoeff(), 1e-4);
    EXPECT_FALSE(row.state(1 - organ).awake);
    row.Step(-0.02, organ);
    EXPECT_FALSE(row.state(organ).awake);
    EXPECT_EQ(row.state(organ).vertices, row.rest(organ));
    EXPECT_EQ(row.state(organ).version, row.number()) << "it came back in this step";
  }
  EXPECT_EQ(row.state(2).version, 0u);
}

TEST(SleepingOrgan, WakesUnderAShaft) {
  Row row({Tissue(), Of(OrganModelType::kRigid)});
  // The shaft is slanted over the first organ's top, with the tip beyond the reach of either.
  const Vector3d tip(0.09, 0.1, kAxes.z() - 0.005), trocar(-0.09, -0.1, kAxes.z() - 0.005);
  row.StepAt(tip + Vector3d(0, 0, 0.05), trocar + Vector3d(0, 0, 0.05));
  EXPECT_FALSE(row.state(0).awake);
  row.StepAt(tip, trocar);
  EXPECT_TRUE(row.state(0).awake);
  EXPECT_TRUE(row.patches.Front().tools[0].main().shaft_contact);
  EXPECT_FALSE(row.state(1).awake);
}

TEST(SleepingOrgan, AViscousOneStaysAwakeUntilItHasRecovered) {
  for (const StrainMeasure strain : {StrainMeasure::kSmall, StrainMeasure::kFinite}) {
    Row row({Viscous(strain)});
    for (int i = 0; i < 10; ++i) row.Step(0.006);
    const double before = row.state(0).control_displacements.cwiseAbs().maxCoeff();
    // The decay exp(-t / tau) takes it below a nanometre.
    const double expected = std::log(before / 1e-9) * 0.1 * 30;
    row.Step(-1);
    EXPECT_TRUE(row.state(0).awake);
    EXPECT_NE(row.state(0).vertices, row.rest(0));
    const int steps = 1 + row.StepsToSleep(0, 200);
    EXPECT_NEAR(steps, expected, 2);
    EXPECT_EQ(row.state(0).vertices, row.rest(0));
    row.Step(0.006);
    EXPECT_TRUE(row.state(0).awake);
  }
}

TEST(SleepingOrgan, ModelsWithAMotionOfTheirOwnSleepOnceItHasDied) {
  for (const OrganModelType model : {OrganModelType::kContinuum, OrganModelType::kMassSpring}) {
    Row row({Of(model)});
    for (int i = 0; i < 5; ++i) row.Step(0.006);
    row.Step(-1);
    EXPECT_TRUE(row.state(0).awake);
    // Damped by 20/s or more, from a centimetre to a nanometre: within a few seconds.
    EXPECT_GT(row.StepsToSleep(0, 300), 0);
    EXPECT_EQ(row.state(0).vertices, row.rest(0));
    EXPECT_TRUE(row.state(0).control_displacements.isZero(0));
  }
}

TEST(SleepingOrgan, IsCarriedByItsMotionWithoutANewShape) {
  OrganOptions breathing = Tissue();
  breathing.motion = {.displacement_W = Vector3d(0, 0, 0.02), .frequency = 0.25};
  Row row({breathing});
  for (int i = 0; i < 30; ++i) row.Step(-1);
  ASSERT_TRUE(row.render->Update());
  const OrganSnapshot& shape = row.render->Front().organs[0];
  EXPECT_EQ(shape.version, 0u);
  EXPECT_GT(shape.offset_W.z(), 0.005);
  EXPECT_FALSE(row.state(0).awake);
  EXPECT_EQ(shape.vertices, row.rest(0).cast<float>());
  row.Step(-0.01);  // above its rest, and in it now
  EXPECT_TRUE(row.state(0).awake);
}

// Readers take a slot now and then: each slot must catch up with the steps that it missed.
TEST(SleepingOrgan, EverySlotOfAnEdgeHasTheShapesOfItsStep) {
  Row row({WithLocalFunctions(), Tissue()});
  int step = 0;
  for (int round = 0; round < 4; ++round) {
    for (const double depth : kPalpation) {
      row.Step(depth, round % 2);
      if (++step % 3 == 0 || step % 7 == 0) {
        ASSERT_TRUE(row.render->Update());
        const SceneSnapshot& scene = row.render->Front();
        ASSERT_EQ(scene.step.number, row.number());
        for (int o = 0; o < 2; ++o) {
          const OrganSnapshot& shape = scene.organs[static_cast<std::size_t>(o)];
          const OrganState& state = row.state(o);
          ASSERT_EQ(shape.version, state.version);
          ASSERT_EQ(shape.control_displacements,
                    state.control_displacements.topRows(shape.control_displacements.rows()));
          // There is no indentation at this vertex.
          if (shape.indentation_count == 0) {
            ASSERT_EQ(shape.vertices, state.vertices.cast<float>());
          }
        }
      }
    }
  }
}

TEST(SleepingOrgan, StepsAllocateNothing) {
  if (!kCountsAllocations) GTEST_SKIP() << "a sanitizer's allocator is not counted";
  Row row({WithLocalFunctions(), Viscous(StrainMeasure::kSmall), Of(OrganModelType::kMassSpring)});
  for (int organ = 0; organ < 3; ++organ) row.Step(0.005, organ);
  const long before = AllocationsOfThisThread();
  for (int organ = 0; organ < 3; ++organ) {
    for (const double depth : kPalpation) row.Step(depth, organ);
  }
  for (int i = 0; i < 100; ++i) row.Step(-1);
  EXPECT_EQ(AllocationsOfThisThread(), before);
}

}  // namespace
}  // namespace hpdm
