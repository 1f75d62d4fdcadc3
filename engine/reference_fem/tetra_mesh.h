#pragma once

#include <array>
#include <string>
#include <vector>

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// Rows are tetrahedra: T x 4 (linear) or T x 10 (quadratic) node indices. The first four are the
/// corners, with (b - a) x (c - a) . (d - a) > 0; then the middles of kTetraEdges in order.
using Tetrahedra = Eigen::Matrix<int, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Corner pairs of a tetrahedron's edges: node 4 + e of a quadratic one is the middle of edge e.
inline constexpr std::array<std::array<int, 2>, 6> kTetraEdges = {
    {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};

/// A straight-sided tetrahedral mesh. Corner nodes come first: [0, corners).
struct TetraMesh {
  Points nodes;         ///< N x 3, m.
  Tetrahedra elements;  ///< T x 4 or T x 10.
  int corners = 0;      ///< Nodes that are corners; N when linear.
  /// The two corners of each further node's edge.
  std::vector<std::array<int, 2>> parents;

  bool quadratic() const { return elements.cols() == 10; }
};

/// Builds a linear mesh and reorients inverted elements. Throws InputError naming `where` if an
/// index is out of range, a number is not finite or an element has no volume.
TetraMesh MakeTetraMesh(const Points& nodes, const Tetrahedra& elements, const std::string& where);

/// Returns the same mesh with a node in the middle of every edge.
TetraMesh Quadratic(const TetraMesh& linear);

/// Returns a box of nx x ny x nz bricks, each split into six tetrahedra around its diagonal (Kuhn).
TetraMesh BoxTetraMesh(const Vector3d& min, const Vector3d& max, const std::array<int, 3>& cells);

/// Reads the nodes and four-node tetrahedra of a Gmsh file, format 1 ("$NOD", "$ELM") or 2 text
/// ("$Nodes", "$Elements"). Nodes keep their order in the file. Throws InputError.
TetraMesh ReadGmsh(const std::string& path);

/// Volume of the corner tetrahedra, m^3.
double TetraVolume(const TetraMesh& mesh);

/// A point in barycentric coordinates of the element that contains it or, outside the mesh, of the
/// nearest one. Its shape functions are then extrapolated (exact for affine displacements).
struct TetraPoint {
  int element = -1;
  Eigen::Vector4d barycentric = Eigen::Vector4d::Zero();  ///< Sums to one; negative outside.
  double distance = 0;                                    ///< Distance to the element, m; 0 inside.
};
/// Locates each row of `points` (m): O(T) box tests per point.
std::vector<TetraPoint> Locate(const TetraMesh& mesh, const Points& points);

/// Returns the values of the shape functions (4 or 10) at barycentric coordinates.
Eigen::VectorXd ShapeFunctions(bool quadratic, const Eigen::Vector4d& barycentric);

/// Returns the edges of element e from its first corner to the other three, as columns, m. The
/// determinant is six times the element's volume.
inline Matrix3d CornerEdges(const TetraMesh& mesh, Eigen::Index e) {
  Matrix3d edges;
  for (int k = 1; k < 4; ++k) {
    edges.col(k - 1) =
        (mesh.nodes.row(mesh.elements(e, k)) - mesh.nodes.row(mesh.elements(e, 0))).transpose();
  }
  return edges;
}

}  // namespace hpdm
