#include "render/tissue/tissue_detail.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "engine/base/check.h"

namespace hpdm {
namespace {

constexpr int kSide = 512;  // texels of 0.125 mm

/// An octave of noise: `cells` waves a side, each about `height` (m) high.
struct Octave {
  int cells;
  double height;
  std::uint32_t seed;
};
// Shallow undulation of 10 mm and the lobules' grain of 2.5 mm.
constexpr Octave kOctaves[] = {{6, 1.0e-3, 0x51ed270bu}, {26, 0.38e-3, 0x2545f491u}};

/// Hashes a point of the noise's grid to a number in 0..1.
double AtLattice(int x, int y, std::uint32_t seed) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 0x8da6b343u ^
                    static_cast<std::uint32_t>(y) * 0xd8163841u ^ seed;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  h = (h ^ (h >> 12)) * 0x297a2d39u;
  return (h ^ (h >> 15)) / 4294967295.0;
}

/// Value noise with a quintic blend, periodic in `cells`; x and y in cells.
double Noise(double x, double y, const Octave& octave) {
  const auto blend = [](double f) { return f * f * f * (f * (f * 6 - 15) + 10); };
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const int x1 = (x0 + 1) % octave.cells, y1 = (y0 + 1) % octave.cells;
  const double sx = blend(x - x0), sy = blend(y - y0);
  const auto row = [&](int at_y) {
    return std::lerp(AtLattice(x0, at_y, octave.seed), AtLattice(x1, at_y, octave.seed), sx);
  };
  return std::lerp(row(y0), row(y1), sy);
}

std::uint8_t Quantised(double unit) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(unit, 0.0, 1.0)));
}

}  // namespace

Texels TissueDetail() {
  std::vector<double> height(std::size_t{kSide} * kSide);
  double most = 0;
  for (const Octave& octave : kOctaves) most += octave.height;
  const auto at = [&](int x, int y) -> double& {
    return height[static_cast<std::size_t>((y + kSide) % kSide * kSide + (x + kSide) % kSide)];
  };
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      for (const Octave& octave : kOctaves) {
        const double cells_a_texel = static_cast<double>(octave.cells) / kSide;
        at(x, y) += octave.height * Noise(x * cells_a_texel, y * cells_a_texel, octave);
      }
    }
  }
  Texels texels{kSide, kSide, {}};
  texels.rgba.reserve(4 * height.size());
  const double across = 2 * kDetailTile / kSide;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const double u = (at(x + 1, y) - at(x - 1, y)) / across / kDetailSlope;
      const double v = (at(x, y + 1) - at(x, y - 1)) / across / kDetailSlope;
      for (const double value : {0.5 + 0.5 * u, 0.5 + 0.5 * v, u * u + v * v, at(x, y) / most}) {
        texels.rgba.push_back(Quantised(value));
      }
    }
  }
  return texels;
}

SurfaceMesh WithCoordinates(const SurfaceMesh& mesh) {
  if (mesh.texture_coordinates.rows() > 0) return mesh;
  SurfaceMesh result = mesh;
  result.texture_coordinates.resize(3 * mesh.triangles.rows(), 2);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const Vector3d a = mesh.vertices.row(mesh.triangles(t, 0));
    const Vector3d b = mesh.vertices.row(mesh.triangles(t, 1));
    const Vector3d c = mesh.vertices.row(mesh.triangles(t, 2));
    Eigen::Index axis = 0;
    (b - a).cross(c - a).cwiseAbs().maxCoeff(&axis);
    const Eigen::Index u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (const auto& [corner, p] : {std::pair(0, a), std::pair(1, b), std::pair(2, c)}) {
      result.texture_coordinates.row(3 * t + corner) << p[u], p[v];
    }
  }
  return result;
}

double MetresPerCoordinate(const SurfaceMesh& mesh) {
  double surface = 0, covered = 0;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const Vector3d a = mesh.vertices.row(mesh.triangles(t, 0));
    const Vector3d b = mesh.vertices.row(mesh.triangles(t, 1));
    const Vector3d c = mesh.vertices.row(mesh.triangles(t, 2));
    const Eigen::RowVector2d origin = mesh.texture_coordinates.row(3 * t);
    const Eigen::RowVector2d ab = mesh.texture_coordinates.row(3 * t + 1) - origin;
    const Eigen::RowVector2d ac = mesh.texture_coordinates.row(3 * t + 2) - origin;
    surface += (b - a).cross(c - a).norm();
    covered += std::abs(ab.x() * ac.y() - ab.y() * ac.x());
  }
  HPDM_CHECK(covered > 0);
  return std::sqrt(surface / covered);
}

}  // namespace hpdm
