#include "engine/mesh/thickness.h"

#include <algorithm>
#include <vector>

#include "engine/mesh/collision.h"

namespace hpdm {
namespace {

constexpr int kMaxShrinks = 30;
constexpr double kSameFacets = 0.5;  // cos 60 degrees
// The centre of a ball in the corner of two faces at right angles is 1.41 radii from their edge.
constexpr double kCover = 1.5;

struct Ball {
  Vector3d centre;
  double radius;
};

double InscribedRadius(const SurfaceMesh& mesh, const SurfaceTree& tree, const Vector3d& p,
                       const Vector3d& normal, double largest) {
  double radius = largest;
  for (int shrink = 0; shrink < kMaxShrinks; ++shrink) {
    const Vector3d centre = p - radius * normal;
    const SurfaceHit nearest = tree.Closest(centre, 2 * radius);
    if (nearest.at.triangle < 0 || nearest.distance >= (1 - 1e-6) * radius) break;
    const Vector3d q = nearest.at.Position(mesh.vertices, mesh.triangles);
    const double depth = normal.dot(p - q);
    if (!(depth > 0)) break;
    const double smaller = (p - q).squaredNorm() / (2 * depth);
    if (!(smaller < radius)) break;
    const Vector3d to_q = q - (p - smaller * normal);
    if (normal.dot(to_q) > kSameFacets * to_q.norm()) break;
    radius = smaller;
  }
  return radius;
}

// Returns coordinates in fractions of `unit`, rounded so that ties between facets are decided the
// same way for a body of any scale.
Points Snapped(const Points& values, const Eigen::RowVector3d& origin, double unit) {
  constexpr double kSteps = 1 << 30;
  return ((values.rowwise() - origin) * (kSteps / unit)).array().round() / kSteps;
}

}  // namespace

Eigen::VectorXd LocalThickness(const SurfaceMesh& mesh, const Points& normals, double at_most) {
  const Eigen::RowVector3d low = mesh.vertices.colwise().minCoeff();
  const double extent = (mesh.vertices.colwise().maxCoeff() - low).maxCoeff();
  const SurfaceMesh unit{Snapped(mesh.vertices, low, extent), mesh.triangles, {}};
  const Points directions = Snapped(normals, Eigen::RowVector3d::Zero(), 1);
  const SurfaceTree tree(unit.vertices, unit.triangles);
  const double largest = at_most / (2 * extent);
  std::vector<Ball> balls;
  std::vector<Eigen::Index> uncovered;
  for (Eigen::Index v = 0; v < unit.vertices.rows(); ++v) {
    uncovered.push_back(v);
    const Vector3d p = unit.vertices.row(v), normal = directions.row(v);
    const bool has_normal = normal.squaredNorm() > 0;
    const double radius = has_normal ? InscribedRadius(unit, tree, p, normal, largest) : largest;
    balls.push_back({p - radius * normal, radius});
  }
  std::stable_sort(balls.begin(), balls.end(),
                   [](const Ball& a, const Ball& b) { return a.radius > b.radius; });
  Eigen::VectorXd thickness(unit.vertices.rows());
  for (const Ball& ball : balls) {
    std::erase_if(uncovered, [&](Eigen::Index v) {
      const double reach = kCover * ball.radius;
      if (!((unit.vertices.row(v).transpose() - ball.centre).squaredNorm() <= reach * reach)) {
        return false;
      }
      thickness[v] = ball.radius < largest ? 2 * extent * ball.radius : at_most;
      return true;
    });
    if (uncovered.empty()) break;
  }
  return thickness;
}

}  // namespace hpdm
