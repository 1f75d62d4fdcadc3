#include "tools/stress/stress_cases.h"

namespace hpdm {

std::vector<StressCase> ContactStress(bool /*quick*/) { return {}; }

}  // namespace hpdm
