#include "engine/lattice/relocation.h"

#include <gtest/gtest.h>

#include "tests/support/counted_allocations.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

// Computes x = X + B U vertex by vertex, in the order of the columns.
Points RowByRow(const Points& rest, const WeightMatrix& weights, const Points& U) {
  Points x(rest.rows(), 3);
  for (int v = 0; v < rest.rows(); ++v) {
    Vector3d sum = Vector3d::Zero();
    for (WeightMatrix::InnerIterator it(weights, v); it; ++it) {
      sum += it.value() * U.row(it.index()).transpose();
    }
    x.row(v) = rest.row(v) + sum.transpose();
  }
  return x;
}

class RelocationTest : public testing::TestWithParam<int> {
 protected:
  RelocationTest() : rest_(Ellipsoid(Vector3d(0.1, 0.07, 0.03), 3, SomePose()).vertices) {
    const int cells = GetParam();
    if (cells == 0) {  // every vertex by itself
      weights_.resize(rest_.rows(), rest_.rows());
      weights_.setIdentity();
    } else {
      LatticeOptions options;
      options.cells = {cells, cells, cells};
      weights_ =
          Lattice(BoundingLatticeBox(rest_, Matrix3d::Identity(), 0.02), options).Weights(rest_);
    }
    srand(1);
    U_ = 0.01 * Points::Random(weights_.cols(), 3);
  }
  Points rest_;
  WeightMatrix weights_;
  Points U_;
};
// One cell: all rows alike. Nine: blocks that straddle cells.
INSTANTIATE_TEST_SUITE_P(Cells, RelocationTest, testing::Values(0, 1, 4, 9));

TEST_P(RelocationTest, FastPlainAndRowByRowHaveTheSameBits) {
  const Relocation relocation(rest_, weights_);
  Points fast(rest_.rows(), 3), plain(rest_.rows(), 3);
  relocation.Relocate(U_, &fast);
  relocation.RelocatePlainly(U_, &plain);
  EXPECT_EQ(fast, plain);
  EXPECT_EQ(fast, RowByRow(rest_, weights_, U_));
}

TEST_P(RelocationTest, RelocationAddsTheDisplacement) {
  const Relocation relocation(rest_, weights_);
  Points x(rest_.rows(), 3), u(rest_.rows(), 3);
  relocation.Relocate(U_, &x);
  relocation.Displace(U_, &u);
  EXPECT_EQ(x, rest_ + u);
}

TEST_P(RelocationTest, NoDisplacementGivesTheRestShapeExactly) {
  Points x(rest_.rows(), 3);
  Relocation(rest_, weights_).Relocate(Points::Zero(weights_.cols(), 3), &x);
  EXPECT_EQ(x, rest_);
}

TEST_P(RelocationTest, TakesAnyNumberOfVertices) {
  for (const int count : {0, 1, 7, 8, 9}) {
    const Points rest = rest_.topRows(count);
    const WeightMatrix weights = weights_.topRows(count);
    Points x(count, 3);
    Relocation(rest, weights).Relocate(U_, &x);
    EXPECT_EQ(x, RowByRow(rest, weights, U_));
  }
}

TEST_P(RelocationTest, ProductsAllocateNothing) {
  if (!kCountsAllocations) GTEST_SKIP() << "a sanitizer's allocator is in use";
  const Relocation relocation(rest_, weights_);
  Points x(rest_.rows(), 3);
  const long before = AllocationsOfThisThread();
  relocation.Relocate(U_, &x);
  relocation.Displace(U_, &x);
  EXPECT_EQ(AllocationsOfThisThread(), before);
}

}  // namespace
}  // namespace hpdm
