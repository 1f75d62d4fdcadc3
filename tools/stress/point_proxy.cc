#include "tools/stress/point_proxy.h"

#include <Eigen/Geometry>

namespace hpdm {

PointProxy::PointProxy(const SurfaceMesh& rest, double stiffness)
    : rest_(rest), tree_(rest_.vertices, rest_.triangles), stiffness_(stiffness) {}

Vector3d PointProxy::Tick(const Vector3d& p_tool_W) {
  constexpr double kAbove = 1e-6;  // m: distance of the proxy from its surface
  if (!started_) p_proxy_W_ = p_tool_W;
  started_ = true;
  Vector3d goal_W = p_tool_W, first_normal = Vector3d::Zero();
  for (int planes = 0; planes < 3; ++planes) {
    const SurfaceHit hit = tree_.FirstEntry(p_proxy_W_ - offset_W_, goal_W - offset_W_);
    if (hit.at.triangle < 0) {
      p_proxy_W_ = goal_W;
      break;
    }
    const Eigen::RowVector3i corners = rest_.triangles.row(hit.at.triangle);
    const Vector3d a = rest_.vertices.row(corners[0]), b = rest_.vertices.row(corners[1]),
                   c = rest_.vertices.row(corners[2]);
    const Vector3d n = (b - a).cross(c - a).normalized();
    p_proxy_W_ = hit.at.Position(rest_.vertices, rest_.triangles) + offset_W_ + kAbove * n;
    Vector3d left = goal_W - p_proxy_W_;
    if (planes == 0) {
      left -= n.dot(left) * n;
    } else {  // along the edge of both planes
      const Vector3d edge = first_normal.cross(n).stableNormalized();
      left = edge.dot(left) * edge;
    }
    first_normal = n;
    goal_W = p_proxy_W_ + left;
  }
  return stiffness_ * (p_proxy_W_ - p_tool_W);
}

}  // namespace hpdm
