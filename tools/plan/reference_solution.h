#pragma once

#include <string>
#include <vector>

#include "engine/mesh/surface_mesh.h"
#include "tools/plan/organ_touches.h"

namespace hpdm {

/// The most accurate solution of an organ's cases that can be computed here. Models are judged by
/// it.
struct ReferenceSolution {
  std::vector<Points> displacements;  ///< One per case, V x 3, m.
  int cells = 0;                      ///< Along the longest side of the finest lattice.
  int control_points = 0;
  /// Estimated error of the finest lattice (ReferenceDoubt). In tests, quadratic tetrahedra are
  /// about as far from it.
  double doubt = 0;
  /// Change due to finite strain on a coarse lattice (PooledError).
  double finite_share = 0;
  bool finite = false;  ///< True if that change has been added.
  bool split = false;   ///< True if tissue splits functions of the finest lattice.

  /// Returns the estimated error of a model at this distance (PooledError). Where functions are split
  /// both are too stiff at the same notches, so their errors add up; elsewhere they are independent.
  double ErrorAt(double distance) const;

  /// True if models can be judged to `error`: the doubt is at most half of it.
  bool Judges(double error) const { return doubt <= 0.5 * error; }
};

/// Estimates the error of the finest of successive lattices from how far each is from the one
/// before (PooledError), coarse to fine, at least one.
///
/// 1. The last change.
/// 2. More, if the changes fall slowly: what would follow if they fell at the same rate, of at most
///    3/4.
/// 3. `split`: at least half of the change before. At a notch, errors depend on how cells lie to
///    it, so two answers may agree by chance.
double ReferenceDoubt(const std::vector<double>& changes, bool split);

/// Returns the relative L2 distance of RelativeSurfaceError, pooled over all cases (V x 3, m,
/// each). A touch beside a support moves little and so counts little.
double PooledError(const SurfaceMesh& rest, const std::vector<Points>& u,
                   const std::vector<Points>& reference);

/// Solves the cases on lattices of 12, 16, 24 .. 48 cells (engine/reference_fem/fine_lattice.h).
/// Stops when the doubt is less than 0.4 of `error`, or the next level would take minutes. Functions
/// split by tissue need three levels.
///
/// The loads are taken as they are, so presses must be scaled first (ScalePresses). On a lattice of
/// 4 cells, finite strain may change the answer by more than half of `error`. That difference is
/// added if the scene asks for more than small strain; otherwise it becomes a remark. Throws
/// InputError.
ReferenceSolution MakeReferenceSolution(const OrganOptions& organ, const SurfaceMesh& rest,
                                        const OrganTouches& touches, double error,
                                        std::vector<std::string>* remarks);

/// Scales each press of one newton to the force of a hand's springs (`stiffness`, N/m) that aims
/// `depth` (m) into the tissue. The tissue's compliance comes from a coarse lattice.
void ScalePresses(const OrganOptions& organ, const SurfaceMesh& rest, double stiffness,
                  double depth, OrganTouches* touches);

}  // namespace hpdm
