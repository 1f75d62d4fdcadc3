#include "tools/stress/material_cases.h"
#include "tools/stress/stress_cases.h"

namespace hpdm {

std::vector<StressCase> MaterialStress(bool quick) {
  std::vector<StressCase> cases;
  for (StressCase (*make)(bool) :
       {NearlyIncompressible, StiffnessContrast, ThinWall, Slivers, NothingHolds, BernsteinDegree,
        LatticeAspect, Rescaled, LatticeRefinement, SurfaceRefinement, GaussSeidelSweeps,
        NewtonIterations, TimeStep}) {
    cases.push_back(make(quick));
    cases.back().group = "material";
  }
  return cases;
}

}  // namespace hpdm
