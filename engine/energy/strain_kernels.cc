#include "engine/energy/strain_kernels.h"

#include <cmath>

#include "engine/energy/hyperelastic.h"

namespace hpdm {
namespace strain_kernels {
namespace {

// The loops are written once. Each function below, compiled for other instructions, contains them.
#define HPDM_INLINE [[gnu::always_inline]] inline

using Vector = double __attribute__((vector_size(8 * kLanes), aligned(8 * kLanes), may_alias));

HPDM_INLINE const Vector* Vectors(const Lanes* lanes) {
  return reinterpret_cast<const Vector*>(lanes);
}
HPDM_INLINE Vector* Vectors(Lanes* lanes) { return reinterpret_cast<Vector*>(lanes); }

// Adds up the lanes, always in the same order.
HPDM_INLINE double Sum(const Vector& x) {
  return ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7]));
}

HPDM_INLINE void AddGradients(const Vector* gradients, int blocks, int functions, const double* U,
                              Vector* F) {
  for (int block = 0; block < blocks; ++block, F += 9) {
    Vector sum[9];
    for (int c = 0; c < 9; ++c) sum[c] = F[c];
    for (int a = 0; a < functions; ++a, gradients += 3) {
      for (int j = 0; j < 3; ++j) {
        for (int i = 0; i < 3; ++i) sum[3 * j + i] += gradients[j] * U[3 * a + i];
      }
    }
    for (int c = 0; c < 9; ++c) F[c] = sum[c];
  }
}

HPDM_INLINE void AddForces(const Vector* gradients, int blocks, int functions, const Vector* stress,
                           double* forces) {
  for (int a = 0; a < functions; ++a) {
    Vector sum[3] = {};
    for (int block = 0; block < blocks; ++block) {
      const Vector* const g = gradients + 3 * (block * functions + a);
      const Vector* const P = stress + 9 * block;
      for (int i = 0; i < 3; ++i) sum[i] += g[0] * P[i] + g[1] * P[3 + i] + g[2] * P[6 + i];
    }
    for (int i = 0; i < 3; ++i) forces[3 * a + i] += Sum(sum[i]);
  }
}

HPDM_INLINE void AddTangents(const Vector* gradients, const Vector* tangent, int blocks,
                             int functions, int last, double* stiffness) {
  for (int b = 0; b <= last; ++b) {
    Vector sum[9] = {};
    for (int block = 0; block < blocks; ++block) {
      const Vector* const g = gradients + 3 * (block * functions + b);
      const Vector* const T = tangent + 27 * block;
      for (int c = 0; c < 9; ++c) sum[c] += T[c] * g[0] + T[9 + c] * g[1] + T[18 + c] * g[2];
    }
    for (int c = 0; c < 9; ++c) stiffness[9 * b + c] += Sum(sum[c]);
  }
}

HPDM_INLINE void Cross(const Vector* a, const Vector* b, Vector* c) {
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    c[i] = a[j] * b[k] - a[k] * b[j];
  }
}

HPDM_INLINE void Dot(const Vector* a, const Vector* b, Vector* c) {
  *c = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Computes |F|^2.
HPDM_INLINE void SquaredNorm(const Vector* F, Vector* norm) {
  Vector columns[3];
  for (int j = 0; j < 3; ++j) Dot(F + 3 * j, F + 3 * j, columns + j);
  *norm = columns[0] + columns[1] + columns[2];
}

HPDM_INLINE void Dilate(const StrainLaw& law, const Vector* F, int blocks, Vector* theta,
                        Vector* slope) {
  for (int block = 0; block < blocks; ++block, F += 9, slope += 9) {
    if (law.law == MaterialLaw::kNeoHookean) {
      for (int j = 0; j < 3; ++j) {
        Cross(F + 3 * ((j + 1) % 3), F + 3 * ((j + 2) % 3), slope + 3 * j);
      }
      Dot(F, slope, theta + block);
      theta[block] -= 1;
    } else {
      for (int c = 0; c < 9; ++c) slope[c] = F[c];
      SquaredNorm(F, theta + block);
      theta[block] = (theta[block] - 3) / 2;
    }
  }
}

HPDM_INLINE double Stress(const StrainLaw& law, const Vector* F, const Vector* weights,
                          const Vector* pressure, const Vector* theta, const Vector* slope,
                          int blocks, Vector* stress) {
  constexpr double kM = NeoHookean::kM, kL0 = NeoHookean::kL0, kAlpha0 = NeoHookean::kAlpha0;
  Vector energy = {};
  for (int block = 0; block < blocks; ++block, F += 9, slope += 9, stress += 9) {
    const Vector w = weights[block], t = theta[block];
    if (law.law == MaterialLaw::kNeoHookean) {
      // As HyperelasticLaw, avoids cancellation at rest.
      Vector change;
      SquaredNorm(F, &change);
      change -= 3;
      Vector logarithm;
      for (int l = 0; l < kLanes; ++l) logarithm[l] = std::log1p(change[l] / 4);
      energy +=
          w * (law.mu * (kM / 2 * (change - logarithm) + kL0 / 2 * t * (t + 2 * (1 - kAlpha0))) +
               law.lambda / 2 * t * t);
      const Vector shape = w * (law.mu * kM) * (1 - 1 / (change + 4));
      const Vector volume =
          w * (law.lambda * t + law.mu * kL0 * (t + (1 - kAlpha0))) + pressure[block];
      for (int c = 0; c < 9; ++c) stress[c] = shape * F[c] + volume * slope[c];
    } else {
      Vector S[6];  // second Piola-Kirchhoff stress: xx, xy, xz, yy, yz, zz
      Vector norm = {};
      for (int j = 0, c = 0; j < 3; ++j) {
        for (int l = j; l < 3; ++l, ++c) {
          Vector E;
          Dot(F + 3 * j, F + 3 * l, &E);
          E = (E - (j == l ? 1.0 : 0.0)) / 2;
          norm += (j == l ? 1.0 : 2.0) * E * E;
          S[c] = w * (2 * law.mu) * E;
          if (j == l) S[c] += w * law.lambda * t + pressure[block];
        }
      }
      energy += w * (law.mu * norm + law.lambda / 2 * t * t);
      constexpr int kEntry[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
      for (int j = 0; j < 3; ++j) {
        for (int i = 0; i < 3; ++i) {
          stress[3 * j + i] =
              F[i] * S[kEntry[0][j]] + F[3 + i] * S[kEntry[1][j]] + F[6 + i] * S[kEntry[2][j]];
        }
      }
    }
  }
  return Sum(energy);
}

#define HPDM_KERNELS(name, attribute)                                                              \
  attribute void AddGradients##name(const Lanes* gradients, int blocks, int functions,             \
                                    const double* U, Lanes* F) {                                   \
    AddGradients(Vectors(gradients), blocks, functions, U, Vectors(F));                            \
  }                                                                                                \
  attribute void AddForces##name(const Lanes* gradients, int blocks, int functions,                \
                                 const Lanes* stress, double* forces) {                            \
    AddForces(Vectors(gradients), blocks, functions, Vectors(stress), forces);                     \
  }                                                                                                \
  attribute void AddTangents##name(const Lanes* gradients, const Lanes* tangent, int blocks,       \
                                   int functions, int last, double* stiffness) {                   \
    AddTangents(Vectors(gradients), Vectors(tangent), blocks, functions, last, stiffness);         \
  }                                                                                                \
  attribute void Dilate##name(const StrainLaw& law, const Lanes* F, int blocks, Lanes* theta,      \
                              Lanes* slope) {                                                      \
    Dilate(law, Vectors(F), blocks, Vectors(theta), Vectors(slope));                               \
  }                                                                                                \
  attribute double Stress##name(const StrainLaw& law, const Lanes* F, const Lanes* weights,        \
                                const Lanes* pressure, const Lanes* theta, const Lanes* slope,     \
                                int blocks, Lanes* stress) {                                       \
    return Stress(law, Vectors(F), Vectors(weights), Vectors(pressure), Vectors(theta),            \
                  Vectors(slope), blocks, Vectors(stress));                                        \
  }                                                                                                \
  constexpr StrainKernels k##name{AddGradients##name, AddForces##name, Dilate##name, Stress##name, \
                                  AddTangents##name};

HPDM_KERNELS(Narrow, )
#if defined(__x86_64__)
HPDM_KERNELS(Wide, __attribute__((target("avx2"))))
HPDM_KERNELS(Widest, __attribute__((target("avx512f"))))
#endif

}  // namespace
}  // namespace strain_kernels

const StrainKernels& StrainKernelsFor(VectorWidth width) {
#if defined(__x86_64__)
  if (width == VectorWidth::k64Bytes) return strain_kernels::kWidest;
  if (width == VectorWidth::k32Bytes) return strain_kernels::kWide;
#endif
  static_cast<void>(width);
  return strain_kernels::kNarrow;
}

}  // namespace hpdm
