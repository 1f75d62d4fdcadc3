#include "engine/base/add_product.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>

namespace hpdm {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// Entry by entry, in the order and the steps that the header states.
double ExpectedEntry(double start, double factor, const MatrixXd& A, const MatrixXd& B, Index i,
                     Index j) {
  for (Index first = 0; first < A.cols(); first += 256) {
    double sum = 0;
    for (Index k = first; k < std::min<Index>(A.cols(), first + 256); ++k) sum += A(i, k) * B(j, k);
    start += factor * sum;
  }
  return start;
}

void ExpectProduct(Index n, Index k) {
  const MatrixXd A = MatrixXd::Random(n, k), B = MatrixXd::Random(n, k),
                 before = MatrixXd::Random(n, n);
  MatrixXd C = before;
  AddProductToLower(-0.75, A, B, C);
  // Eigen's product sums in another order where there are no wide vectors.
  const double rounding = 1e-14 * static_cast<double>(k);
  for (Index j = 0; j < n; ++j) {
    for (Index i = 0; i < n; ++i) {
      const double expected = i < j ? before(i, j) : ExpectedEntry(before(i, j), -0.75, A, B, i, j);
      ASSERT_NEAR(C(i, j), expected, i < j ? 0 : rounding)
          << n << ", " << k << ": " << i << ", " << j;
    }
  }
}

TEST(AddProduct, AddsToTheLowerTriangleAlone) {
  for (const Index n : {1, 7, 16, 33, 200}) ExpectProduct(n, 48);
}

TEST(AddProduct, TakesMoreColumnsThanABlockAndMoreRowsThanOne) {
  ExpectProduct(40, 600);
  ExpectProduct(1600, 3);  // beyond the rows of B that are taken together
}

TEST(AddProduct, TakesPartsOfMatrices) {
  const MatrixXd whole = MatrixXd::Random(60, 20);
  const MatrixXd A = whole.block(5, 3, 30, 10);
  MatrixXd of_part = MatrixXd::Zero(50, 50), of_copy = MatrixXd::Zero(30, 30);
  AddProductToLower(1, whole.block(5, 3, 30, 10), whole.block(5, 3, 30, 10),
                    of_part.block(10, 10, 30, 30));
  AddProductToLower(1, A, A, of_copy);
  EXPECT_EQ(MatrixXd(of_part.block(10, 10, 30, 30)), of_copy);
  EXPECT_EQ(of_part.norm(), of_copy.norm());  // nothing outside
}

}  // namespace
}  // namespace hpdm
