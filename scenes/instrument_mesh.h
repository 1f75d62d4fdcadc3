#pragma once

#include "engine/surface_mesh.h"

namespace hpdm {

/// A palpation probe of 562 triangles, closed: a shaft of radius 2.5 mm with a half ball at the tip
/// and a flat end. Tool frame: origin at the centre of the tip's ball, z along the shaft towards
/// the trocar, y the axis of the jaws of its siblings; the shaft runs from z = 0 to 0.3 m.
SurfaceMesh ProbeMesh();

}  // namespace hpdm
