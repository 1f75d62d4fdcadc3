#include "tools/haptics/stability_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "haptics/safety/passivity.h"
#include "tests/support/scratch_folder.h"
#include "tools/haptics/stability_plant.h"

namespace hpdm {
namespace {

const StabilityMap& QuickMap() {
  static const StabilityMap map = MeasureStability({.quick = true});
  return map;
}

TEST(StabilityMap, WithoutFrictionTheMeasuredBoundaryIsThatOfTheExactRoots) {
  int compared = 0;
  for (const StabilityRow& row : QuickMap().rows) {
    compared += row.of == StabilityCase::kBare && !row.control;
  }
  EXPECT_EQ(compared, 6);
  // 2 % is the promise; bisection stops at 0.2 %.
  EXPECT_LT(LargestDeviation(QuickMap()), 0.005);
}

TEST(StabilityMap, TheKnownDeviceLosesItsStabilityAt1001And334NewtonsAMetre) {
  int found = 0;
  for (const StabilityRow& row : QuickMap().rows) {
    if (row.of != StabilityCase::kBare || row.control || !row.by_delay) continue;
    if (row.delay == 0) found += std::abs(row.measured - 1000.8) < 0.02 * 1000.8;
    if (row.delay == 1e-3) found += std::abs(row.measured - 333.8) < 0.02 * 333.8;
  }
  EXPECT_EQ(found, 2);
}

TEST(StabilityMap, TheControllerNeverLowersTheBoundaryAndRaisesTheBareOneTenfold) {
  const std::vector<StabilityRow>& rows = QuickMap().rows;
  for (const StabilityRow& on : rows) {
    if (!on.control) continue;
    for (const StabilityRow& off : rows) {
      if (off.control || off.of != on.of || off.by_delay != on.by_delay ||
          off.period != on.period || off.delay != on.delay) {
        continue;
      }
      // With a hand's friction the boundary depends on how the tip stops: 5 %.
      EXPECT_GT(on.measured, 0.95 * off.measured) << on.period << ' ' << on.delay;
      // At 0.25 ms the velocity's window of 12 periods limits.
      if (on.of == StabilityCase::kBare && on.period > 0.5e-3) {
        EXPECT_GT(on.measured, 10 * off.measured) << on.period << ' ' << on.delay;
      }
    }
  }
}

TEST(StabilityMap, WithTheControllerTheBareBoundaryIsThatOfItsFullDamping) {
  // The stiffness of rigid organs is half of these roots (WallLimits). The measured loop judges a
  // force of a quarter newton and a controller that is not always at its full damping.
  const StabilityOptions& options = QuickMap().options;
  int compared = 0;
  for (const StabilityRow& row : QuickMap().rows) {
    if (row.of != StabilityCase::kBare || !row.control || row.period != 1e-3) continue;
    PassivityOptions passivity;
    passivity.period = row.period;
    passivity.device.inertia[kInsertion] = options.device.mass;
    passivity.device.encoder_step.setZero();
    const double full = FullDamping(passivity, kInsertion, 1, passivity.window, row.delay);
    const double exact = StabilityLimit(options.device, row.period, row.delay, {full, 3});
    EXPECT_NEAR(row.measured, exact, 0.2 * exact) << row.delay;
    ++compared;
  }
  EXPECT_GE(compared, 3);
}

TEST(StabilityMap, RowsInAHandStateTheDampingOfBoth) {
  for (const StabilityRow& row : QuickMap().rows) {
    EXPECT_EQ(row.damping, row.of == StabilityCase::kBare ? 0.5 : 6.5);
    EXPECT_DOUBLE_EQ(row.passivity, 2 * 0.5 / row.period);  // below 2 f_c / step = 8,000 N/m
  }
}

TEST(StabilityMap, TableHasALineForEachRow) {
  const ScratchFolder folder;
  const std::string path = (folder.path() / "stability.csv").string();
  WriteStabilityCsv(QuickMap(), path);
  std::ifstream file(path);
  std::string line;
  std::size_t lines = 0;
  while (std::getline(file, line)) ++lines;
  EXPECT_EQ(lines, 1 + QuickMap().rows.size());
}

JointVector PlantStart() { return (JointVector() << 0, 0, 0.1, 0, 1).finished(); }

// A device with its force off follows its own dynamics alone.
StabilityPlant Plant(StabilityPlantOptions options) {
  options.push = 0;
  return {options, PlantStart()};
}

TEST(StabilityPlant, SamplesAreAsOldAsTheyClaim) {
  for (const Nanoseconds delay : {0, 300'000, 1'000'000, 2'700'000, 5'000'000}) {
    StabilityPlant plant = Plant({.axis = {0.1, 0}, .delay_ns = delay});
    plant.Read(0);
    plant.Release(0.05);
    for (int k = 1; k < 40; ++k) {
      const DeviceSample sample = plant.Read(k * 1'000'000);
      EXPECT_EQ(sample.time_ns, k * 1'000'000 - delay);
      const double x = 0.05 * std::max(0.0, ToSeconds(sample.time_ns));
      EXPECT_NEAR(sample.joints[kInsertion], 0.1 + x, 1e-15) << delay;  // round-off at 0.1 m
    }
  }
}

TEST(StabilityPlant, FrictionStopsItWhereItsWorkIsTheKineticEnergy) {
  StabilityPlant plant = Plant({.axis = {0.1, 0}, .friction = 0.4});
  plant.Release(0.2);
  for (int k = 0; k < 100; ++k) plant.Advance(1e-3);
  EXPECT_EQ(plant.v(), 0);
  // The stop is found to 1e-9 of a millisecond.
  EXPECT_NEAR(plant.x(), 0.5 * 0.1 * 0.2 * 0.2 / 0.4, 1e-13);
}

TEST(StabilityPlant, FrictionHoldsWhatPushesLess) {
  StabilityPlantOptions options{.axis = {0.1, 0.5}, .friction = 0.4, .push = 0.39};
  StabilityPlant held(options, PlantStart());
  options.push = 0.41;
  StabilityPlant pushed(options, PlantStart());
  held.Advance(1);
  pushed.Advance(1);
  EXPECT_EQ(held.x(), 0);
  EXPECT_NEAR(pushed.v(), 0.01 / 0.5 * (1 - std::exp(-5.0)), 1e-12);  // round-off
}

}  // namespace
}  // namespace hpdm
