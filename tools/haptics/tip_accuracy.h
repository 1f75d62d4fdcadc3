#pragma once

#include <string>

#include "tools/shared/static_case.h"

namespace hpdm {

/// Force that a hand would feel at a displacement that the reference solution gives.
struct TipAccuracy {
  std::string case_name;
  int local_functions = 0;
  double reference_force = 0;  ///< N, the case's load.
  double force = 0;            ///< N, of the tick, along the load.
};

/// Returns the tick's force along the load for the reference solution's displacement u under the
/// tip.
/// 1. A probe whose tip has the load's radius comes near the load's point.
/// 2. One deformation step makes its patch.
/// 3. The tick's law for a point that moves with the tissue (lattice_reaction.h) gives C^-1 u, with
///    the patch's C.
///
/// `load_case` has one force and small strain; `local_functions` are added at the tip. Throws
/// InputError if the case has no such load or the reference no displacement for it.
TipAccuracy MeasureTipAccuracy(const StaticCase& load_case, const CaseReference& reference,
                               int local_functions);

}  // namespace hpdm
