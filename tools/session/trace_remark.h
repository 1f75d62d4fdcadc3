#pragma once

#include <string>

#include "haptics/device/trace_device.h"

namespace hpdm {

/// Throws InputError if the tips of a trace lie more than 2 m apart, which no hand reaches: the
/// file is most likely in millimetres. `scale`: m per unit of the file.
void RefuseWrongScale(const TraceFile& file, const TraceMotion& motion, double scale);

/// Describes the playback of a trace in one line. `fitted`: the scene gives the file's origin no
/// position.
std::string TraceRemark(const TraceFile& file, const TraceMotion& motion,
                        const TraceMapping& mapping, const TraceDevice& device, bool fitted);

}  // namespace hpdm
