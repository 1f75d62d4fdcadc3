#include "engine/tissue/moment_compression.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace hpdm {
namespace {

struct Rule {
  Points points;
  Eigen::VectorXd weights;
};

/// Random points of the part of [-1, 1]^3 below an oblique plane.
Rule RandomRule(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> coordinate(-1, 1), weight(0.1, 1);
  Rule rule{Points(count, 3), Eigen::VectorXd(count)};
  for (Eigen::Index q = 0; q < count; ++q) {
    do {
      for (int d = 0; d < 3; ++d) rule.points(q, d) = coordinate(random);
    } while (rule.points.row(q).sum() > -0.5);
    rule.weights[q] = weight(random);
  }
  return rule;
}

double Moment(const Rule& rule, int i, int j, int k) {
  double sum = 0;
  for (Eigen::Index q = 0; q < rule.weights.size(); ++q) {
    sum += rule.weights[q] * std::pow(rule.points(q, 0), i) * std::pow(rule.points(q, 1), j) *
           std::pow(rule.points(q, 2), k);
  }
  return sum;
}

TEST(MomentCompression, KeepsEveryMomentOnFewPositivePoints) {
  for (const int degree : {0, 1, 2, 3, 4}) {
    for (const int count : {100, 5000}) {
      const Rule many = RandomRule(count, 17);
      Rule few = many;
      CompressMoments(degree, &few.points, &few.weights);
      EXPECT_LE(few.weights.size(), MomentCount(degree));
      EXPECT_EQ(few.points.rows(), few.weights.size());
      EXPECT_GT(few.weights.minCoeff(), 0);
      for (int i = 0; i <= degree; ++i) {
        for (int j = 0; j <= degree; ++j) {
          for (int k = 0; k <= std::min(degree, 2 * degree - i - j); ++k) {
            // Round-off of some ten eliminations with a well-conditioned basis.
            EXPECT_NEAR(Moment(few, i, j, k), Moment(many, i, j, k), 1e-11 * many.weights.sum());
          }
        }
      }
    }
  }
}

TEST(MomentCompression, ChoosesAmongTheGivenPoints) {
  const Rule many = RandomRule(300, 4);
  Rule few = many;
  CompressMoments(3, &few.points, &few.weights);
  for (Eigen::Index q = 0; q < few.points.rows(); ++q) {
    EXPECT_EQ((many.points.rowwise() - few.points.row(q)).rowwise().norm().minCoeff(), 0);
  }
}

TEST(MomentCompression, LeavesFewPointsAlone) {
  const Rule rule = RandomRule(20, 9);
  Rule same = rule;
  CompressMoments(3, &same.points, &same.weights);
  EXPECT_EQ(same.points, rule.points);
  EXPECT_EQ(same.weights, rule.weights);
}

TEST(MomentCompression, CopesWithPointsOnALine) {
  Rule line{Points::Zero(200, 3), Eigen::VectorXd::Ones(200)};
  line.points.col(0).setLinSpaced(-1, 1);
  Rule few = line;
  CompressMoments(4, &few.points, &few.weights);
  EXPECT_LE(few.weights.size(), MomentCount(4));
  EXPECT_GT(few.weights.minCoeff(), 0);
  // Round-off.
  EXPECT_NEAR(Moment(few, 4, 0, 0), Moment(line, 4, 0, 0), 1e-9);
}

}  // namespace
}  // namespace hpdm
