#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "engine/base/vector_width.h"

namespace hpdm {

/// A symmetric matrix in single precision, of which only the lower triangle is kept: a product reads
/// a quarter of the memory, which is what it waits for. For K^-1 as the first approximation of an
/// inverse Hessian, whose errors the iterations correct.
///
/// Sums are in double precision, in one order at every width of the processor's vectors, so results
/// have the same bits everywhere. Constant once built; read by any thread; a product allocates
/// nothing.
class PackedInverse {
 public:
  /// y += B x for tiles as below, with sizes padded to 8.
  using Kernel = void (*)(const float* tiles, Eigen::Index panels, const double* x, double* y);

  /// `A`: N x N, symmetric. Each entry is rounded to 24 bits. A = D B D with 1 on B's diagonal, and
  /// the entries of B are kept, so functions with little tissue do not cost the others' precision.
  explicit PackedInverse(const Eigen::MatrixXd& A, VectorWidth width = WidestVectors());

  Eigen::Index size() const { return size_; }

  /// Scratch space of a product. One for each thread.
  class Workspace {
   public:
    explicit Workspace(Eigen::Index size);

   private:
    friend class PackedInverse;
    std::vector<double> x_, y_;
  };

  /// Computes y = A x; both have size() entries, and may be the same.
  void Multiply(const Eigen::Ref<const Eigen::VectorXd>& x, Workspace* workspace,
                Eigen::Ref<Eigen::VectorXd> y) const;

 private:
  Eigen::Index size_;
  Eigen::VectorXd scale_;  // N: D
  std::vector<float>
      tiles_;  // 8 x 8, column by column; of each panel of 8 columns from its diagonal
  Kernel multiply_;
};

}  // namespace hpdm
