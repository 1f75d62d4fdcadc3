#pragma once

#include <string_view>
#include <utility>

#include "haptics/device/instrument_options.h"

namespace hpdm {

/// Names of the instrument types in scene files and reports.
inline constexpr std::pair<std::string_view, InstrumentType> kInstrumentTypes[] = {
    {"probe", InstrumentType::kProbe},
    {"grasper", InstrumentType::kGrasper},
    {"scissors", InstrumentType::kScissors},
    {"hook", InstrumentType::kHook},
    {"clip_applier", InstrumentType::kClipApplier},
    {"suction", InstrumentType::kSuction}};

}  // namespace hpdm
