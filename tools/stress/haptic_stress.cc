#include "tools/stress/stress_cases.h"

namespace hpdm {

std::vector<StressCase> HapticStress(bool /*quick*/) { return {}; }

}  // namespace hpdm
