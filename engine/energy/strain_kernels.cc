#include "engine/energy/strain_kernels.h"

#include <cmath>

#include "engine/energy/hyperelastic.h"

namespace hpdm {
namespace strain_kernels {
namespace {

// The loops are written once. Each function below, compiled for other instructions, contains them for
// vectors V that its processor has. Lanes are kParts of them; a loop takes one part after the other, so
// its sums stay in registers.
#define HPDM_INLINE [[gnu::always_inline]] inline

using Doubles2 = double __attribute__((vector_size(16), aligned(16), may_alias));
using Doubles4 = double __attribute__((vector_size(32), aligned(32), may_alias));
using Doubles8 = double __attribute__((vector_size(64), aligned(64), may_alias));

template <typename V>
constexpr int kParts = static_cast<int>(sizeof(Lanes) / sizeof(V));

template <typename V>
HPDM_INLINE const V* Part(const Lanes* lanes, int part) {
  return reinterpret_cast<const V*>(lanes) + part;
}
template <typename V>
HPDM_INLINE V* Part(Lanes* lanes, int part) {
  return reinterpret_cast<V*>(lanes) + part;
}

// Copies `n` entries of a part, which stand kParts apart, and back.
template <int n, typename V>
HPDM_INLINE void Load(const V* from, V* to) {
  for (int c = 0; c < n; ++c) to[c] = from[c * kParts<V>];
}
template <int n, typename V>
HPDM_INLINE void Store(const V* from, V* to) {
  for (int c = 0; c < n; ++c) to[c * kParts<V>] = from[c];
}

template <typename V>
HPDM_INLINE void AddGradients(const Lanes* gradients, int blocks, int functions, const double* U,
                              Lanes* F) {
  for (int block = 0; block < blocks; ++block, F += 9, gradients += 3 * functions) {
    for (int part = 0; part < kParts<V>; ++part) {
      const V* g = Part<V>(gradients, part);
      V sum[9];
      Load<9>(Part<V>(F, part), sum);
      for (int a = 0; a < functions; ++a, g += 3 * kParts<V>) {
        for (int j = 0; j < 3; ++j) {
          for (int i = 0; i < 3; ++i) sum[3 * j + i] += g[j * kParts<V>] * U[3 * a + i];
        }
      }
      Store<9>(sum, Part<V>(F, part));
    }
  }
}

template <typename V>
HPDM_INLINE void AddForces(const Lanes* gradients, int blocks, int functions, const Lanes* stress,
                           double* forces) {
  for (int a = 0; a < functions; ++a) {
    Lanes sums[3];
    for (int part = 0; part < kParts<V>; ++part) {
      V sum[3] = {};
      for (int block = 0; block < blocks; ++block) {
        V g[3], P[9];
        Load<3>(Part<V>(gradients + 3 * (block * functions + a), part), g);
        Load<9>(Part<V>(stress + 9 * block, part), P);
        for (int i = 0; i < 3; ++i) sum[i] += g[0] * P[i] + g[1] * P[3 + i] + g[2] * P[6 + i];
      }
      Store<3>(sum, Part<V>(sums, part));
    }
    for (int i = 0; i < 3; ++i) forces[3 * a + i] += SumOfLanes(sums[i]);
  }
}

template <typename V>
HPDM_INLINE void AddTangents(const Lanes* gradients, const Lanes* tangent, int blocks,
                             int functions, int last, double* stiffness) {
  for (int b = 0; b <= last; ++b) {
    Lanes sums[9];
    for (int part = 0; part < kParts<V>; ++part) {
      V sum[9] = {};
      for (int block = 0; block < blocks; ++block) {
        V g[3];
        Load<3>(Part<V>(gradients + 3 * (block * functions + b), part), g);
        const V* const T = Part<V>(tangent + 27 * block, part);
        for (int c = 0; c < 9; ++c) {
          sum[c] += T[c * kParts<V>] * g[0] + T[(9 + c) * kParts<V>] * g[1] +
                    T[(18 + c) * kParts<V>] * g[2];
        }
      }
      Store<9>(sum, Part<V>(sums, part));
    }
    for (int c = 0; c < 9; ++c) stiffness[9 * b + c] += SumOfLanes(sums[c]);
  }
}

template <typename V>
HPDM_INLINE void Cross(const V* a, const V* b, V* c) {
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    c[i] = a[j] * b[k] - a[k] * b[j];
  }
}

template <typename V>
HPDM_INLINE void Dot(const V* a, const V* b, V* c) {
  *c = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Computes |F|^2.
template <typename V>
HPDM_INLINE void SquaredNorm(const V* F, V* norm) {
  V columns[3];
  for (int j = 0; j < 3; ++j) Dot(F + 3 * j, F + 3 * j, columns + j);
  *norm = columns[0] + columns[1] + columns[2];
}

template <typename V>
HPDM_INLINE void DilatePart(const StrainLaw& law, const V* F, V* theta, V* slope) {
  if (law.law == MaterialLaw::kNeoHookean) {
    for (int j = 0; j < 3; ++j) Cross(F + 3 * ((j + 1) % 3), F + 3 * ((j + 2) % 3), slope + 3 * j);
    Dot(F, slope, theta);
    *theta -= 1;
  } else {
    for (int c = 0; c < 9; ++c) slope[c] = F[c];
    SquaredNorm(F, theta);
    *theta = (*theta - 3) / 2;
  }
}

template <typename V>
HPDM_INLINE void Dilate(const StrainLaw& law, const Lanes* F, int blocks, Lanes* theta,
                        Lanes* slope) {
  for (int block = 0; block < blocks; ++block, F += 9, slope += 9) {
    for (int part = 0; part < kParts<V>; ++part) {
      V deformed[9], of_slope[9];
      Load<9>(Part<V>(F, part), deformed);
      DilatePart(law, deformed, Part<V>(theta + block, part), of_slope);
      Store<9>(of_slope, Part<V>(slope, part));
    }
  }
}

// Fills `stress` and adds the energy of one part of a block.
template <typename V>
HPDM_INLINE void StressPart(const StrainLaw& law, const V* F, const V& w, const V& pressure,
                            const V& t, const V* slope, V* stress, V* energy) {
  constexpr double kM = NeoHookean::kM, kL0 = NeoHookean::kL0, kAlpha0 = NeoHookean::kAlpha0;
  if (law.law == MaterialLaw::kNeoHookean) {
    // As HyperelasticLaw, avoids cancellation at rest.
    V change;
    SquaredNorm(F, &change);
    change -= 3;
    V logarithm;
    for (int l = 0; l < kLanes / kParts<V>; ++l) logarithm[l] = std::log1p(change[l] / 4);
    *energy +=
        w * (law.mu * (kM / 2 * (change - logarithm) + kL0 / 2 * t * (t + 2 * (1 - kAlpha0))) +
             law.lambda / 2 * t * t);
    const V shape = w * (law.mu * kM) * (1 - 1 / (change + 4));
    const V volume = w * (law.lambda * t + law.mu * kL0 * (t + (1 - kAlpha0))) + pressure;
    for (int c = 0; c < 9; ++c) stress[c] = shape * F[c] + volume * slope[c];
    return;
  }
  V S[6];  // second Piola-Kirchhoff stress: xx, xy, xz, yy, yz, zz
  V norm = {};
  for (int j = 0, c = 0; j < 3; ++j) {
    for (int l = j; l < 3; ++l, ++c) {
      V E;
      Dot(F + 3 * j, F + 3 * l, &E);
      E = (E - (j == l ? 1.0 : 0.0)) / 2;
      norm += (j == l ? 1.0 : 2.0) * E * E;
      S[c] = w * (2 * law.mu) * E;
      if (j == l) S[c] += w * law.lambda * t + pressure;
    }
  }
  *energy += w * (law.mu * norm + law.lambda / 2 * t * t);
  constexpr int kEntry[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      stress[3 * j + i] =
          F[i] * S[kEntry[0][j]] + F[3 + i] * S[kEntry[1][j]] + F[6 + i] * S[kEntry[2][j]];
    }
  }
}

template <typename V>
HPDM_INLINE double Stress(const StrainLaw& law, const Lanes* F, const Lanes* weights,
                          const Lanes* pressure, const Lanes* theta, const Lanes* slope, int blocks,
                          Lanes* stress) {
  Lanes energy;
  for (int part = 0; part < kParts<V>; ++part) {
    V sum = {};
    for (int block = 0; block < blocks; ++block) {
      V deformed[9], of_slope[9], P[9];
      Load<9>(Part<V>(F + 9 * block, part), deformed);
      Load<9>(Part<V>(slope + 9 * block, part), of_slope);
      StressPart(law, deformed, *Part<V>(weights + block, part), *Part<V>(pressure + block, part),
                 *Part<V>(theta + block, part), of_slope, P, &sum);
      Store<9>(P, Part<V>(stress + 9 * block, part));
    }
    *Part<V>(&energy, part) = sum;
  }
  return SumOfLanes(energy);
}

#define HPDM_KERNELS(name, Doubles, attribute)                                                     \
  attribute void AddGradients##name(const Lanes* gradients, int blocks, int functions,             \
                                    const double* U, Lanes* F) {                                   \
    AddGradients<Doubles>(gradients, blocks, functions, U, F);                                     \
  }                                                                                                \
  attribute void AddForces##name(const Lanes* gradients, int blocks, int functions,                \
                                 const Lanes* stress, double* forces) {                            \
    AddForces<Doubles>(gradients, blocks, functions, stress, forces);                              \
  }                                                                                                \
  attribute void AddTangents##name(const Lanes* gradients, const Lanes* tangent, int blocks,       \
                                   int functions, int last, double* stiffness) {                   \
    AddTangents<Doubles>(gradients, tangent, blocks, functions, last, stiffness);                  \
  }                                                                                                \
  attribute void Dilate##name(const StrainLaw& law, const Lanes* F, int blocks, Lanes* theta,      \
                              Lanes* slope) {                                                      \
    Dilate<Doubles>(law, F, blocks, theta, slope);                                                 \
  }                                                                                                \
  attribute double Stress##name(const StrainLaw& law, const Lanes* F, const Lanes* weights,        \
                                const Lanes* pressure, const Lanes* theta, const Lanes* slope,     \
                                int blocks, Lanes* stress) {                                       \
    return Stress<Doubles>(law, F, weights, pressure, theta, slope, blocks, stress);               \
  }                                                                                                \
  constexpr StrainKernels k##name{AddGradients##name, AddForces##name, Dilate##name, Stress##name, \
                                  AddTangents##name};

HPDM_KERNELS(Narrow, Doubles2, )
#if defined(__x86_64__)
HPDM_KERNELS(Wide, Doubles4, __attribute__((target("avx2"))))
HPDM_KERNELS(Widest, Doubles8, __attribute__((target("avx512f"))))
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
