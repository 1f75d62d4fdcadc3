#include "scenes/generator/texturing/texture_baking.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "engine/base/check.h"

namespace hpdm {
namespace {

using Index = Eigen::Index;
using Corners = Eigen::Matrix<double, 3, 2>;

/// Number of texels around a chart whose colour comes from its surface.
constexpr double kReach = 3;

/// An unfinished picture: colours, and flags of the pixels that have one.
struct Canvas {
  explicit Canvas(int pixels) : size(pixels), colours(ToSize(pixels * pixels), Vector3d::Zero()) {
    known.resize(colours.size());
  }
  std::size_t Pixel(int x, int y) const { return ToSize(y * size + x); }
  int size;
  std::vector<Vector3d> colours;
  std::vector<bool> known;
};

double Cross(const Eigen::RowVector2d& a, const Eigen::RowVector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Point of a triangle (in texels) nearest to q.
Eigen::RowVector2d NearestPoint(const Corners& triangle, const Eigen::RowVector2d& q) {
  bool inside = true;
  Eigen::RowVector2d nearest = triangle.row(0);
  double least = std::numeric_limits<double>::max();
  for (int side = 0; side < 3; ++side) {
    const Eigen::RowVector2d a = triangle.row(side), along = triangle.row((side + 1) % 3) - a;
    if (Cross(along, q - a) >= 0) continue;
    inside = false;
    const double t = std::clamp((q - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
    const Eigen::RowVector2d p = a + t * along;
    if ((p - q).squaredNorm() >= least) continue;
    least = (p - q).squaredNorm();
    nearest = p;
  }
  return inside ? q : nearest;
}

/// Returns for each texel the triangle nearest to its centre, -1 beyond kReach.
std::vector<int> NearestTriangles(const SurfaceMesh& mesh, int size) {
  std::vector<int> nearest(ToSize(size * size), -1);
  std::vector<double> distance(nearest.size(), kReach * kReach);
  for (Index t = 0; t < mesh.triangles.rows(); ++t) {
    const Corners corners = size * mesh.texture_coordinates.middleRows<3>(3 * t);
    const Eigen::RowVector2d low = corners.colwise().minCoeff(),
                             high = corners.colwise().maxCoeff();
    const int right = std::min(size, static_cast<int>(high.x() + kReach + 1));
    const int top = std::min(size, static_cast<int>(high.y() + kReach + 1));
    for (int y = std::max(0, static_cast<int>(low.y() - kReach)); y < top; ++y) {
      for (int x = std::max(0, static_cast<int>(low.x() - kReach)); x < right; ++x) {
        const Eigen::RowVector2d centre(x + 0.5, y + 0.5);
        const double d = (NearestPoint(corners, centre) - centre).squaredNorm();
        double& least = distance[ToSize(y * size + x)];
        if (d >= least) continue;
        least = d;
        nearest[ToSize(y * size + x)] = static_cast<int>(t);
      }
    }
  }
  return nearest;
}

/// Returns the point at q (texels) of the surface, or up to a texel beyond it of the triangle's
/// plane.
Vector3d SurfacePoint(const SurfaceMesh& mesh, int size, Index t, const Eigen::RowVector2d& q) {
  const Corners corners = size * mesh.texture_coordinates.middleRows<3>(3 * t);
  const Eigen::RowVector2d inside = NearestPoint(corners, q);
  const double beyond = (q - inside).norm();
  const Eigen::RowVector2d at = inside + (q - inside) / std::max(1.0, beyond);
  const Eigen::RowVector2d a = corners.row(0), ab = corners.row(1) - a, ac = corners.row(2) - a;
  const double area = Cross(ab, ac), b = Cross(at - a, ac) / area, c = Cross(ab, at - a) / area;
  return (1 - b - c) * mesh.vertices.row(mesh.triangles(t, 0)) +
         b * mesh.vertices.row(mesh.triangles(t, 1)) + c * mesh.vertices.row(mesh.triangles(t, 2));
}

/// Fills the pixels without a colour from their surroundings (pull-push: Gortler et al. 1996, "The
/// lumigraph"). Each takes the mean of the known pixels at half the size, or at the next coarser
/// size that has one.
void FillUnknown(Canvas* canvas) {
  if (canvas->size == 1) return;
  Canvas half((canvas->size + 1) / 2);
  for (int y = 0; y < half.size; ++y) {
    for (int x = 0; x < half.size; ++x) {
      Vector3d sum = Vector3d::Zero();
      int count = 0;
      for (int j = 2 * y; j < std::min(2 * y + 2, canvas->size); ++j) {
        for (int i = 2 * x; i < std::min(2 * x + 2, canvas->size); ++i) {
          if (!canvas->known[canvas->Pixel(i, j)]) continue;
          sum += canvas->colours[canvas->Pixel(i, j)];
          ++count;
        }
      }
      if (count == 0) continue;
      half.colours[half.Pixel(x, y)] = sum / count;
      half.known[half.Pixel(x, y)] = true;
    }
  }
  FillUnknown(&half);
  for (int y = 0; y < canvas->size; ++y) {
    for (int x = 0; x < canvas->size; ++x) {
      if (canvas->known[canvas->Pixel(x, y)]) continue;
      // Bilinear: the pixel's centre lies a quarter of the way to the next coarse one.
      const auto beside = [&](int i) {
        return std::clamp(i / 2 + (i % 2 == 0 ? -1 : 1), 0, half.size - 1);
      };
      const auto at = [&](int i, int j) { return half.colours[half.Pixel(i, j)]; };
      canvas->colours[canvas->Pixel(x, y)] = (9 * at(x / 2, y / 2) + 3 * at(beside(x), y / 2) +
                                              3 * at(x / 2, beside(y)) + at(beside(x), beside(y))) /
                                             16;
    }
  }
}

}  // namespace

Image BakeTexture(const SurfaceMesh& mesh, int size, const SurfaceColour& colour) {
  HPDM_CHECK(size > 0 && mesh.texture_coordinates.rows() == 3 * mesh.triangles.rows());
  const std::vector<int> nearest = NearestTriangles(mesh, size);
  Canvas canvas(size);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const std::size_t pixel = canvas.Pixel(x, y);
      if (nearest[pixel] < 0) continue;
      for (const auto& [dx, dy] :
           {std::pair(0.25, 0.25), {0.75, 0.25}, {0.25, 0.75}, {0.75, 0.75}}) {
        const Eigen::RowVector2d q(x + dx, y + dy);
        canvas.colours[pixel] += colour(SurfacePoint(mesh, size, nearest[pixel], q)) / 4;
      }
      canvas.known[pixel] = true;
    }
  }
  FillUnknown(&canvas);
  Image image{size, size, {}};
  image.rgb.reserve(3 * canvas.colours.size());
  for (int y = size - 1; y >= 0; --y) {
    for (int x = 0; x < size; ++x) {
      for (int k = 0; k < 3; ++k) {
        const double component = std::clamp(canvas.colours[canvas.Pixel(x, y)][k], 0.0, 1.0);
        image.rgb.push_back(static_cast<std::uint8_t>(std::lround(component * 255)));
      }
    }
  }
  return image;
}

}  // namespace hpdm
