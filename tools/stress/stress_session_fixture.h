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

namespace hpdm {

/// Where a hand has its tool.
struct StressPose {
  Vector3d p_tip_W = Vector3d::Zero();  ///< m. Not finite: the device's reading fails so.
  double roll = 0;                      ///< rad, about the shaft.
  double jaw = 1;                       ///< 0 closed .. 1 open.
};

/// Straight from waypoint to waypoint (session time in s, ascending, and pose), at rest before the
/// first and after the last; of two at one time the second counts from it on. Needs one.
std::function<StressPose(double)> Through(std::vector<std::pair<double, StressPose>> waypoints);

/// A tool that goes its way whatever it feels: session time (s) -> pose.
struct StressTool {
  std::function<StressPose(double)> motion;
  Vector3d p_trocar_W = Vector3d::Zero();  ///< m; within 1 m of all of the way, 1 mm beside it.
  ToolOptions tool = {};
  double friction = 0;  ///< Coulomb coefficient.

  /// Who moves the tool instead, with kinematics about the trocar that start at the motion's own
  /// beginning; absent: nothing but `motion`.
  std::function<std::unique_ptr<Device>(const ImpulseEngineKinematics&)> device;
};

/// What came of it, over all that was run.
struct StressOutcome {
  // Of the tissue, after each step; every quadrature point evaluated.
  double least_determinant = 1;     ///< det(F).
  double inverted_share = 0;        ///< Largest share (0..1) of the volume with det(F) <= 0.
  double largest_displacement = 0;  ///< m, of a vertex, any time.
  double displacement = 0;          ///< m, of the vertex farthest from rest, after the last step.
  double last_off_rest = 0;  ///< s: session time of the last step that had a vertex kAtRest away.

  // Of the relaxation.
  std::uint32_t flags = 0;  ///< StepFlag, or-ed.
  int steps = 0;
  int unconverged_steps = 0;
  double largest_residual = 0;
  double tissue_force = 0;  ///< N: largest on the tissue at a tip, as a step had it.

  // Of what the hands felt; every tick.
  double reaction = 0;  ///< N: largest before the guard.
  double force = 0;     ///< N: largest displayed.
  double force_change =
      0;               ///< Largest change of the displayed force in a tick over the slew limit.
  bool finite = true;  ///< Vertices, patches' forces and displayed forces, always.
};

/// What no tool may do to tissue or hand, in a few words: values that are not finite, a displayed
/// force or its change beyond the guard's limits, or tissue that is not back at rest a tenth of a
/// second and a step after the tools left it at `released` (s; infinite: they did not). Empty:
/// none.
std::string Harm(const StressOutcome& outcome, double released);

/// One organ and tools that nothing stops, for cases that go where methods break: both production
/// loops in lockstep, as in a session, and a record of what became of tissue and forces.
class StressSessionFixture {
 public:
  static constexpr double kAtRest = 1e-4;  ///< m.

  /// `rest`: posed, m. Throws InputError when the organ cannot be built. The tools' forces are on
  /// from the first tick and ramp in over half a second.
  StressSessionFixture(const OrganOptions& organ, SurfaceMesh rest, std::vector<StressTool> tools,
                       const TimingOptions& timing = {});
  ~StressSessionFixture();

  /// Goes on until `seconds` of session time. `series`: gets every tick of the first tool, if
  /// given.
  void RunUntil(double seconds, std::vector<ToolSample>* series = nullptr);

  /// What the trainee asks, from the next tick on.
  void Ask(const SessionControl& asked);

  const StressOutcome& outcome() const { return outcome_; }
  const OrganModel& organ() const { return organs_[0]; }
  const OrganState& state() const { return deformation_->organ(0); }
  /// Of the last step; of the last tick.
  const StepSample& step() const { return step_; }
  const HapticSample& tick() const { return tick_; }

 private:
  class Scripted;

  void MeasureStep();
  void MeasureTick();

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
  double slew_ = 0;  // N, in a tick
  StepSample step_;
  HapticSample tick_;
  StressOutcome outcome_;
};

}  // namespace hpdm
