#pragma once

#include <array>
#include <vector>

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// Generalised winding number of a triangle surface (Jacobson, Kavan, Sorkine-Hornung 2013). It is
/// the solid angle that the surface spans around a point, over 4 pi. The surface may be open,
/// self-crossing or a soup. The number is 1 inside and 0 outside a closed surface that faces
/// outwards. A gap changes it only by the gap's own solid angle, so 0.5 still separates inside from
/// outside.
///
/// 1. A tree of triangle clusters makes it fast (Barill, Dickson, Schmidt, Levin, Jacobson 2018). A
///    cluster farther than `opening` times its radius is evaluated by its second-order Taylor
///    expansion. Nearer triangles contribute their exact solid angle (Van Oosterom and Strackee
///    1983).
/// 2. tests/engine/mesh/winding_number_test.cc measures the error against the exact sum.
/// 3. Construction is O(F log F). At() is O(log F), allocates nothing and may be called from
///    several threads. Its result depends on the mesh only, not on the order of calls.
class WindingNumber {
 public:
  /// Keeps its own copy of the triangles. `opening` > 1; larger is more accurate and slower.
  explicit WindingNumber(const SurfaceMesh& mesh, double opening = 2)
      : WindingNumber(mesh.vertices, mesh.triangles, opening) {}
  WindingNumber(const Points& vertices, const Triangles& triangles, double opening = 2);

  /// Returns the winding number at the point p, in the mesh's frame and unit. On the surface itself
  /// it is that of one of the two sides.
  double At(const Vector3d& p) const;

 private:
  using Corners = std::array<Vector3d, 3>;

  /// A cluster: triangles [first, last) and their moments about `centre`. The integrals are over
  /// the area; n is the unit normal, x the position relative to the centre.
  struct Node {
    Vector3d centre;            ///< Area-weighted.
    double open_distance2;      ///< Squared distance beyond which the moments suffice.
    Vector3d normal;            ///< int n
    double divergence;          ///< int n . x
    std::array<double, 6> q2;   ///< int (r . n)(r . x) as a quadratic form in r: xx yy zz xy xz yz
    Vector3d linear;            ///< int 2 (n . x) x + (x . x) n
    std::array<double, 10> q3;  ///< int (r . n)(r . x)^2 as a cubic form in r
    int first, last;
    int far_child;  ///< The near child is the next node; 0 for a leaf.
  };

  void Build(std::vector<int>* order, const std::vector<Corners>& corners, int first, int last);
  void SetMoments(Node* node, double opening) const;
  static double Far(const Node& node, const Vector3d& r);

  double opening_;
  std::vector<Corners> triangles_;  // in the order of the leaves
  std::vector<Node> nodes_;         // depth first
};

/// Returns the exact sum over all triangles, O(F): the reference for tests of WindingNumber.
double ExactWindingNumber(const SurfaceMesh& mesh, const Vector3d& p);

}  // namespace hpdm
