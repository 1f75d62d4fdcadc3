#include <iterator>
#include <utility>

#include "tools/stress/haptic_parts.h"
#include "tools/stress/stress_cases.h"

namespace hpdm {

std::vector<StressCase> HapticStress(bool quick) {
  std::vector<StressCase> all;
  for (std::vector<StressCase> part :
       {TipEntryStress(quick), TipSlideStress(quick), DeviceStress(quick)}) {
    std::move(part.begin(), part.end(), std::back_inserter(all));
  }
  for (StressCase& each : all) {
    each.group = "haptics";
    if (each.models.empty()) each.models = kFeltModels;
  }
  return all;
}

}  // namespace hpdm
