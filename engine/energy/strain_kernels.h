#pragma once

#include "engine/base/vector_width.h"
#include "engine/organ_options.h"

namespace hpdm {

/// A number at each of eight quadrature points. The kernels below turn an operation on it into one,
/// two or four instructions, as the processor's vectors are 64, 32 or 16 bytes wide. Every lane is
/// rounded as a double of its own, so the results have the same bits on every processor.
inline constexpr int kLanes = 8;
struct alignas(8 * kLanes) Lanes {
  double lane[kLanes];
  double& operator[](int i) { return lane[i]; }
  double operator[](int i) const { return lane[i]; }
};

/// A law at a point (hyperelastic.h), without the projected part of lambda.
struct StrainLaw {
  MaterialLaw law = MaterialLaw::kNeoHookean;
  double mu = 0;      ///< Pa.
  double lambda = 0;  ///< Pa.
};

/// The inner loops of finite strain over the points of one cell, `blocks` x 8 of them. `gradients`
/// has a block's `functions` x 3 entries after each other: d phi_a / d x_j at 3 a + j, 1/m. F and
/// stress have 9 entries a block, column by column: F_ij at 3 j + i. No allocation.
struct StrainKernels {
  /// F += sum_a U_a (grad phi_a)^T. `U`: functions x 3, m.
  void (*add_gradients)(const Lanes* gradients, int blocks, int functions, const double* U,
                        Lanes* F);
  /// forces_a += sum over the points of P grad phi_a. `forces`: functions x 3, N.
  void (*add_forces)(const Lanes* gradients, int blocks, int functions, const Lanes* stress,
                     double* forces);
  /// Computes theta (one entry a block) and d theta / dF.
  void (*dilate)(const StrainLaw& law, const Lanes* F, int blocks, Lanes* theta, Lanes* slope);
  /// stress = w P(F) + pressure d theta / dF, N m. Returns sum w W(F), J. `weights` (m^3),
  /// `pressure` (N m), `theta`, `slope`: as dilate() gives them.
  double (*stress)(const StrainLaw& law, const Lanes* F, const Lanes* weights,
                   const Lanes* pressure, const Lanes* theta, const Lanes* slope, int blocks,
                   Lanes* stress);
  /// Adds sum over the points of w grad_a^T A grad_b for b <= a, as blocks (i, k) of 9 at 9 b.
  /// `tangent`: of function a, blocks x 27: sum_j (d phi_a / dx_j) A_(3j+i)(3l+k) at 9 l + 3 i + k.
  void (*add_tangents)(const Lanes* gradients, const Lanes* tangent, int blocks, int functions,
                       int last, double* stiffness);
};

/// Returns the kernels for vectors of that width. HasVectors(width) must be true.
const StrainKernels& StrainKernelsFor(VectorWidth width);
/// Adds up the lanes, always in the same order.
inline double SumOfLanes(const Lanes& x) {
  return ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7]));
}

}  // namespace hpdm
