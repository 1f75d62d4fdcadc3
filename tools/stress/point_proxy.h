#pragma once

#include "engine/mesh/collision.h"
#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// A baseline of the haptic loop: the god-object (Zilles and Salisbury 1995) of a point tool, on
/// the triangles of the last step alone. The proxy goes to the tool as far as no triangle that it
/// would enter from outside is in the way, along up to two such planes, and the force on the hand
/// is k (proxy - tool). Nothing tells it how the surface goes on between two steps, so it is past
/// what moved past it. No tissue, no tip radius.
class PointProxy {
 public:
  /// `stiffness`: k, N/m.
  PointProxy(const SurfaceMesh& rest, double stiffness);

  /// The surface as a new step has it, all of it moved by `offset_W` (m) from rest.
  void MoveSurface(const Vector3d& offset_W) { offset_W_ = offset_W; }

  /// Force on the hand, N; the first tick puts the proxy where the tool is.
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
