#pragma once

#include "engine/mesh/collision.h"
#include "engine/mesh/surface_mesh.h"
#include "engine/solver/relaxation.h"

namespace hpdm {

/// A press on an organ at rest: the mean of the surface under a round patch goes inwards along the
/// normal there.
struct SurfacePress {
  SurfacePoint at;
  double radius = 0;  ///< m, of the kernel cos(pi d / 2 radius); 0: the point alone.
  double depth = 0;   ///< m.
};

/// Weights of a patch over the vertices, V, sum 1: the kernel times the area of each vertex within
/// `radius` (rest distance) of the point; the point's own corners when that holds no vertex.
Eigen::RowVectorXd PatchWeights(const SurfaceMesh& rest, const SurfacePoint& at, double radius);

struct PressOutcome {
  double volume_change = 0;             ///< Of the enclosed volume, relative.
  Vector3d force_W = Vector3d::Zero();  ///< On the tissue, N.
  Points vertices;                      ///< V x 3, m, world.
  RelaxationResult relaxed;             ///< The last step.
};

/// Presses a model with any relaxation: the patch is taken to its depth in `ramp` equal steps and
/// held for `hold` more (static relaxations need one and none). `weights`: V x n, vertices over
/// what the relaxation moves (the lattice's, or VertexWeights for a model of the vertices
/// themselves). Allocates; not for a loop.
PressOutcome MeasurePress(const SurfaceMesh& rest, const WeightMatrix& weights,
                          const SurfacePress& press, int ramp, int hold, Relaxation* relaxation);

}  // namespace hpdm
