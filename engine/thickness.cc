#include "engine/thickness.h"

#include "engine/collision.h"

namespace hpdm {
namespace {

constexpr int kMaxShrinks = 30;
constexpr double kSameFacets = 0.5;  // cos 60 degrees

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

// Coordinates in fractions of the extent, rounded, so that ties between facets are decided alike
// for a body of any scale.
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
  Eigen::VectorXd thickness(unit.vertices.rows());
  for (Eigen::Index v = 0; v < thickness.size(); ++v) {
    const Vector3d normal = directions.row(v);
    thickness[v] = at_most;
    if (normal.squaredNorm() == 0) continue;
    const double largest = at_most / (2 * extent);
    const double radius = InscribedRadius(unit, tree, unit.vertices.row(v), normal, largest);
    if (radius < largest) thickness[v] = 2 * extent * radius;
  }
  return thickness;
}

}  // namespace hpdm
