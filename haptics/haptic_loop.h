#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <stop_token>
#include <vector>

#include "engine/snapshots.h"
#include "engine/step/tool_geometry.h"
#include "engine/threads/loop_schedule.h"
#include "engine/threads/spsc_queue.h"
#include "engine/threads/triple_buffer.h"
#include "haptics/contact/haptic_contact.h"
#include "haptics/device/device.h"
#include "haptics/device/impulse_engine.h"
#include "haptics/safety/force_guard.h"
#include "haptics/safety/passivity.h"

namespace hpdm {

/// One instrument as the haptic loop needs it.
struct HapticInstrument {
  Device* device = nullptr;  ///< Not owned; outlives the loop, which owns its use while it runs.
  ImpulseEngineKinematics kinematics;
  double tip_radius = kDefaultToolRadius;  ///< m.
  ForceGuardOptions guard = {};
  double friction = 0;  ///< Coulomb coefficient of the tip on tissue.
  PassivityOptions passivity = {};
  std::vector<ToolGeometry> exchanges = {};  ///< What else the hand can hold:
                                             ///< ToolPose::instrument_index 1 on.
};

/// The loop between hand and tissue, 1 kHz: see the stages of Tick.
///
///     device --> [haptic loop] --ToolState--> deformation loop
///       ^             |  ^------ContactPatch------'
///       '---effort----'  '--HapticSample, every tick--> telemetry loop, link of external devices
///
/// An exchange of instruments that SessionControl asks for is made in the first tick that finds the
/// tip free (it touches and holds nothing); another than the hand has is ignored. From that tick on
/// the new tip's radius and friction hold, patches made for the old one are not used, and the force
/// ramps in. While the session is paused the devices are not read, the last pose stands without
/// velocity, and the force fades out; afterwards it ramps in.
///
/// A session ends with the ramp-out: after the last tick each force falls linearly to zero, so that
/// no device keeps the last one. Its ticks read the devices and write efforts. They are not part of
/// the session: the link gets their samples, but telemetry and the deformation loop get nothing of
/// them, so a log ends with the last tick and a replay needs no ramp-out.
///
/// Built on the main thread. Tick, RampOut and RunRealClock belong to one thread, the haptic thread
/// (or the only one, in lockstep); a tick is wait-free, with no allocation, lock, log, exception or
/// system call but the clock's and the device's. A full sample queue loses the sample and counts it
/// (SpscQueue::Overflows).
class HapticLoop {
 public:
  /// What the loop is wired to: writer of tool_states, reader of patches, producer of samples and,
  /// where devices are driven from outside, of the same for their link; reader of what the trainee
  /// asks, where someone does.
  struct Edges {
    TripleBuffer<ToolState>& tool_states;
    TripleBuffer<ContactPatch>& patches;
    SpscQueue<HapticSample>& samples;
    SpscQueue<HapticSample>* link = nullptr;
    TripleBuffer<SessionControl>* control = nullptr;
  };

  /// At most kMaxInstruments, in the order of the tools in every snapshot. period_ns > 0.
  HapticLoop(std::vector<HapticInstrument> instruments, Nanoseconds period_ns, const Edges& edges);

  /// One tick: number of its period, scheduled session time, and what is known of its timing. The
  /// sample pushed at the end carries this tick's own wake-up lateness and compute time (up to the
  /// push itself).
  void Tick(std::uint64_t tick, Nanoseconds scheduled, const TickTiming& timing) noexcept;

  /// From the request for a stop to no force: at most one more tick, then the ramp-out. At a period
  /// longer than half of this the force ends with the period after the last tick.
  static constexpr Nanoseconds kStopTime = 16'000'000;

  /// Ticks of the ramp-out, at least 1.
  std::uint64_t RampOutTicks() const;

  /// One tick of the ramp-out, numbered and timed as Tick. `left`: how many follow it, from
  /// RampOutTicks() - 1 down to 0, which leaves no force.
  void RampOut(std::uint64_t tick, Nanoseconds scheduled, const TickTiming& timing,
               std::uint64_t left) noexcept;

  /// Ticks on the real clock from start_ns (session time of tick 0) until `stop` or end_tick, then
  /// ramps out. Every device's last effort is zero when this returns. The count is that of the
  /// ticks before the ramp-out.
  TickCount RunRealClock(std::stop_token stop, LoopClock& clock, Nanoseconds start_ns,
                         std::uint64_t end_tick = std::numeric_limits<std::uint64_t>::max());

  /// Takes every device's force away at once, without a ramp (Device::EmergencyStop). Any thread or
  /// signal handler; wait-free.
  void EmergencyStop() noexcept;

 private:
  // One instrument's state through the stages of a tick.
  struct Tool {
    Tool(const HapticInstrument& given, double period)
        : instrument(given),
          geometries{{.tip_radius = given.tip_radius, .friction = given.friction}},
          contact(period),
          passivity(given.passivity),
          guard(given.guard) {
      geometries.insert(geometries.end(), given.exchanges.begin(), given.exchanges.end());
    }
    const ToolGeometry& Geometry() const {
      return geometries[static_cast<std::size_t>(pose.instrument_index)];
    }

    HapticInstrument instrument;
    std::vector<ToolGeometry> geometries;  // [ToolPose::instrument_index]
    HapticContact contact;
    PassivityControl passivity;
    ForceGuard guard;
    DeviceSample sample;       // newest valid joints, valid as of this tick
    bool has_pose = false;     // false before the first valid sample
    Nanoseconds moved_ns = 0;  // device time of `pose`
    ToolPose pose;
    Matrix3d J = Matrix3d::Zero();
    Vector3d damping_force_W = Vector3d::Zero();
    bool force_on = false;  // read once a tick: a stop may come between two readings
    ForceGuard::Output safe;
    AxisEffort effort = AxisEffort::Zero();
  };

  void ApplyControl();
  void ReadDevices(Nanoseconds now);
  void MoveTools(Nanoseconds now);
  void TakePatch(Nanoseconds scheduled);
  void EvaluateContacts(Nanoseconds scheduled);
  void DampContacts(Nanoseconds now);
  void GuardForces(Nanoseconds scheduled);
  void WriteEfforts();
  void ObserveEnergy();
  void PublishToolState(std::uint64_t tick, Nanoseconds scheduled);
  void RampOutOnRealClock(LoopClock& clock, Nanoseconds start_ns, std::uint64_t first_tick);
  void FillSample(std::uint64_t tick, Nanoseconds scheduled, const TickTiming& timing);
  void PushToLink();

  std::vector<Tool> tools_;
  Nanoseconds period_ns_;
  Edges edges_;
  bool paused_ = false;
  bool has_run_ = false;
  Nanoseconds last_scheduled_ns_ = 0;
  Nanoseconds device_time_ns_ = 0;  // of the newest valid device sample
  std::uint64_t patch_number_ = 0;  // 0 before the first patch
  Nanoseconds patch_age_ns_ = 0;
  HapticSample sample_;
};

}  // namespace hpdm
