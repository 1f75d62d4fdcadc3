#pragma once

#include <array>
#include <vector>

#include "engine/base/types.h"

namespace hpdm {

/// Splits a nearly planar polygon into n - 2 triangles of corner numbers with the polygon's
/// orientation. The polygon is given by its corners in order (n x 3, n >= 3). Clips ears in the
/// plane of the polygon's Newell normal (Meisters, "Polygons have ears", 1975).
///
/// Concave polygons and bridges to holes (repeated corners) are covered without overlap. A polygon
/// that crosses itself still gets n - 2 triangles along its border, so a closed mesh stays closed.
/// At most 8 n^2 point tests.
std::vector<std::array<int, 3>> TriangulatePolygon(const Points& corners);

}  // namespace hpdm
