#pragma once

#include <vector>

#include "tools/stress/stress_case.h"

/// The parts of the group "haptics" (stress_cases.h).
namespace hpdm {

std::vector<StressCase> TipEntryStress(bool quick);  ///< How a tip comes into the organ and out.
std::vector<StressCase> TipSlideStress(bool quick);  ///< A tip and a surface that move past.
std::vector<StressCase> DeviceStress(bool quick);    ///< What a device reads, and displays.

/// The point proxy too, which takes a surface that does not deform.
inline const std::vector<StressModel> kTouchModels = {
    StressModel::kStrainSmall,  StressModel::kStrainFinite, StressModel::kMetricSmall,
    StressModel::kMetricFinite, StressModel::kContinuum,    StressModel::kMassSpring,
    StressModel::kPointProxy};

/// All that run through both loops.
inline const std::vector<StressModel> kFeltModels = {
    StressModel::kStrainSmall,  StressModel::kStrainFinite, StressModel::kMetricSmall,
    StressModel::kMetricFinite, StressModel::kContinuum,    StressModel::kMassSpring};

}  // namespace hpdm
