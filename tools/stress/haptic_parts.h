#pragma once

#include <vector>

#include "tools/stress/stress_case.h"

/// Parts of the group "haptics" (stress_cases.h).
namespace hpdm {

std::vector<StressCase> TipEntryStress(bool quick);  ///< Entry of a tip into the organ, and its
                                                     ///< exit.
std::vector<StressCase> TipSlideStress(bool quick);  ///< A tip and a surface that slide past each
                                                     ///< other.
std::vector<StressCase> DeviceStress(bool quick);    ///< Readings of a device, and its force
                                                     ///< display.

/// Models including the point proxy, which uses an undeformed surface.
inline const std::vector<StressModel> kTouchModels = {
    StressModel::kStrainSmall,  StressModel::kStrainFinite, StressModel::kMetricSmall,
    StressModel::kMetricFinite, StressModel::kContinuum,    StressModel::kMassSpring,
    StressModel::kPointProxy};

/// Models that run through both loops.
inline const std::vector<StressModel> kFeltModels = {
    StressModel::kStrainSmall,  StressModel::kStrainFinite, StressModel::kMetricSmall,
    StressModel::kMetricFinite, StressModel::kContinuum,    StressModel::kMassSpring};

}  // namespace hpdm
