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
#include "tools/session/burn_tone.h"
#include "tools/session/control_script.h"
#include "tools/session/run_summary.h"
#include "tools/session/session.h"
#include "tools/session/stop_signals.h"
#include "tools/session/teacher_desk.h"
#include "tools/session/trainer_window.h"

namespace hpdm {

/// Real-time state that the machine grants, and the wake-up delays of an empty loop at the haptic
/// rate.
struct MachineState {
  RealtimeReport process, haptic;
  WakeUpBaseline baseline;

  /// Returns the first refusal, or an empty string.
  std::string Refusal() const {
    return process.Complete() ? haptic.FirstRefusal() : process.FirstRefusal();
  }
};

/// Requests the real-time state of a session and, unless `lockstep`, runs an empty loop at the
/// haptic rate for a second. Call it before the session starts. Throws MachineError if a request
/// was refused and `require_realtime` is set.
MachineState ProbeRealtime(bool lockstep, bool require_realtime, Nanoseconds period_ns);

/// The loops of one session and their surroundings.
struct Loops {
  Session& session;
  HapticLoop& haptics;
  DeformationLoop& deformation;
  RenderLoop& render;
  TelemetryLoop& telemetry;
  DeviceLink* link;  ///< Null without external devices.
  const StopSignals& signals;
  std::uint64_t end_tick;
  bool pictures;                   ///< False: the render loop never starts.
  TrainerWindow* window;           ///< Null without a window.
  ControlScript* exchanges;        ///< From the command line.
  TeacherDesk* teacher = nullptr;  ///< Null unless the session listens to a teacher.
  BurnTone* tone = nullptr;        ///< Null: no sound.
};

/// Runs the loops on the real clock, one thread per loop:
///
///     device -> haptic (1 kHz) --ToolState--> deformation (30 Hz) --SceneSnapshot--> render
///        ^        | |  ^-------ContactPatch-------'     |     |                       |   ^
///        '-effort-' |                 StepSample queue  |     | SceneSnapshot         |   |
///                   |                                   v     v                       |   |
///                   '---HapticSample queue--------> telemetry <-FrameRecord, LoopEvent'   |
///                                                    |     '----------SessionHealth-------'
///                                                    '--> log, LCM
///
/// FrameRecord and LoopEvent are queues too; the other edges keep the latest value. The main thread
/// handles the window's input, as the window library requires. Without a window it publishes the
/// exchanges of the command line:
///
///     window --HandTarget, SessionControl--> haptic;   window --ViewSettings--> render
///
/// It handles a teacher's requests too (teacher_desk.h). External devices have a link of two threads:
///
///     HPDM_DEVICE --> link --DeviceSample--> device;   link --LoopEvent queue--> telemetry
///     HPDM_FORCE <--- link <--HapticSample queue, every tick-- haptic
///
/// The haptic and the deformation loop start together, once both have requested their real-time
/// state and the render thread has compiled its shaders. The haptic thread ends the session at its
/// last tick. At the end the haptic loop stops first and ramps its forces to zero; then the
/// devices' forces are switched off. The telemetry ends after the loops and the link last, so that
/// they drain everything. A crash switches the forces off at once (crash_stop.h).
RunRecord RunOnRealClock(const Loops& loops, const MachineState& machine,
                         const SessionClock& clock);

/// Runs the loops on the lockstep clock: one thread, virtual time.
RunRecord RunInLockstep(const Loops& loops);

}  // namespace hpdm
