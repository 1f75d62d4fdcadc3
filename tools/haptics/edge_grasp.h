#pragma once

/// Two jaws that hold the edge of a wedge like the liver's (edge_wedge.h) and turn.
namespace hpdm {

/// Stiffness against rotations about the middle of the held tissue, N m.
struct GraspTurns {
  double in_faces = 0;    ///< About x, along which the jaws open: in their faces.
  double about_edge = 0;  ///< About y, the edge: bends the tissue.
  double twist = 0;       ///< About z, off the edge.
};

/// Returns that of hexahedra (EdgeWedge).
GraspTurns ExactGraspTurns();

/// Returns that of the step's own rows (engine/step/grasp.h): the jaws close and turn by 1 mrad, and
/// the contact solver gives the rows' forces. NaN: they hold nothing.
///   edge: of the mesh, m. `cells` along each axis and `functions` local functions.
GraspTurns TurnGrasp(double edge, int cells, int functions);

}  // namespace hpdm
