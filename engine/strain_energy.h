#pragma once

#include "engine/lattice.h"
#include "engine/organ_options.h"
#include "engine/quadrature.h"

namespace hpdm {

/// 3n x 3n, N/m, symmetric: unknown 3 a + d is the displacement of control point a along world axis
/// d, so an n x 3 row-major array of displacements is the vector of unknowns as it lies in memory.
using FullStiffness = Eigen::MatrixXd;

/// Lame's parameters of an isotropic elastic material, Pa.
struct LameParameters {
  double mu = 0;      ///< Shear modulus E / (2 (1 + nu)).
  double lambda = 0;  ///< E nu / ((1 + nu) (1 - 2 nu)).
};
LameParameters ToLame(const MaterialOptions& material);

/// Where the volumetric part of the energy is evaluated: at each quadrature point, or after a
/// projection on splines one degree lower (mixed_dilatation.h), which does not lock nearly
/// incompressible tissue.
enum class Dilatation { kPointwise, kProjected };

/// The lattice's elastic energy for small strain (design "strain"): with u = sum_a phi_a U_a and
/// eps = sym(grad u),
///     E(U) = int mu |eps|^2 + lambda/2 (tr eps)^2 dV = 1/2 U^T K U
/// over the organ's own `tissue` (world, m, m^3), isotropic and linear. Returns K: symmetric,
/// positive semi-definite; translations and infinitesimal rotations cost nothing. The block of
/// control points a and b, whose gradients are p and q, is the integral of
///     mu (p.q I + q p^T) + lambda p q^T.
FullStiffness StrainStiffness(const Lattice& lattice, const Quadrature& tissue,
                              const MaterialOptions& material, Dilatation dilatation);

/// S (x) I: the same scalar stiffness (n x n) along each world axis, added to K (3n x 3n).
void AddAlongEachAxis(const Eigen::SparseMatrix<double, Eigen::RowMajor>& scalar, FullStiffness* K);

}  // namespace hpdm
