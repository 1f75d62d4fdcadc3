#include "scenes/generator/shapes/solid_noise.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hpdm {
namespace {

/// Hashes a lattice point (the finaliser of MurmurHash3).
std::uint32_t Hash(const Eigen::Vector3i& cell, std::uint32_t seed) {
  std::uint32_t h = seed * 0x9E3779B9u + static_cast<std::uint32_t>(cell.x()) * 0x85EBCA6Bu +
                    static_cast<std::uint32_t>(cell.y()) * 0xC2B2AE35u +
                    static_cast<std::uint32_t>(cell.z()) * 0x27D4EB2Fu;
  h = (h ^ (h >> 16)) * 0x85EBCA6Bu;
  h = (h ^ (h >> 13)) * 0xC2B2AE35u;
  return h ^ (h >> 16);
}

/// Slope along one of the twelve directions to a cube's edges.
double Slope(std::uint32_t hash, const Vector3d& d) {
  const std::uint32_t h = hash & 15;
  const double u = h < 8 ? d.x() : d.y();
  const double v = h < 4 ? d.y() : (h == 12 || h == 14 ? d.x() : d.z());
  return ((h & 1) == 0 ? u : -u) + ((h & 2) == 0 ? v : -v);
}

double Blend(double a, double b, double t) { return a + (b - a) * t; }

Eigen::Vector3i CellOf(const Vector3d& p) { return p.array().floor().matrix().cast<int>(); }

}  // namespace

std::uint64_t RandomNumbers::Next() {
  state_ += 0x9E3779B97F4A7C15u;
  std::uint64_t z = state_;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

double SmoothStep(double low, double high, double value) {
  const double t = std::clamp((value - low) / (high - low), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

double GradientNoise(const Vector3d& p, std::uint32_t seed) {
  const Eigen::Vector3i cell = CellOf(p);
  const Vector3d f = p - cell.cast<double>();
  const Vector3d s = f.unaryExpr([](double t) { return t * t * t * (t * (t * 6 - 15) + 10); });
  double corner[8];
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3i offset(i & 1, (i >> 1) & 1, i >> 2);
    corner[i] = Slope(Hash(cell + offset, seed), f - offset.cast<double>());
  }
  const double low =
      Blend(Blend(corner[0], corner[1], s.x()), Blend(corner[2], corner[3], s.x()), s.y());
  const double high =
      Blend(Blend(corner[4], corner[5], s.x()), Blend(corner[6], corner[7], s.x()), s.y());
  return Blend(low, high, s.z());
}

double FractalNoise(const Vector3d& p, int octaves, std::uint32_t seed) {
  // The lattices share no points, because each noise is zero on its own lattice.
  const Vector3d shift(0.37, 0.71, 0.13);
  double sum = 0, strength = 1, size = 1;
  for (int octave = 0; octave < octaves; ++octave) {
    sum += strength *
           GradientNoise(p / size + octave * shift, seed + static_cast<std::uint32_t>(octave));
    strength *= 0.5;
    size *= 0.5;
  }
  return sum;
}

CellSample CellNoise(const Vector3d& p, std::uint32_t seed) {
  const Eigen::Vector3i cell = CellOf(p);
  double nearest = std::numeric_limits<double>::max(), second = nearest;
  std::uint32_t owner = 0;
  for (int i = 0; i < 27; ++i) {
    const Eigen::Vector3i at = cell + Eigen::Vector3i(i % 3 - 1, (i / 3) % 3 - 1, i / 9 - 1);
    const std::uint32_t hash = Hash(at, seed);
    const Vector3d jitter(hash & 1023u, (hash >> 10) & 1023u, (hash >> 20) & 1023u);
    const double distance = (at.cast<double>() + jitter / 1024 - p).squaredNorm();
    if (distance < nearest) {
      second = nearest;
      nearest = distance;
      owner = hash;
    } else {
      second = std::min(second, distance);
    }
  }
  return {std::sqrt(nearest), std::sqrt(second), static_cast<double>(owner >> 8) * 0x1p-24};
}

}  // namespace hpdm
