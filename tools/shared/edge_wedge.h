#pragma once

#include <algorithm>
#include <cmath>

#include "engine/organ.h"
#include "tools/shared/simple_bodies.h"

namespace hpdm {

/// The edge of a wedge like the liver's: along y at z = kHeld, the tissue below it, and x is its
/// thickness.
struct EdgeWedge {
  static constexpr double kHeld = 0.008;       ///< m, from the origin to the edge.
  static constexpr double kDepth = 0.06;       ///< m, from the edge to the other end.
  static constexpr double kHalfLength = 0.05;  ///< m.
  static constexpr double kYoung = 5000;       ///< Pa, of the stiffness below.
  static constexpr double kPoisson = 0.3;
  /// Stiffness of a grasp by jaws of 5 mm whose tips are at the origin, N/m. Quadratic tetrahedra
  /// (engine/reference_fem) with both faces bonded to a rigid body: 7,425, 23,569 and 54,145 nodes
  /// give 25.0, 24.7, 24.5 along the edge and 34.8, 34.2, 34.0 off it. Extrapolated.
  static constexpr double kAlongEdge = 24.3, kOffEdge = 33.6;
  /// The same of 27-node hexahedra: across the edge, N/m, and against rotations about the middle of
  /// the held tissue, N m, about x, y and z. 9,657 and 30,745 nodes on a quarter of the wedge give
  /// 6.14 and 6.12, 8.70e-4 and 8.61e-4, 7.90e-4 and 7.83e-4, 6.27e-4 and 6.22e-4; along the edge and
  /// off it 24.4 and 24.4, 33.9 and 33.7. Extrapolated.
  static constexpr double kAcrossEdge = 6.07;
  static constexpr double kTurnInFaces = 8.4e-4, kTurnAboutEdge = 7.7e-4, kTwist = 6.1e-4;

  /// Half the thickness at the distance `s` from the edge, m.
  static double HalfThickness(double s) { return 0.002 + 0.25 * s; }

  /// The surface with squares of about `edge` (m), each of two triangles.
  static SurfaceMesh Surface(double edge) {
    const auto count = [&](double length) { return static_cast<int>(std::lround(length / edge)); };
    SurfaceMesh mesh = GridBox(Vector3d(-1, -1, 0), Vector3d(1, 1, 1),
                               {std::max(2, count(0.02)), count(2 * kHalfLength), count(kDepth)});
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
      const Vector3d at = mesh.vertices.row(v);
      const double s = kDepth * (1 - at.z());
      mesh.vertices.row(v) << at.x() * HalfThickness(s), at.y() * kHalfLength, kHeld - s;
    }
    return mesh;
  }
  /// `cells` along each axis and `functions` local functions; the end far from the edge is held.
  static OrganOptions Options(int cells, int functions) {
    OrganOptions options;
    options.name = "wedge";
    options.material.young = kYoung;
    options.material.poisson = kPoisson;
    options.lattice.cells = {cells, cells, cells};
    options.lattice.local.functions = functions;
    options.supports.push_back({BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.03)}, {}});
    return options;
  }
};

}  // namespace hpdm
