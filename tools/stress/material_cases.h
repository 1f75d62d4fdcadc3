#pragma once

#include "tools/stress/stress_case.h"

/// Cases of the group "material".
namespace hpdm {

// Tissue (tissue_stress.cc).
StressCase NearlyIncompressible(bool quick);
StressCase StiffnessContrast(bool quick);
StressCase ThinWall(bool quick);
StressCase Slivers(bool quick);
StressCase NothingHolds(bool quick);

// Lattice (lattice_stress.cc) and unit of length (scale_stress.cc).
StressCase BernsteinDegree(bool quick);
StressCase LatticeAspect(bool quick);
StressCase Rescaled(bool quick);
StressCase LatticeRefinement(bool quick);
StressCase SurfaceRefinement(bool quick);

// Solvers (solver_stress.cc).
StressCase GaussSeidelSweeps(bool quick);
StressCase NewtonIterations(bool quick);
StressCase TimeStep(bool quick);

}  // namespace hpdm
