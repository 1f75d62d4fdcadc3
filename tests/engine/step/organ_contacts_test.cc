#include "engine/step/organ_contacts.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "engine/statics/static_loads.h"
#include "tests/support/counted_allocations.h"
#include "tests/support/shapes.h"
#include "tools/shared/organ_bench.h"

namespace hpdm {
namespace {

constexpr double kHalfPeriod = 1;  // s: then an organ's offset is its whole displacement

// A bar along z from `from` to `to`, held at its end z = `held`.
struct Bar {
  double from = 0, to = 0.05, held = 0;  // m
  double young = 5000;                   // Pa
  double poisson = 0;
  double width = 0.05;  // m: far below the load at which it buckles
  Vector3d displacement_W = Vector3d::Zero();
  int squares = 14;
  PronySeries prony = {};
};

void AddBar(const Bar& bar, OrganBench* bodies, std::optional<double> friction = std::nullopt) {
  OrganOptions options;
  options.name = "bar at " + std::to_string(bar.from);
  options.energy.type = EnergyType::kStrain;
  options.material.young = bar.young;
  options.material.poisson = bar.poisson;
  options.material.prony = bar.prony;
  options.lattice.cells = {2, 2, 4};
  options.lattice.margin = 0.001;
  options.lattice.local.functions = 0;
  const double thin = 0.02 * (bar.to - bar.from);
  const double low = bar.held > bar.from ? bar.held - thin : bar.from - thin;
  options.supports.push_back(
      {hpdm::Box{Vector3d(-1, -1, low), Vector3d(1, 1, low + 2 * thin)}, {}});
  options.motion = {bar.displacement_W, 0.5 / kHalfPeriod};
  bodies->Add(options,
              GridBox(Vector3d(-bar.width / 2, -bar.width / 2, bar.from),
                      Vector3d(bar.width / 2, bar.width / 2, bar.to),
                      {bar.squares, bar.squares, bar.squares}),
              friction);
}

// The upper bar's support moves down by `press` (m).
void PressBars(const Bar& lower, Bar upper, double press, double friction, OrganBench* bodies) {
  upper.displacement_W = Vector3d(0, 0, -press);
  AddBar(lower, bodies);
  AddBar(upper, bodies, friction);
  bodies->Start();
  for (int step = 0; step <= 60; ++step) {
    bodies->StayAt(std::min(kHalfPeriod, step * kHalfPeriod / 40));
    bodies->Step();
  }
}

// Displacement of the bar's end z = `end` by a unit force spread over it, m/N.
double EndCompliance(double end, const OrganModel& bar) {
  LoadOptions load;
  load.organ = bar.options().name;
  load.pressure = 1;
  load.region = hpdm::Box{Vector3d(-1, -1, end - 1e-6), Vector3d(1, 1, end + 1e-6)};
  const Points u = StaticLoads(bar, {load}).Solve().vertex_displacements;
  double sum = 0, count = 0, width = 0;
  for (Eigen::Index v = 0; v < u.rows(); ++v) {
    const Vector3d p = bar.rest().vertices.row(v);
    if (std::abs(p.z() - end) > 1e-9) continue;
    sum += std::abs(u(v, 2));
    count += 1;
    width = std::max(width, 2 * std::abs(p.x()));
  }
  return sum / count / (width * width);
}

struct BarCase {
  std::string name;
  double young_below, young_above;  // Pa
  int squares_below, squares_above;
  double press;  // m
};

class BarsInSeries : public testing::TestWithParam<BarCase> {};

INSTANTIATE_TEST_SUITE_P(Cases, BarsInSeries,
                         testing::Values(BarCase{"equal", 5000, 5000, 14, 14, 0.002},
                                         BarCase{"softer_above", 9000, 3000, 14, 14, 0.004},
                                         BarCase{"other_meshes", 5000, 8000, 10, 23, 0.001}),
                         [](const auto& param_info) { return param_info.param.name; });

TEST_P(BarsInSeries, ForceIsThatOfTheirStiffnessesInSeries) {
  const BarCase& given = GetParam();
  OrganBench bodies;
  const Bar lower{
      .from = 0, .to = 0.05, .held = 0, .young = given.young_below, .squares = given.squares_below};
  const Bar upper{.from = 0.05,
                  .to = 0.08,
                  .held = 0.08,
                  .young = given.young_above,
                  .squares = given.squares_above};
  PressBars(lower, upper, given.press, 0, &bodies);
  const double compliance =
      EndCompliance(lower.to, bodies.model(0)) + EndCompliance(upper.from, bodies.model(1));
  const double force = given.press / compliance;
  const double area = lower.width * lower.width;
  const double rigidly_held = given.press * area / (0.05 / lower.young + 0.03 / upper.young);
  EXPECT_NEAR(force / rigidly_held, 1, 0.1) << "the supports give way little";
  EXPECT_NEAR(bodies.PairForce(1).z(), force, 0.01 * force);
  EXPECT_LT((bodies.PairForce(0) + bodies.PairForce(1)).norm(), 1e-12 * force) << "third law";
  EXPECT_EQ(bodies.record().flags & kStepContactsDropped, 0u);
}

TEST(OrganContacts, FacesOfPressedBlocksStayFlatAndTogether) {
  OrganBench bodies;
  PressBars({}, {.from = 0.05, .to = 0.1, .held = 0.1}, 0.003, 0, &bodies);
  for (int o = 0; o < 2; ++o) {
    const Points& rest = bodies.model(o).rest().vertices;
    for (Eigen::Index v = 0; v < rest.rows(); ++v) {
      if (std::abs(rest(v, 2) - 0.05) > 1e-9) continue;
      const double z = bodies.organ(o).vertices(v, 2) + bodies.organ(o).offset_W.z();
      EXPECT_NEAR(z, 0.05 - 0.0015, 0.01 * 0.003);
    }
  }
}

// One bar is stiff: the other one rests on it as on a wall.
TEST(OrganContacts, FrictionHoldsUpToItsCoefficient) {
  for (const double friction : {0.0, 0.1, 0.3}) {
    OrganBench bodies;
    AddBar({.young = 20000, .poisson = 0.3, .width = 0.08, .squares = 20}, &bodies);
    AddBar({.from = 0.05,
            .to = 0.07,
            .held = 0.07,
            .young = 20000,
            .poisson = 0.3,
            .displacement_W = Vector3d(0.006, 0, -0.001)},
           &bodies, friction);
    bodies.Start();
    for (int step = 0; step <= 40; ++step) {
      bodies.StayAt(step * kHalfPeriod / 40);
      bodies.Step();
    }
    const Vector3d force = bodies.PairForce(0);
    EXPECT_LT(force.z(), -0.01);
    EXPECT_NEAR(force.x(), friction * -force.z(), 0.02 * -force.z()) << friction;
    EXPECT_LT(std::abs(force.y()), 0.02 * -force.z());
  }
}

TEST(OrganContacts, StickingFacesMoveTogether) {
  OrganBench bodies;
  AddBar({.poisson = 0.3}, &bodies);
  AddBar({.from = 0.05,
          .to = 0.1,
          .held = 0.1,
          .poisson = 0.3,
          .displacement_W = Vector3d(0.0005, 0, -0.004)},
         &bodies, 5.0);
  bodies.Start();
  for (int step = 0; step <= 40; ++step) {
    bodies.StayAt(step * kHalfPeriod / 40);
    bodies.Step();
  }
  // The two bars are equal, so each face moves by half of the shift.
  Vector3d means[2];
  for (int o = 0; o < 2; ++o) {
    means[o].setZero();
    int count = 0;
    const Points& rest = bodies.model(o).rest().vertices;
    for (Eigen::Index v = 0; v < rest.rows(); ++v) {
      if (std::abs(rest(v, 2) - 0.05) > 1e-9) continue;
      const Vector3d p = bodies.organ(o).vertices.row(v).transpose() + bodies.organ(o).offset_W;
      means[o] += p - rest.row(v).transpose();
      ++count;
    }
    means[o] /= count;
  }
  EXPECT_NEAR(means[0].x(), 0.00025, 0.00002);
  EXPECT_LT((means[0] - means[1]).norm(), 0.00002);
}

TEST(OrganContacts, PartedOrgansSleepAtRest) {
  OrganBench bodies;
  AddBar({}, &bodies);
  AddBar({.from = 0.0505, .to = 0.1, .held = 0.1, .displacement_W = Vector3d(0, 0, -0.002)},
         &bodies, 0.2);
  bodies.Start();
  bodies.Step();
  EXPECT_FALSE(bodies.organ(0).awake);
  for (int step = 0; step <= 80; ++step) {  // down and up again
    bodies.StayAt(step * kHalfPeriod / 40);
    bodies.Step();
    if (step == 40) {
      EXPECT_TRUE(bodies.organ(0).awake);
      EXPECT_GT(bodies.PairForce(1).z(), 0);
    }
  }
  for (int o = 0; o < 2; ++o) {
    EXPECT_FALSE(bodies.organ(o).awake) << o;
    EXPECT_TRUE(bodies.organ(o).control_displacements.isZero(0)) << o;
  }
}

// A tip presses a plate down that rests on a bar, unless they pass through each other.
struct PressedPlate {
  Matrix3d compliance_W;  // of the tip's patch
  Matrix3d series_W;      // the same
  double force = 0;       // N, along z on the plate
};
PressedPlate PressPlate(double depth, bool pair, const PronySeries& prony = {}, int steps = 20) {
  OrganBench bodies;
  AddBar({.poisson = 0.3, .width = 0.05, .prony = prony}, &bodies);
  // Held softly, so that most of the press goes through it.
  OrganOptions plate;
  plate.name = "plate";
  plate.energy.type = EnergyType::kStrain;
  plate.material = {.young = 20000, .poisson = 0.3, .prony = prony};
  plate.lattice.cells = {3, 3, 2};
  plate.lattice.local.functions = 0;
  plate.supports.push_back({hpdm::Box{Vector3d(-1, -1, 0), Vector3d(1, 1, 1)}, 1e4});
  bodies.Add(plate,
             GridBox(Vector3d(-0.04, -0.04, 0.0501), Vector3d(0.04, 0.04, 0.07), {20, 20, 6}),
             pair ? std::optional(0.0) : std::nullopt);
  bodies.Start();
  for (int step = 0; step < steps; ++step) {
    bodies.Step(OrganBench::Above(
        Vector3d(0, 0, 0.07 + kDefaultToolRadius - depth * std::min(1.0, step / 10.0))));
  }
  const ToolPatch& patch = bodies.patch.Front().tools[0].main();
  return {patch.compliance_W, patch.series_W, bodies.ToolForce(1).z()};
}

// The patch's compliance is that of both: the force changes as two solved steps say.
TEST(OrganContacts, TipFeelsTheOrganBeneath) {
  constexpr double kDepth = 0.004, kMore = 0.0001;
  double of_patch[2], of_steps[2];
  for (const bool pair : {false, true}) {
    const PressedPlate less = PressPlate(kDepth, pair), more = PressPlate(kDepth + kMore, pair);
    of_patch[pair] = more.compliance_W.inverse()(2, 2);
    of_steps[pair] = (less.force - more.force) / kMore;
  }
  EXPECT_GT(of_steps[true], 1.5 * of_steps[false]) << "the organ beneath is felt";
  // The patch's compliance under a ball is a secant: about the same share of the tangent for both.
  // The contact beneath grows with the press, by cells, which the held compliance does not know.
  EXPECT_NEAR(of_patch[true] / of_steps[true], of_patch[false] / of_steps[false], 0.15);
}

// The patch's compliance is that after relaxation, also of the contact beneath.
TEST(OrganContacts, TipFeelsTheViscoelasticOrganBeneathAfterRelaxation) {
  constexpr double kDepth = 0.004;
  constexpr PronySeries kProny{.count = 1, .terms = {{{0.8, 0.05}}}};
  const PressedPlate elastic = PressPlate(kDepth, true);
  const PressedPlate relaxed = PressPlate(kDepth, true, kProny, 60);
  // 2 s after the press has come to rest, so it has ended at the elastic contact.
  EXPECT_NEAR(relaxed.force, elastic.force, 1e-3 * std::abs(elastic.force));
  EXPECT_LT((relaxed.compliance_W - elastic.compliance_W).norm(),
            1e-3 * elastic.compliance_W.norm());
  // Alone the plate stands on its spring, on the bar hardly.
  const PressedPlate alone = PressPlate(kDepth, false, kProny, 60);
  EXPECT_GT(alone.series_W(2, 2), 0.1 * alone.compliance_W(2, 2));
  EXPECT_LT(relaxed.series_W(2, 2), 0.1 * alone.series_W(2, 2));
  for (const int steps : {3, 5, 12}) {
    const PressedPlate early = PressPlate(kDepth, true, kProny, steps);
    const Matrix3d tissue_W = early.compliance_W - early.series_W;
    EXPECT_GT(tissue_W.eigenvalues().real().minCoeff(), 0) << steps;
  }
}

TEST(OrganContacts, StepAllocatesNothing) {
  if (!kCountsAllocations) GTEST_SKIP() << "the sanitizer's allocator";
  OrganBench bodies;
  AddBar({.squares = 18}, &bodies);
  AddBar({.from = 0.05,
          .to = 0.1,
          .held = 0.1,
          .poisson = 0.3,
          .displacement_W = Vector3d(0.004, 0, -0.003),
          .squares = 18},
         &bodies, 0.2);
  bodies.Start();
  const long before = AllocationsOfThisThread();
  for (int step = 0; step <= 40; ++step) {
    bodies.StayAt(step * kHalfPeriod / 40);
    bodies.Step(OrganBench::Above(Vector3d(0, 0, step < 20 ? 5 : 0.1)));
  }
  EXPECT_EQ(AllocationsOfThisThread(), before);
  EXPECT_GT(bodies.organ(0).contacts.size(), 8);
}

}  // namespace
}  // namespace hpdm
