#pragma once

#include <string>
#include <vector>

#include "engine/mesh/surface_mesh.h"
#include "tools/plan/organ_touches.h"

namespace hpdm {

/// What an organ does under its cases, as well as can be found here: what models are judged by.
struct ReferenceSolution {
  std::vector<Points> displacements;  ///< Of each case, V x 3, m.
  int cells = 0;                      ///< Along the longest side, of the finest lattice.
  int control_points = 0;
  /// How far the finest lattice is from the one before (PooledError). About as far, it turned out,
  /// as quadratic tetrahedra are from it.
  double doubt = 0;
  /// What finite strain changes on a coarse lattice (PooledError).
  double finite_share = 0;
  bool finite = false;  ///< That change has been added.
};

/// The relative L2 distance of RelativeSurfaceError over all cases together (V x 3, m, each): a
/// touch that moves little, beside a support, counts as little as it moves.
double PooledError(const SurfaceMesh& rest, const std::vector<Points>& u,
                   const std::vector<Points>& reference);

/// Solves the cases on lattices of 12, 16, 24 .. 48 cells (engine/reference_fem/fine_lattice.h)
/// until one changes the answer by less than 0.4 of `error`, or would take minutes. The loads are
/// taken as they are, so presses must have been scaled (ScalePresses). Where on a lattice of 4
/// cells finite strain changes the answer by more than half of `error`, that difference is added if
/// the scene asks for more than small strain, and a remark if it does not. Throws InputError.
ReferenceSolution MakeReferenceSolution(const OrganOptions& organ, const SurfaceMesh& rest,
                                        const OrganTouches& touches, double error,
                                        std::vector<std::string>* remarks);

/// Gives each press of one newton the force with which a hand's springs (`stiffness`, N/m) push
/// that means to go `depth` (m) in, against the tissue's compliance on a coarse lattice.
void ScalePresses(const OrganOptions& organ, const SurfaceMesh& rest, double stiffness,
                  double depth, OrganTouches* touches);

}  // namespace hpdm
