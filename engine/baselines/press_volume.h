#pragma once

#include "engine/mesh/collision.h"
#include "engine/mesh/surface_mesh.h"
#include "engine/solver/relaxation.h"

namespace hpdm {

/// A press on an organ at rest: moves the mean of a round patch inwards along the normal there.
struct SurfacePress {
  SurfacePoint at;
  double radius = 0;  ///< m, radius of the kernel cos(pi d / 2 radius); 0: the point alone.
  double depth = 0;   ///< m.
};

/// Returns the weights of a patch over the V vertices, with sum 1. The weight of a vertex within
/// `radius` (rest distance) of the point is the kernel times the vertex's area. Without such a
/// vertex they are the point's barycentric weights.
Eigen::RowVectorXd PatchWeights(const SurfaceMesh& rest, const SurfacePoint& at, double radius);

struct PressOutcome {
  double volume_change = 0;             ///< Relative change of the enclosed volume.
  Vector3d force_W = Vector3d::Zero();  ///< Force on the tissue, N.
  Points vertices;                      ///< V x 3, m, world.
  RelaxationResult relaxed;             ///< The last step.
};

/// Presses a model with any relaxation. Moves the patch to its depth in `ramp` equal steps and
/// holds it for `hold` more steps (static relaxations need 1 and 0). `weights` (V x n) map the
/// relaxation's unknowns to the vertices: the lattice's weights, or VertexWeights if the unknowns
/// are the vertices. Allocates; not for a loop.
PressOutcome MeasurePress(const SurfaceMesh& rest, const WeightMatrix& weights,
                          const SurfacePress& press, int ramp, int hold, Relaxation* relaxation);

}  // namespace hpdm
