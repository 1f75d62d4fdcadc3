#include "engine/threads/histogram.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

namespace hpdm {
namespace {

TEST(Histogram, IsZeroWithoutValues) {
  const Histogram histogram;
  EXPECT_EQ(histogram.count(), 0u);
  EXPECT_EQ(histogram.max(), 0);
  EXPECT_EQ(histogram.mean(), 0);
  EXPECT_EQ(histogram.Percentile(0.99), 0);
}

TEST(Histogram, SmallValuesAreExact) {
  Histogram histogram;
  for (int v = 0; v < 64; ++v) histogram.Add(v);  // one bin a value up to 2^6
  for (int v = 0; v < 64; ++v) EXPECT_EQ(histogram.Percentile((v + 1) / 64.0), v);
}

TEST(Histogram, FractionsThatRoundUpDoNotMoveToTheNextValue) {
  Histogram histogram;
  for (int v = 1; v <= 50; ++v) histogram.Add(v);
  for (int v = 51; v <= 100; ++v) histogram.Add(60);
  EXPECT_EQ(histogram.Percentile(0.07), 7) << "0.07 * 100 is 7.000000000000001";
}

TEST(Histogram, NegativeValuesCountAsZero) {
  Histogram histogram;
  histogram.Add(-5);
  EXPECT_EQ(histogram.count(), 1u);
  EXPECT_EQ(histogram.max(), 0);
  EXPECT_EQ(histogram.Percentile(1), 0);
}

TEST(Histogram, EveryPowerOfTwoUpToTheLargestHasItsBin) {
  for (int bits = 0; bits < 63; ++bits) {
    const std::int64_t power = std::int64_t{1} << bits;
    for (std::int64_t value : {power - 1, power, power + power / 3}) {
      Histogram histogram;
      histogram.Add(value);
      EXPECT_EQ(histogram.Percentile(1), value) << "never above the largest value";
    }
  }
  Histogram histogram;
  histogram.Add(std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(histogram.max(), std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(histogram.Percentile(0.5), std::numeric_limits<std::int64_t>::max());
}

TEST(Histogram, PercentilesOfLatenciesAreWithinABinOfTheExactOnes) {
  std::mt19937 random(1);
  std::lognormal_distribution<double> latency(std::log(20e3), 1.5);  // 20 us, a long tail
  Histogram histogram;
  std::vector<std::int64_t> values(100'000);
  double sum = 0;
  for (std::int64_t& v : values) {
    v = static_cast<std::int64_t>(latency(random));
    histogram.Add(v);
    sum += static_cast<double>(v);
  }
  std::sort(values.begin(), values.end());
  for (double fraction : {0.01, 0.5, 0.9, 0.99, 0.999}) {
    const auto rank = static_cast<std::size_t>(std::ceil(fraction * 100'000)) - 1;
    const auto exact = static_cast<double>(values[rank]);
    const auto read = static_cast<double>(histogram.Percentile(fraction));
    EXPECT_GE(read, exact);
    EXPECT_LE(read, exact * (1 + 1.0 / 32)) << "a bin is 1/32 of its power of two wide";
  }
  EXPECT_EQ(histogram.max(), values.back());
  EXPECT_EQ(histogram.Percentile(1), values.back());
  EXPECT_DOUBLE_EQ(histogram.mean(), sum / 100'000);
}

TEST(Histogram, MergedIsAsIfEveryValueHadBeenAddedToOne) {
  Histogram all, odd, even;
  for (std::int64_t v = 1; v < 2'000'000; v += v / 7 + 1) {
    all.Add(v);
    (v % 2 == 0 ? even : odd).Add(v);
  }
  odd.Merge(even);
  EXPECT_EQ(odd.count(), all.count());
  EXPECT_EQ(odd.max(), all.max());
  EXPECT_DOUBLE_EQ(odd.mean(), all.mean());
  for (double fraction : {0.1, 0.5, 0.99}) {
    EXPECT_EQ(odd.Percentile(fraction), all.Percentile(fraction));
  }
}

TEST(Histogram, BinsGivenAgainAreTheSameDistribution) {
  Histogram given;
  for (std::int64_t v = 0; v < 2'000'000; v += v / 7 + 1) given.Add(v);
  Histogram taken;
  std::int64_t last = -1;
  given.ForEachBin([&](std::int64_t upper_ns, std::uint64_t count) {
    EXPECT_GT(upper_ns, last);
    last = upper_ns;
    for (; count > 0; --count) taken.Add(upper_ns);
  });
  EXPECT_EQ(taken.count(), given.count());
  // Below the last bin, where a histogram knows its largest value better than the bin's bound.
  for (double fraction : {0.0, 0.1, 0.5, 0.9}) {
    EXPECT_EQ(taken.Percentile(fraction), given.Percentile(fraction));
  }
}

}  // namespace
}  // namespace hpdm
