#pragma once

#include <Eigen/Core>

namespace hpdm {

/// Adds factor A B^T to the lower triangle of C, diagonal included. `A`, `B`: n x k; `C`: n x n.
/// Entries above the diagonal stay as they are.
///
/// Uses the widest vectors of the processor (AVX-512, AVX2), else Eigen's product. With such vectors an
/// entry is summed over k in steps of 256, in order and without fused operations, whatever their
/// width. Set-up only; allocates.
void AddProductToLower(double factor, const Eigen::Ref<const Eigen::MatrixXd>& A,
                       const Eigen::Ref<const Eigen::MatrixXd>& B, Eigen::Ref<Eigen::MatrixXd> C);

}  // namespace hpdm
