#pragma once

#include <vector>

#include "tools/stress/stress_case.h"

namespace hpdm {

/// Returns the cases of a group in the order of the table. `quick`: smaller bodies and shorter
/// motions with the same claims.
std::vector<StressCase> MaterialStress(bool quick);  ///< Tissue, lattice and solver, at rest.
std::vector<StressCase> ContactStress(bool quick);   ///< Rows of contacts, coincident and many.
std::vector<StressCase> MotionStress(bool quick);    ///< Tissue moved until it inverts.
std::vector<StressCase> HapticStress(bool quick);    ///< Tip, tick and device.
/// Energy and stillness of a touch. `random_seconds`: of the random motion.
std::vector<StressCase> TouchStress(bool quick, double random_seconds = 20);
std::vector<StressCase> OrganStress(bool quick);  ///< Organs on each other, and the shaft.
std::vector<StressCase> PartStress(bool quick);   ///< Attachments, ducts, layers, lumens.

}  // namespace hpdm
