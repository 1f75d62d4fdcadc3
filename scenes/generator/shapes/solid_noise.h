#pragma once

#include <cstdint>

#include "engine/base/types.h"

/// Random functions of a point in space, for colours without seams between a surface's charts. They
/// use only + - * / sqrt, floor and integers: the same bits on every x86-64 machine.
namespace hpdm {

/// Pseudo-random numbers (SplitMix64: Steele, Lea and Flood 2014).
class RandomNumbers {
 public:
  explicit RandomNumbers(std::uint64_t seed) : state_(seed) {}
  std::uint64_t Next();
  /// In [0, 1), in steps of 2^-53.
  double Fraction() { return static_cast<double>(Next() >> 11) * 0x1p-53; }

 private:
  std::uint64_t state_;
};

/// Returns 0 below `low`, 1 above `high` (reversed for low > high), 3 t^2 - 2 t^3 between.
double SmoothStep(double low, double high, double value);

/// Gradient noise on the unit lattice (Perlin 2002, "Improving noise"): about -1 to 1, mean 0,
/// features of size one, zero on the lattice's points. `seed` selects another function.
double GradientNoise(const Vector3d& p, std::uint32_t seed);

/// Sum of `octaves` noises, each twice as fine and half as strong: about -1 to 1.
double FractalNoise(const Vector3d& p, int octaves, std::uint32_t seed);

/// Cells around points scattered one in each unit cube (Worley 1996).
struct CellSample {
  double nearest = 0;  ///< Distance to the nearest point, 0 to about 1.
  double second = 0;   ///< Distance to the second one: equal on the walls between cells.
  double shade = 0;    ///< The cell's random number in [0, 1).
};
CellSample CellNoise(const Vector3d& p, std::uint32_t seed);

}  // namespace hpdm
