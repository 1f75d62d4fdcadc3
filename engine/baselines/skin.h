#pragma once

#include <string>
#include <vector>

#include "engine/lattice/lattice.h"
#include "engine/mesh/surface_mesh.h"
#include "engine/organ_options.h"

namespace hpdm {

/// What the surface models need of an organ that they know by its surface only: each vertex stands
/// for a part of the surface and, the tissue spread evenly over it, for a part of the volume. So a
/// modulus or density of the tissue becomes one of the surface by the thickness volume / area, and
/// the model has the organ's own mass.
struct Skin {
  Eigen::VectorXd areas;  ///< V, m^2: a third of each triangle around the vertex, positive.
  double area = 0;        ///< m^2, the sum.
  double thickness = 0;   ///< m: enclosed volume / area.

  /// Volume that each vertex stands for, V, m^3.
  Eigen::VectorXd Volumes() const { return thickness * areas; }
};

/// A third of the area of the triangles around each vertex, V, m^2.
Eigen::VectorXd VertexAreas(const SurfaceMesh& mesh);

/// Measures a closed surface. A vertex with next to no area counts as a thousandth of the mean one,
/// so that it has a mass. Throws InputError (`name`: the organ's) when no volume is enclosed.
Skin MeasureSkin(const SurfaceMesh& rest, const std::string& name);

/// Springs from each vertex to its rest place, V, N/m: for every support (support.h) the vertices
/// inside its region by the volume that they stand for, with FixedSupportStiffness when it is
/// fixed, as the lattice does with its tissue; without any support a weak one for all. `modulus` in
/// Pa. Throws InputError when a support holds no vertex.
Eigen::VectorXd GroundSprings(const SurfaceMesh& rest, const Skin& skin,
                              const std::vector<SupportOptions>& supports, double modulus,
                              const std::string& name);

/// Every vertex is its own control point: the identity, V x V.
WeightMatrix VertexWeights(Eigen::Index vertex_count);

}  // namespace hpdm
