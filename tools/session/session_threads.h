#pragma once

#include <cstdint>
#include <string>

#include "engine/threads/realtime.h"
#include "engine/threads/session_clock.h"
#include "engine/threads/wake_up_baseline.h"
#include "haptics/haptic_loop.h"
#include "lcmtypes/live/device_link.h"
#include "lcmtypes/telemetry/telemetry_loop.h"
#include "render/render_loop.h"
#include "tools/session/control_script.h"
#include "tools/session/run_summary.h"
#include "tools/session/session.h"
#include "tools/session/stop_signals.h"
#include "tools/session/trainer_window.h"

namespace hpdm {

/// What the machine grants, and how late it wakes a thread like the haptic one that does nothing.
struct MachineState {
  RealtimeReport process, haptic;
  WakeUpBaseline baseline;

  /// The first refusal, or empty.
  std::string Refusal() const {
    return process.Complete() ? haptic.FirstRefusal() : process.FirstRefusal();
  }
};

/// Asks for what a session would and wakes at its haptic rate for a second (not for the lockstep
/// clock), before anything else of it runs or a device displays a force. Throws MachineError where
/// something was refused and required.
MachineState ProbeRealtime(bool lockstep, bool require_realtime, Nanoseconds period_ns);

/// The loops of one session and what they need to run.
struct Loops {
  Session& session;
  HapticLoop& haptics;
  DeformationLoop& deformation;
  RenderLoop& render;
  TelemetryLoop& telemetry;
  DeviceLink* link;  ///< Null without external devices.
  const StopSignals& signals;
  std::uint64_t end_tick;
  bool pictures;             ///< False: the render loop never starts.
  TrainerWindow* window;     ///< Null without one.
  ControlScript* exchanges;  ///< Asked for on the command line.
};

/// The real clock, one thread a loop:
///
///     device -> haptic (1 kHz) --ToolState--> deformation (30 Hz) --SceneSnapshot--> render
///        ^        | |  ^-------ContactPatch-------'     |     |                       |   ^
///        '-effort-' |                 StepSample queue  |     | SceneSnapshot         |   |
///                   |                                   v     v                       |   |
///                   '---HapticSample queue--------> telemetry <-FrameRecord, LoopEvent'   |
///                                                    |     '----------SessionHealth-------'
///                                                    '--> log, LCM
///
/// FrameRecord and LoopEvent are queues too; the other edges keep the latest value. With a window
/// the main thread takes its input, where the window library wants it:
///
///     window --HandTarget, SessionControl--> haptic;   window --ViewSettings--> render
///
/// Without one it passes on the exchanges that the command line asked for.
///
/// External devices have a link of two threads:
///
///     HPDM_DEVICE --> link --DeviceSample--> device
///     HPDM_FORCE <--- link <--HapticSample queue, every tick-- haptic
///
/// The two loops with a deadline start together, once each has asked for its real-time state and
/// the render thread has its shaders. The haptic thread ends the session at its last tick. At the
/// end the haptic loop stops first and ramps its forces to zero, then the devices' forces are
/// switched off. The telemetry ends after the loops, and the links last, so that they drain
/// everything. A crash switches the forces off at once (crash_stop.h).
RunRecord RunOnRealClock(const Loops& loops, const MachineState& machine,
                         const SessionClock& clock);

/// The lockstep clock: one thread, virtual time.
RunRecord RunInLockstep(const Loops& loops);

}  // namespace hpdm
