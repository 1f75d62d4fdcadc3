#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/deformation_loop.h"
#include "haptics/haptic_loop.h"
#include "scenes/loader/scene.h"
#include "tools/session/lockstep.h"
#include "tools/stress/contact_energy.h"
#include "tools/stress/stress_case.h"
#include "tools/stress/viscous_energy.h"

namespace hpdm {

/// Pose of a hand's tool.
struct StressPose {
  Vector3d p_tip_W = Vector3d::Zero();  ///< m. If not finite, the device's reading is invalid.
  double roll = 0;                      ///< rad, about the shaft.
  double jaw = 1;                       ///< 0 closed .. 1 open.
};

/// Returns a motion straight from waypoint to waypoint (session time in s, ascending, and pose). It
/// rests before the first and after the last. Of two waypoints at one time the second counts from
/// that time. Needs at least one.
std::function<StressPose(double)> Through(std::vector<std::pair<double, StressPose>> waypoints);

/// A tool that follows its motion whatever it feels: session time (s) -> pose.
struct StressTool {
  std::function<StressPose(double)> motion;
  Vector3d p_trocar_W = Vector3d::Zero();  ///< m; at most 1 m from the motion, and 1 mm beside it
                                           ///< at least.
  ToolOptions tool = {};

  /// Makes a device that moves the tool instead of `motion`. Its kinematics about the trocar start
  /// at the beginning of `motion`. Absent: `motion` moves it.
  std::function<std::unique_ptr<Device>(const ImpulseEngineKinematics&)> device;
};

/// Returns the frame X_WT of a tool at session time `t` (s), by the device's kinematics.
Isometry3d ToolFrame(const StressTool& tool, double t);

/// Outcome of a motion, over everything that was run.
struct StressOutcome {
  // Tissue, after each step, with every quadrature point evaluated.
  double least_determinant = 1;     ///< det(F).
  double inverted_share = 0;        ///< Largest share (0..1) of the volume with det(F) <= 0.
  double largest_displacement = 0;  ///< m, any vertex at any time.
  double displacement = 0;          ///< m, the vertex farthest from rest, after the last step.
  double last_off_rest = 0;  ///< s: session time of the last step with a vertex beyond kAtRest.

  // Relaxation.
  std::uint32_t flags = 0;  ///< StepFlag, or-ed.
  int steps = 0;
  int unconverged_steps = 0;
  double largest_residual = 0;
  double tissue_force = 0;  ///< N: largest force of a step on the tissue at a tip.

  // Forces on the hands, in every tick. The reaction is the force before the guard.
  double reaction = 0;         ///< N: largest.
  double reaction_change = 0;  ///< Largest change in a tick over the slew limit. A tick in which
                               ///< the tool moves by more than kMostWay or the jaws let go does
                               ///< not count.
  double force = 0;            ///< N: largest displayed.
  double force_change = 0;     ///< Largest change of the displayed force in a tick over the limit.
  bool finite = true;  ///< True if vertices, patches' forces, reactions and displayed forces
                       ///< were always finite.

  static constexpr double kMostWay = 0.002;  ///< m in a tick: 2 m/s, faster than a hand.
};

/// Record of a run with one tool: the input of BalancesOf().
struct ContactRecord {
  std::vector<ContactTick> ticks;    ///< One a tick, from the first.
  std::vector<StoredEnergy> stored;  ///< One a step; of an organ with a stiffness.
};

/// Returns the harm to tissue or hand in a few words; empty if there is none. Harm is one of:
/// 1. A value that is not finite.
/// 2. A displayed force, or its change, beyond the guard's limits.
/// 3. Tissue not at rest a step and a tenth of a second after the tools left it at `released` (s;
///    infinite if they did not leave). Tissue that was inverted must only come to rest.
std::string Harm(const StressOutcome& outcome, double released);

/// Returns a fault that the guard hides, in a few words that have "before the guard"; empty if there
/// is none. It is a reaction beyond the guard's limit and above 1.5 times the largest force of the
/// organ in any step, or a change of the reaction beyond the limit, unless the tool jumped or its
/// jaws let go.
std::string FaultBeforeGuard(const StressOutcome& outcome);

/// Sets the trial's harm, and fails it for a fault before the guard.
void AddFaults(const StressOutcome& outcome, double released, StressTrial* trial);

/// One organ and tools that nothing stops, for cases at the limits of methods. Runs both production
/// loops in lockstep, as in a session, and records the tissue and the forces.
class StressSessionFixture {
 public:
  static constexpr double kAtRest = 1e-4;  ///< m.

  /// `rest`: posed, m. Throws InputError if the organ cannot be built. The tools' forces are on
  /// from the first tick and ramp in over half a second.
  StressSessionFixture(const OrganOptions& organ, SurfaceMesh rest, std::vector<StressTool> tools,
                       const TimingOptions& timing = {});
  ~StressSessionFixture();

  /// Runs until `seconds` of session time. `series`, if given, receives every tick of the first
  /// tool; so does `record`, which needs every tick from the start.
  void RunUntil(double seconds, std::vector<ToolSample>* series = nullptr,
                ContactRecord* record = nullptr);

  /// Sets the trainee's request from the next tick.
  void Ask(const SessionControl& asked);

  const StressOutcome& outcome() const { return outcome_; }
  const OrganModel& organ() const { return organs_[0]; }
  const OrganState& state() const { return deformation_->organ(0); }
  /// Results of the last step and of the last tick.
  const StepSample& step() const { return step_; }
  const HapticSample& tick() const { return tick_; }

 private:
  class Scripted;

  void MeasureStep();
  void MeasureTick();
  void RecordContact(ContactRecord* record);
  StoredEnergy EnergyAfterStep();

  TimingOptions timing_;
  std::vector<OrganModel> organs_;
  std::vector<std::unique_ptr<Device>> devices_;
  TripleBuffer<ToolState> tool_states_;
  TripleBuffer<ContactPatch> patches_;
  TripleBuffer<SceneSnapshot> render_;
  TripleBuffer<SceneSnapshot> telemetry_;
  TripleBuffer<SessionControl> control_;
  SpscQueue<StepSample> steps_{4};
  SpscQueue<HapticSample> ticks_{4};
  std::unique_ptr<DeformationLoop> deformation_;
  std::unique_ptr<HapticLoop> haptics_;
  std::unique_ptr<Lockstep> clock_;
  std::unique_ptr<ViscousEnergy> viscous_;  // of a recorded viscoelastic organ
  double slew_ = 0;                         // N per tick
  StepSample step_;
  HapticSample tick_;
  TickContactPoint place_;  // of the first tool in the last tick
  StressOutcome outcome_;
};

}  // namespace hpdm
