#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/threads/triple_buffer.h"
#include "haptics/device/device.h"
#include "haptics/device/mouse_hand.h"
#include "haptics/device/trace_file.h"
#include "tools/session/device_choice.h"
#include "tools/session/session_model.h"

namespace hpdm {

/// A device that moves an instrument, with its edges to other threads.
struct SessionDevice {
  std::unique_ptr<Device> device;
  TripleBuffer<DeviceSample>* readings = nullptr;    ///< Of an external driver, else null.
  TripleBuffer<HandTarget>* hand_targets = nullptr;  ///< Of a mouse, else null.
  Nanoseconds duration = 0;                          ///< Of a trace, else 0.
  std::string remark;                                ///< One line for the user, or empty.
};

/// Returns the trace that each device plays, without rows if it plays none. Throws InputError.
std::vector<TraceFile> ReadTraces(const std::vector<DeviceChoice>& choices);

/// Makes the chosen device of an instrument of `model`; `trace`: from ReadTraces(). `seed`
/// replaces that of a simulated hand unless it is 0. Throws InputError.
SessionDevice MakeSessionDevice(const SessionModel& model, std::size_t instrument,
                                const DeviceChoice& choice, const TraceFile& trace,
                                std::uint32_t seed = 0);

}  // namespace hpdm
