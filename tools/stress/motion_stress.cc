#include "tools/stress/stress_cases.h"

namespace hpdm {

std::vector<StressCase> MotionStress(bool /*quick*/) { return {}; }

}  // namespace hpdm
