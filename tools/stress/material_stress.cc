#include "tools/stress/stress_cases.h"

namespace hpdm {

std::vector<StressCase> MaterialStress(bool /*quick*/) { return {}; }

}  // namespace hpdm
