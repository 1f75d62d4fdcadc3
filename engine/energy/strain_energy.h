#pragma once

#include "engine/base/quadrature.h"
#include "engine/lattice/lattice.h"
#include "engine/organ_options.h"

namespace hpdm {

/// 3n x 3n, N/m, symmetric. Unknown 3 a + d is the displacement of control point a along world axis
/// d. So the memory of an n x 3 row-major array of displacements is the vector of unknowns.
using FullStiffness = Eigen::MatrixXd;

/// Lame's parameters of an isotropic elastic material, Pa.
struct LameParameters {
  double mu = 0;      ///< Shear modulus E / (2 (1 + nu)).
  double lambda = 0;  ///< E nu / ((1 + nu) (1 - 2 nu)).
};
LameParameters ToLame(const MaterialOptions& material);

/// Evaluation of the volumetric energy: at each quadrature point, or mostly after a projection on
/// splines one degree lower (mixed_dilatation.h). With the projection nearly incompressible tissue
/// does not lock.
enum class Dilatation { kPointwise, kProjected };

/// The two parts of lambda. Dilatation that the projection does not see would cost no energy and
/// let local functions (refinement_basis.h) overshoot. So up to 2 mu of lambda stays pointwise.
/// That is all of it for nu <= 1/3, two ninths for nu = 0.45, and a vanishing part as nu approaches
/// 1/2.
struct DilatationShare {
  double pointwise = 0;  ///< Pa.
  double projected = 0;  ///< Pa.
};
DilatationShare ShareLambda(const LameParameters& lame, Dilatation dilatation);

/// Adds the elastic blocks between two sets of functions, integrated with the tissue's `weights`
/// (Q, m^3). Their gradients are `left` (element d: Q x m, 1/m) and `right` (Q x n). Calls add(row,
/// column, value) with row 3 a + i and column 3 b + j. The values of the pair (a, b) sum to the
/// block (3 x 3, N/m)
///     int mu (p.q I + q p^T) + lambda p q^T dV,   p = left_a, q = right_b.
template <typename Add>
void AddElasticBlocks(const std::array<WeightMatrix, 3>& left,
                      const std::array<WeightMatrix, 3>& right, const Eigen::VectorXd& weights,
                      const LameParameters& lame, Add&& add) {
  // With G_ij = int d_i phi_a d_j phi_b dV, entry (a,i),(b,j) is
  // mu (delta_ij sum_k G_kk + G_ji) + lambda G_ij.
  for (int i = 0; i < 3; ++i) {
    const WeightMatrix weighted = weights.asDiagonal() * left[i];
    for (int j = 0; j < 3; ++j) {
      const WeightMatrix G = weighted.transpose() * right[j];
      for (Eigen::Index a = 0; a < G.rows(); ++a) {
        for (WeightMatrix::InnerIterator it(G, a); it; ++it) {
          const Eigen::Index b = it.index();
          add(3 * a + j, 3 * b + i, lame.mu * it.value());
          if (lame.lambda != 0) add(3 * a + i, 3 * b + j, lame.lambda * it.value());
          if (i != j) continue;
          for (int d = 0; d < 3; ++d) add(3 * a + d, 3 * b + d, lame.mu * it.value());
        }
      }
    }
  }
}

/// Returns the stiffness K of the lattice's isotropic elastic energy for small strain
/// (engine/README.md, section 5):
///     E(U) = int mu |eps|^2 + lambda/2 (tr eps)^2 dV = 1/2 U^T K U
///     eps = sym(grad u),   u = sum_a phi_a U_a
/// over the organ's own `tissue` (world, m, m^3). K is symmetric and positive semi-definite;
/// translations and infinitesimal rotations cost no energy. AddElasticBlocks gives its blocks.
FullStiffness StrainStiffness(const Lattice& lattice, const Quadrature& tissue,
                              const MaterialOptions& material, Dilatation dilatation);

/// Adds the same scalar stiffness (n x n) along each world axis to K (3n x 3n).
void AddAlongEachAxis(const Eigen::SparseMatrix<double, Eigen::RowMajor>& scalar, FullStiffness* K);

}  // namespace hpdm
