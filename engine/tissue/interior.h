#pragma once

#include <array>
#include <vector>

#include "engine/base/oriented_box.h"
#include "engine/mesh/surface_mesh.h"

namespace hpdm {

struct InteriorOptions {
  /// Samples along the longest side of the box (rounded up to a power of two times the cells) that
  /// decide what is tissue near the surface; a wall needs two across. The cost grows with its
  /// square.
  int resolution = 128;
  /// Gauss points along each axis of a cell that lies wholly inside: 1..5.
  int gauss_points = 3;
  /// The samples of a cell that the surface crosses are reduced to at most 54 points (degree 3)
  /// that keep the integral of every polynomial of at most this degree along each axis and twice it
  /// in total (moment_compression.h): 0..6.
  int moment_degree = 3;
};

/// Points and weights that integrate over the tissue: int f dV = sum_q weights_q f(points_q).
struct TissueQuadrature {
  Points points;            ///< Q x 3, m, world; in the tissue, or within a sample's size of it.
  Eigen::VectorXd weights;  ///< Q, m^3, > 0.
  std::vector<int> cells;   ///< Q: the cell of each point, ascending, numbered i + nx (j + ny k).
  Eigen::VectorXd cell_volumes;  ///< nx ny nz: tissue in each cell, m^3.
  double Volume() const { return weights.sum(); }
};

/// Places quadrature points in the part of the solid bounded by `mesh_W` (m, world; open, crossing
/// or dirty surfaces too: tissue is where the generalised winding number exceeds 0.5) that lies
/// inside the box, cell by cell of its division into cells[k] equal parts along each axis.
///
/// A cell without surface in it is inside or outside as a whole and gets tensor Gauss points. One
/// that the surface crosses is split into eighths down to the resolution; the smallest parts that
/// it cuts count by the volume on the tissue's side of the nearest triangle's plane; and the many
/// points are reduced to few (moment_compression.h).
///
/// The cells are those of the integration, not of a basis: a B-spline lattice takes its own cells,
/// a Bernstein lattice, which is one cell, about as many as its degree.
///
/// All decisions are relative to the box: a scaled body gets scaled points. Deterministic; one
/// thread; set-up only. Throws InputError when the mesh has no tissue inside the box that a sample
/// meets, or so many triangles across each other there that sampling would take minutes.
TissueQuadrature SampleTissue(const SurfaceMesh& mesh_W, const OrientedBox& box_W,
                              const std::array<int, 3>& cells,
                              const InteriorOptions& options = InteriorOptions());

/// Centre of the tissue's volume, m, world.
Vector3d CentreOfVolume(const TissueQuadrature& tissue);

}  // namespace hpdm
