#pragma once

#include "engine/energy/mixed_dilatation.h"
#include "engine/solver/compliance_solver.h"
#include "engine/solver/refinement_basis.h"
#include "engine/tissue/interior.h"
#include "tests/support/shapes.h"

namespace hpdm {

inline constexpr int kRefinement = 2;

/// An ellipsoid in a lattice of 3 x 3 x 3 cells, held by springs everywhere (so that no region
/// excludes functions).
struct LatticeBody {
  explicit LatticeBody(double poisson)
      : material{.young = 5000, .poisson = poisson},
        mesh(Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2)),
        lattice(BoundingLatticeBox(mesh.vertices, Matrix3d::Identity(), 0.01), Options()) {
    const TissueQuadrature sampled =
        SampleTissue(mesh, lattice.box(), {6, 6, 6}, {.resolution = 48});
    tissue = {sampled.points, sampled.weights};
    lattice.DropControlPointsWithoutTissue(tissue);
    K = StrainStiffness(lattice, tissue, material, Dilatation::kProjected);
    const WeightMatrix weights = lattice.Weights(tissue.points);
    springs = 1e6 * weights.transpose() * tissue.weights.asDiagonal() * weights;
    AddAlongEachAxis(springs, &K);
  }

  static LatticeOptions Options() {
    LatticeOptions options;
    options.cells = {3, 3, 3};
    return options;
  }

  RefinementBasis Local() const {
    return RefinementBasis(lattice, {.functions = 20, .refinement = kRefinement}, tissue, material,
                           Dilatation::kProjected, {}, K);
  }

  MaterialOptions material;
  SurfaceMesh mesh;
  Lattice lattice;
  Quadrature tissue;
  ScalarStiffness springs;
  FullStiffness K;
};

}  // namespace hpdm
