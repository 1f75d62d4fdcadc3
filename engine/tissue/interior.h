#pragma once

#include <array>
#include <vector>

#include "engine/base/oriented_box.h"
#include "engine/lattice/tissue_pieces.h"
#include "engine/mesh/surface_mesh.h"

namespace hpdm {

struct InteriorOptions {
  /// Samples along the longest side of the box that decide what is tissue near the surface. Their
  /// number is rounded up to a power of two times the cells. A wall needs two samples across. The
  /// cost grows with the square of the resolution.
  int resolution = 128;
  /// Gauss points along each axis of a cell that lies entirely inside: 1..5.
  int gauss_points = 3;
  /// Degree 0..6 to which the samples of a cell that the surface crosses are reduced: to at most 54
  /// points for degree 3. They keep the integral of every polynomial of at most this degree along
  /// each axis and twice it in total (moment_compression.h).
  int moment_degree = 3;
  /// Cells that the narrowest function of the lattice spans along each axis. With it the pieces of
  /// tissue are found that such functions tell apart (tissue_pieces.h), and each piece of a cell gets
  /// points of its own, so that it keeps its integrals. All 0: pieces are not sought.
  std::array<int, 3> support_cells = {0, 0, 0};
  /// Cuts of the organ, in the box that is sampled, or nullptr. Needs support_cells.
  CutSurfaces cuts = nullptr;
};

/// Points and weights of an integral over the tissue: int f dV ~ sum_q weights_q f(points_q).
struct TissueQuadrature {
  Points points;            ///< Q x 3, m, world; in the tissue, or within a sample's size of it.
  Eigen::VectorXd weights;  ///< Q, m^3, > 0.
  std::vector<int> cells;  ///< Q: cell of each point, ascending; cell (i, j, k): i + nx (j + ny k).
  Eigen::VectorXd cell_volumes;  ///< nx ny nz: volume of the tissue in each cell, m^3.
  TissuePieces pieces;           ///< Empty unless InteriorOptions::support_cells is given.
  double Volume() const { return weights.sum(); }
};

/// Places quadrature points in the tissue inside the box, cell by cell. Tissue is where the
/// generalised winding number of `mesh_W` (m, world) exceeds 0.5, so open, self-crossing and dirty
/// surfaces work. The box is divided into cells[k] equal cells along axis k.
///
/// 1. A cell without surface is inside or outside as a whole. Inside it gets tensor Gauss points.
/// 2. A cell that the surface crosses is split into eighths down to the resolution. The smallest
///    parts that the surface cuts count by the volume on the tissue's side of the nearest
///    triangle's plane. The points of the cell are then reduced to few (moment_compression.h).
/// 3. The cells serve the integration only. A B-spline lattice passes its own cells. A Bernstein
///    lattice, which has one cell, passes about as many as its degree.
/// 4. A cell that a cut crosses, or that lies within a cell of a cut's front, keeps many points: none
///    of them stands for tissue on both sides, and parts shrink towards the front, whose functions
///    are singular. Together they keep the cell's integrals of polynomials without the cut.
/// 5. All decisions are relative to the box, so a scaled body gets scaled points.
///
/// Deterministic; one thread; set-up only. Throws InputError if no sample inside the box meets
/// tissue, or if so many triangles cross each other there that sampling would take minutes.
TissueQuadrature SampleTissue(const SurfaceMesh& mesh_W, const OrientedBox& box_W,
                              const std::array<int, 3>& cells,
                              const InteriorOptions& options = InteriorOptions());

/// Returns the centroid of the tissue, m, world.
Vector3d CentreOfVolume(const TissueQuadrature& tissue);

}  // namespace hpdm
