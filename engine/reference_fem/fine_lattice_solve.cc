#include <Eigen/LU>

#include "engine/base/error.h"
#include "engine/reference_fem/fine_lattice.h"

// The iterative solution of a fine lattice: the product with its stiffness and conjugate gradients.
namespace hpdm {
namespace {

// Relative residual in the preconditioner's norm; the displacements' error is about the same.
constexpr double kFineTolerance = 3e-4;
constexpr int kMaxIterations = 20000;

// Solves L L^T X = B in place, with permuted rows and columns of L: all columns of B in one pass
// over L.
template <typename Columns>
void SolveTogether(const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>>& inner, Columns* B) {
  const Eigen::SparseMatrix<double>& L = inner.matrixL().nestedExpression();
  using Column = Eigen::SparseMatrix<double>::InnerIterator;
  Columns X = inner.permutationP() * *B;
  for (Eigen::Index j = 0; j < L.cols(); ++j) {
    Column it(L, j);
    X.row(j) /= it.value();  // the diagonal stands first
    for (++it; it; ++it) X.row(it.index()) -= it.value() * X.row(j);
  }
  for (Eigen::Index j = L.cols() - 1; j >= 0; --j) {
    Column it(L, j);
    const double diagonal = it.value();
    for (++it; it; ++it) X.row(j) -= it.value() * X.row(it.index());
    X.row(j) /= diagonal;
  }
  *B = inner.permutationPinv() * X;
}

}  // namespace

// Inverts each control point's own block, with the projections' inner products lumped.
void FineLattice::Factorise() {
  std::vector<Matrix3d> own(static_cast<std::size_t>(lattice_.size()));
  for (int a = 0; a < lattice_.size(); ++a) {
    using Block = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;
    own[a] = Eigen::Map<const Block>(&blocks_[9 * Neighbour(a, a)]).cast<double>() +
             springs_.coeff(a, a) * Matrix3d::Identity();
  }
  for (const Projection& each : dilatations_) {
    for (Eigen::Index b = 0; b < each.moments.rows(); ++b) {
      const double scale = each.stiffness / each.sums[b];
      for (WeightMatrix::InnerIterator it(each.moments, b); it;) {
        const Eigen::Index a = it.index() / 3;
        Vector3d moment = Vector3d::Zero();
        for (; it && it.index() / 3 == a; ++it) moment[it.index() % 3] = it.value();
        own[a] += scale * moment * moment.transpose();
      }
    }
  }
  for (const Projection& each : held_) {
    for (Eigen::Index b = 0; b < each.moments.rows(); ++b) {
      for (WeightMatrix::InnerIterator it(each.moments, b); it; ++it) {
        own[it.index()].diagonal().array() +=
            each.stiffness * it.value() * it.value() / each.sums[b];
      }
    }
  }
  for (const Matrix3d& block : own) preconditioner_.push_back(block.inverse());
}

void FineLattice::Multiply(const Columns& x, Columns* y) const {
  const std::size_t n = preconditioner_.size();
  y->resize(x.rows(), kTogether);
  for (std::size_t a = 0; a < n; ++a) {
    Eigen::Array<double, 3, kTogether, Eigen::RowMajor> sum = decltype(sum)::Zero();
    const float* block = &blocks_[9 * first_[a]];
    for (std::size_t b = first_[a]; b < first_[a + 1]; ++b, block += 9) {
      const double* u = x.data() + std::ptrdiff_t{3 * kTogether} * neighbours_[b];
      for (int d = 0; d < 3; ++d) {
        for (int c = 0; c < kTogether; ++c) {
          sum(d, c) += block[3 * d] * u[c] + block[3 * d + 1] * u[kTogether + c] +
                       block[3 * d + 2] * u[2 * kTogether + c];
        }
      }
    }
    y->middleRows<3>(static_cast<Eigen::Index>(3 * a)) = sum;
  }
  for (const Projection& each : dilatations_) {
    Columns moments = each.moments * x;
    SolveTogether(*each.inner, &moments);
    *y += each.stiffness * (each.moments.transpose() * moments);
  }
  // One row per control point: its three displacements in every column.
  using ByPoint = Eigen::Matrix<double, Eigen::Dynamic, 3 * kTogether, Eigen::RowMajor>;
  const Eigen::Map<const ByPoint> U(x.data(), lattice_.size(), 3 * kTogether);
  Eigen::Map<ByPoint> force(y->data(), lattice_.size(), 3 * kTogether);
  force += springs_ * U;
  for (const Projection& each : held_) {
    ByPoint moments = each.moments * U;
    SolveTogether(*each.inner, &moments);
    force += each.stiffness * (each.moments.transpose() * moments);
  }
}

// Conjugate gradients for each column separately; a solved column waits for the others.
FineLattice::Columns FineLattice::Solve(const Columns& loads) const {
  using Row = Eigen::Array<double, 1, kTogether>;
  Columns x = Columns::Zero(loads.rows(), kTogether), r = loads, z(loads.rows(), kTogether), p, Kp;
  const auto precondition = [&] {
    for (std::size_t a = 0; a < preconditioner_.size(); ++a) {
      const auto at = static_cast<Eigen::Index>(3 * a);
      z.middleRows<3>(at) = preconditioner_[a] * r.middleRows<3>(at);
    }
  };
  const auto dot = [](const Columns& a, const Columns& b) -> Row {
    return a.cwiseProduct(b).colwise().sum();
  };
  precondition();
  p = z;
  Row size = dot(r, z);
  const Row enough = kFineTolerance * kFineTolerance * size;
  for (int i = 0; (size > enough).any(); ++i) {
    Multiply(p, &Kp);
    const Eigen::Array<bool, 1, kTogether> moves = size > enough;
    const Row step = moves.select(size / dot(p, Kp), 0);
    if (i == kMaxIterations || !step.isFinite().all()) {
      throw InputError("organ \"" + organ_.name +
                       "\": nothing seems to hold it; add an [[organ.support]]");
    }
    x += p * step.matrix().asDiagonal();
    r -= Kp * step.matrix().asDiagonal();
    precondition();
    const Row next = moves.select(dot(r, z), size);
    const Row turn = moves.select(next / size, 0);
    p = z + p * turn.matrix().asDiagonal();
    size = next;
  }
  return x;
}

}  // namespace hpdm
