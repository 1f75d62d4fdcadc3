#pragma once

#include <string>
#include <vector>

#include "engine/lattice/lattice.h"
#include "engine/mesh/surface_mesh.h"
#include "engine/organ_options.h"

namespace hpdm {

/// The measures of a closed surface for models without interior. Each vertex stands for a part of
/// the area and, with the tissue spread evenly, for a part of the volume. The thickness volume /
/// area turns a modulus or density of the tissue into one of the surface, and gives the model the
/// organ's own mass.
struct Skin {
  Eigen::VectorXd areas;  ///< V, m^2: a third of each triangle around the vertex, positive.
  double area = 0;        ///< m^2, the sum.
  double thickness = 0;   ///< m: enclosed volume / area.

  /// Volume per vertex, V, m^3.
  Eigen::VectorXd Volumes() const { return thickness * areas; }
};

/// Returns a third of the area of the triangles around each vertex, V, m^2.
Eigen::VectorXd VertexAreas(const SurfaceMesh& mesh);

/// Measures a closed surface. A vertex's area is at least a thousandth of the mean, so that every
/// vertex has a mass. Throws InputError (`name`: the organ's) if no volume is enclosed.
Skin MeasureSkin(const SurfaceMesh& rest, const std::string& name);

/// Returns springs from each vertex to its rest place, V, N/m. As in the lattice (support.h), each
/// support adds its stiffness times the volume of the vertices in its region, FixedSupportStiffness
/// if it is fixed. Without any support all vertices get a weak spring. `modulus`: Pa. Throws
/// InputError if a support holds no vertex.
Eigen::VectorXd GroundSprings(const SurfaceMesh& rest, const Skin& skin,
                              const std::vector<SupportOptions>& supports, double modulus,
                              const std::string& name);

/// Returns the weights for vertices that are their own control points: the identity, V x V.
WeightMatrix VertexWeights(Eigen::Index vertex_count);

}  // namespace hpdm
