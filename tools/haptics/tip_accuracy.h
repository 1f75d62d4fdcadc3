#pragma once

#include <string>

#include "tools/shared/static_case.h"

namespace hpdm {

/// What a hand would feel where the reference solution says how far its force moves the tissue.
struct TipAccuracy {
  std::string case_name;
  int local_functions = 0;
  double reference_force = 0;  ///< N, of the case's load.
  double force = 0;            ///< N, in the tick, along it.
};

/// The tick's force for the reference solution's displacement u under the tip, along the load: a
/// probe whose tip has the load's radius comes near the load's point, one deformation step makes
/// its patch, and the tick's law for a point that is carried along (lattice_reaction.h) gives C^-1
/// u with the patch's C. `load_case`: one force, small strain; with `local_functions` added at the
/// tip. Throws InputError when the case has no such load or the reference no displacement of it.
TipAccuracy MeasureTipAccuracy(const StaticCase& load_case, const CaseReference& reference,
                               int local_functions);

}  // namespace hpdm
