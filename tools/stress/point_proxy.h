#pragma once

#include "engine/mesh/collision.h"
#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// Baseline for the haptic loop: the god-object of a point tool (Zilles and Salisbury 1995), on the
/// triangles of the last step alone. The proxy moves towards the tool until a triangle that it
/// would enter from outside stops it. It slides along up to two such planes. The force on the hand
/// is k (proxy - tool).
///
/// The proxy does not know the surface's motion between two steps, so a surface can pass it. It has
/// no tissue model and no tip radius.
class PointProxy {
 public:
  /// `stiffness`: k, N/m.
  PointProxy(const SurfaceMesh& rest, double stiffness);

  /// Sets the surface of a new step: all of it moved by `offset_W` (m) from rest.
  void MoveSurface(const Vector3d& offset_W) { offset_W_ = offset_W; }

  /// Returns the force on the hand, N. The first tick puts the proxy at the tool.
  Vector3d Tick(const Vector3d& p_tool_W);

 private:
  SurfaceMesh rest_;
  SurfaceTree tree_;
  double stiffness_;
  Vector3d offset_W_ = Vector3d::Zero();
  bool started_ = false;
  Vector3d p_proxy_W_ = Vector3d::Zero();
};

}  // namespace hpdm
