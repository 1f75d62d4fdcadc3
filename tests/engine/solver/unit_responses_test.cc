// Displacements by unit forces against the full product, and bit for bit between widths.

#include "engine/solver/unit_responses.h"

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <vector>

namespace hpdm {
namespace {

constexpr std::array kWidths{VectorWidth::k16Bytes, VectorWidth::k32Bytes, VectorWidth::k64Bytes};

// Rows of a lattice of n control points, with entries at random places and one of a finer function.
struct Rows {
  Rows(int n, int count) : weights(count, std::vector<double>(n + 1, 0)) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (std::vector<double>& row : weights) {
      std::vector<int>& own = points.emplace_back();
      std::vector<double>& values = entries.emplace_back();
      for (int a = 0; a <= n; ++a) {
        if (a < n && uniform(random) < 0.4) continue;
        own.push_back(a);
        values.push_back(row[ToSize(a)] = uniform(random));
      }
    }
    for (std::size_t i = 0; i < points.size(); ++i) sparse.push_back({points[i], entries[i]});
  }

  std::vector<std::vector<double>> weights;
  std::vector<std::vector<int>> points;
  std::vector<std::vector<double>> entries;
  std::vector<SparseRow> sparse;
};

// 3 n below, at and above a tile of 192 rows; 21 has a rest for all widths.
TEST(UnitResponses, AreThoseOfTheFullProductWithTheSameBitsForAllWidths) {
  std::srand(7);
  for (const int n : {1, 7, 64, 65, 130}) {
    for (const int count : {1, 5}) {
      const Eigen::MatrixXd inverse = Eigen::MatrixXd::Random(3 * n, 3 * n);
      const Rows rows(n, count);
      Eigen::MatrixXd loads = Eigen::MatrixXd::Zero(3 * n, 3 * count);
      for (int i = 0; i < count; ++i) {
        for (int a = 0; a < n; ++a) {
          for (int d = 0; d < 3; ++d) {
            loads(3 * a + d, 3 * i + d) = rows.weights[ToSize(i)][ToSize(a)];
          }
        }
      }
      Eigen::MatrixXd narrow(3 * n, 3 * count);
      narrow.setConstant(9);
      FillUnitResponses(inverse, rows.sparse, narrow, kWidths[0]);
      EXPECT_LT((narrow - inverse * loads).norm(), 1e-13 * inverse.norm()) << n << ' ' << count;
      for (const VectorWidth width : kWidths) {
        if (!HasVectors(width)) continue;
        Eigen::MatrixXd responses(3 * n, 3 * count);
        FillUnitResponses(inverse, rows.sparse, responses, width);
        EXPECT_EQ(responses, narrow) << n << ' ' << count;
      }
    }
  }
}

}  // namespace
}  // namespace hpdm
