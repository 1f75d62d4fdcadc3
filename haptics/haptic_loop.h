#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "engine/base/copying.h"
#include "engine/snapshots.h"
#include "engine/step/tool_geometry.h"
#include "engine/threads/loop_schedule.h"
#include "engine/threads/spsc_queue.h"
#include "engine/threads/triple_buffer.h"
#include "haptics/contact/tip_contacts.h"
#include "haptics/contact/trocar_friction.h"
#include "haptics/device/device.h"
#include "haptics/device/impulse_engine.h"
#include "haptics/safety/energy_tank.h"
#include "haptics/safety/force_guard.h"
#include "haptics/safety/passivity.h"

namespace hpdm {

/// One instrument's data for the haptic loop.
struct HapticInstrument {
  Device* device = nullptr;  ///< Not owned; outlives the loop, which owns its use while it runs.
  ImpulseEngineKinematics kinematics;
  std::vector<ToolGeometry> geometries = {ToolGeometry()};  ///< [ToolPose::instrument_index]
  ForceGuardOptions guard = {};
  PassivityOptions passivity = {};
  TrocarFrictionOptions trocar_friction = {};
};

/// The 1 kHz loop between hand and tissue; Tick lists its stages.
///
///     device --> [haptic loop] --ToolState--> deformation loop
///       ^             |  ^------ContactPatch------'
///       '---effort----'  '--HapticSample, every tick--> telemetry loop, link of external devices
///
/// Exchange of instruments: SessionControl's request takes effect in the first tick with a free tip
/// (it touches and holds nothing). A request for an instrument that the hand does not have is
/// ignored. The tick switches to the new tip's radius and friction, ignores patches for the old
/// one, and ramps the force in.
///
/// Pedal: pressed while the device's button or SessionControl's is. Off without a valid reading of the
/// last kHeldAfter, and in a pause.
///
/// Restart (RestartRequest): in its tick all tools lose their contacts, whose forces fall within the slew limit.
/// Patches of steps that do not know of it are ignored. Then the forces ramp in.
///
/// Pause: the devices are not read, the last pose is held without velocity, and the force fades
/// out; afterwards it ramps in.
///
/// End: after the last tick each force falls linearly to zero, so that no device keeps it. These
/// ramp-out ticks read the devices and write efforts. Only the link gets their samples, not
/// telemetry or the deformation loop: a log ends with the last tick, and a replay needs no
/// ramp-out.
///
/// Built on the main thread. Tick, RampOut and RunRealClock belong to one thread, the haptic thread
/// (or the only one, in lockstep). A tick is wait-free: no allocation, lock, log or exception, and
/// only the clock's and the device's system calls. A full sample queue loses the sample and counts
/// it (SpscQueue::Overflows).
class HapticLoop {
 public:
  /// The loop's channels (snapshots.h).
  struct Edges {
    TripleBuffer<ToolState>& tool_states;             ///< Written.
    TripleBuffer<ContactPatch>& patches;              ///< Read.
    SpscQueue<HapticSample>& samples;                 ///< Produced, for the telemetry loop.
    SpscQueue<HapticSample>* link = nullptr;          ///< Produced, for external drivers.
    TripleBuffer<SessionControl>* control = nullptr;  ///< Read: the trainee's requests.
  };

  /// At most kMaxInstruments, in the order of the tools in every snapshot. period_ns > 0.
  HapticLoop(std::vector<HapticInstrument> instruments, Nanoseconds period_ns, const Edges& edges);

  /// A copy continues from the same state to the last bit, once it is attached.
  HapticLoop(const HapticLoop&) = default;
  HapticLoop& operator=(const HapticLoop&) = default;
  /// Gives a copy devices and edges of its own, which hold copies of what the original's hold: the
  /// devices' states and the newest patch.
  void Attach(std::span<const std::unique_ptr<Device>> devices, const Edges& edges);

  /// Runs one tick, given the number of its period, its scheduled session time and its timing. The
  /// sample pushed at the end contains this tick's own wake-up lateness and compute time (up to the
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

  /// The contacts of instrument number `tool` in the last tick.
  const TipContacts& contacts(std::size_t tool) const { return tools_[tool].contacts; }

  /// Takes every device's force away at once, without a ramp (Device::EmergencyStop). Any thread or
  /// signal handler; wait-free.
  void EmergencyStop() noexcept;

 private:
  // One instrument's state in the stages of a tick.
  struct Tool {
    Tool(const HapticInstrument& given, double period)
        : instrument(given),
          contacts(period),
          trocar_friction(given.trocar_friction, given.passivity),
          passivity(given.passivity),
          guard(given.guard) {}
    const ToolGeometry& Geometry() const {
      return instrument.geometries[static_cast<std::size_t>(pose.instrument_index)];
    }

    HapticInstrument instrument;
    TipContacts contacts;
    TrocarFriction trocar_friction;
    PassivityControl passivity;
    ForceGuard guard;
    DeviceSample sample;       // newest valid joints, valid as of this tick
    bool has_pose = false;     // false before the first valid sample
    bool pedal_asked = false;  // SessionControl::pedal
    Nanoseconds moved_ns = 0;  // device time of `pose`
    ToolPose pose;
    Isometry3d X_WC = Isometry3d::Identity();  // pose in which the jaws closed, or the present one
    Matrix3d J = Matrix3d::Zero();
    Vector3d reaction_W = Vector3d::Zero();  // of the contacts, with what the tank leaves of tissue
    Vector3d damping_force_W = Vector3d::Zero();
    bool force_on = false;  // read once a tick: a stop may come between two readings
    ForceGuard::Output safe;
    AxisEffort effort = AxisEffort::Zero();
  };

  void ApplyControl(std::uint64_t tick);
  void Restart(const RestartRequest& request, std::uint64_t tick);
  void ReadDevices(Nanoseconds now);
  void MoveTools(Nanoseconds now);
  void TakePatch(Nanoseconds scheduled);
  void EvaluateContacts(Nanoseconds scheduled);
  Vector3d TrocarForce(Tool* tool) const;
  void LimitTissue();
  void DampContacts(Nanoseconds now);
  void GuardForces(Nanoseconds scheduled);
  void WriteEfforts();
  void ObserveEnergy();
  void PublishToolState(std::uint64_t tick, Nanoseconds scheduled);
  void RampOutOnRealClock(LoopClock& clock, Nanoseconds start_ns, std::uint64_t first_tick);
  void FillSample(std::uint64_t tick, Nanoseconds scheduled, const TickTiming& timing);
  void PushToLink();

  std::vector<Tool> tools_;
  EnergyTank tank_;
  double tank_takes_ = 0;  // share of soft tissue's force, in this tick
  Nanoseconds period_ns_;
  Rebindable<Edges> edges_;
  bool paused_ = false;
  RestartRequest restart_;          // the newest one
  std::uint64_t restart_tick_ = 0;  // in which it came
  bool has_run_ = false;
  Nanoseconds last_scheduled_ns_ = 0;
  Nanoseconds device_time_ns_ = 0;  // time of the newest valid device sample
  std::uint64_t patch_number_ = 0;  // 0 before the first patch
  Nanoseconds patch_age_ns_ = 0;
  HapticSample sample_;
};

}  // namespace hpdm
