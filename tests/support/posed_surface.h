#pragma once

#include "engine/mesh/collision.h"
#include "engine/mesh/surface_topology.h"
#include "engine/pairs/organ_pair.h"

namespace hpdm {

/// A surface that a test moves as it likes, as one side of an OrganPair.
class PosedSurface {
 public:
  explicit PosedSurface(const SurfaceMesh& rest)
      : rest_(rest),
        topology_(rest.vertices.rows(), rest.triangles),
        tree_(rest.vertices, rest.triangles) {
    vertices = rest.vertices;
  }

  PairSurface surface() const { return {&rest_, &topology_}; }
  PairShape shape() const { return {vertices, tree_, offset_W}; }
  const SurfaceMesh& rest() const { return rest_; }

  void Place(const Isometry3d& X) {
    for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
      vertices.row(v) = X * Vector3d(rest_.vertices.row(v));
    }
    tree_.Refit(vertices);
  }
  template <typename Map>
  void Deform(const Map& map) {
    for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
      vertices.row(v) = map(Vector3d(vertices.row(v)));
    }
    tree_.Refit(vertices);
  }
  Vector3d At(const SurfacePoint& at) const {
    return at.Position(vertices, rest_.triangles) + offset_W;
  }

  Points vertices;
  Vector3d offset_W = Vector3d::Zero();

 private:
  SurfaceMesh rest_;
  SurfaceTopology topology_;
  SurfaceTree tree_;
};

}  // namespace hpdm
