#include "engine/mesh/coarse_surface.h"

#include <meshoptimizer.h>

#include <utility>
#include <vector>

namespace hpdm {
namespace {

// A simplified surface with more than this share of the triangles is not worth having.
constexpr double kWorthwhile = 0.5;

// Returns no triangles if it is not worth it.
Triangles Simplify(const SurfaceMesh& mesh) {
  const Eigen::RowVector3d centre = mesh.vertices.colwise().mean();
  const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> positions =
      (mesh.vertices.rowwise() - centre).cast<float>();
  double area = 0;
  std::vector<unsigned> indices;
  indices.reserve(static_cast<std::size_t>(mesh.triangles.size()));
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    area += TwiceAreaNormal(mesh.vertices, mesh.triangles, t).norm() / 2;
    for (int k = 0; k < 3; ++k) indices.push_back(static_cast<unsigned>(mesh.triangles(t, k)));
  }
  const double wanted = area / CoarseSurface::kTriangleArea;
  if (!(wanted < kWorthwhile * static_cast<double>(mesh.triangles.rows()))) return {0, 3};
  const float scale = meshopt_simplifyScale(positions.data(), positions.rows(), 3 * sizeof(float));
  std::vector<unsigned> coarse(indices.size());
  coarse.resize(meshopt_simplify(coarse.data(), indices.data(), indices.size(), positions.data(),
                                 static_cast<std::size_t>(positions.rows()), 3 * sizeof(float),
                                 3 * static_cast<std::size_t>(wanted),
                                 static_cast<float>(CoarseSurface::kMaxError) / scale, 0, nullptr));
  if (static_cast<double>(coarse.size()) > kWorthwhile * static_cast<double>(indices.size())) {
    return {0, 3};
  }
  Triangles triangles(static_cast<Eigen::Index>(coarse.size() / 3), 3);
  for (std::size_t i = 0; i < coarse.size(); ++i) {
    triangles.data()[i] = static_cast<int>(coarse[i]);
  }
  return triangles;
}

}  // namespace

std::optional<CoarseSurface> CoarseSurface::Of(const SurfaceMesh& mesh) {
  Triangles triangles = Simplify(mesh);
  if (triangles.rows() == 0) return std::nullopt;
  return CoarseSurface(mesh, std::move(triangles));
}

CoarseSurface::CoarseSurface(const SurfaceMesh& mesh, Triangles triangles)
    : triangles_(std::move(triangles)),
      topology_(mesh.vertices.rows(), triangles_),
      tree_(mesh.vertices, triangles_) {}

}  // namespace hpdm
