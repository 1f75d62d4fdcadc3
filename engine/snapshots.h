#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "engine/attachment/attachment_outcome.h"
#include "engine/base/types.h"
#include "engine/contact_patch.h"
#include "engine/duct/duct_outcome.h"
#include "engine/exercise/clip_finding.h"
#include "engine/scene_limits.h"
#include "engine/step/smoke.h"
#include "engine/tissue/lumen_outcome.h"

/// Values that the threads exchange. The types of this file cross exactly these edges:
///
///     device -> haptic loop --ToolState--> deformation loop --SceneSnapshot--> render loop
///                 |   ^------ContactPatch-----'     |     |                       |    ^
///                 |               StepSample queue  |     | SceneSnapshot         |    |
///                 |                                 v     v                       |    |
///                 '---HapticSample queue------> telemetry loop <-FrameRecord queue'    |
///                                                      '----------SessionHealth--------'
///
///     main thread (window, exchanges of the command line) --SessionControl--> haptic loop
///     telemetry loop (exercise) --ExerciseProgress--> deformation loop
///     link of external drivers --DeviceSample--> haptic loop --HapticSample queue--> the same link
///
/// A queue keeps every item (SpscQueue): one HapticSample a tick, one StepSample a step, one
/// FrameRecord a picture. The other edges keep the latest value (TripleBuffer). Everything but
/// SceneSnapshot has a fixed size, so writing one in place allocates nothing. The arrays of a
/// SceneSnapshot are sized before the threads start. engine/README.md, section 8, also lists the
/// edges of types from other headers: LoopEvent, HandTarget and ViewSettings.
namespace hpdm {

/// The five tracked axes of a laparoscopic device about its trocar:
/// pitch (rad), yaw (rad), insertion (m), roll (rad), jaw (0 closed .. 1 open).
using JointVector = Eigen::Matrix<double, 5, 1>;
enum Joint { kPitch = 0, kYaw = 1, kInsertion = 2, kRoll = 3, kJaw = 4 };

/// Efforts on the three actuated axes: pitch (N m), yaw (N m), insertion (N).
using AxisEffort = Vector3d;

/// One reading of one device. Haptic thread only, or device driver -> haptic loop.
struct DeviceSample {
  std::uint64_t sequence = 0;  ///< Rises by one with every new reading of the device.
  Nanoseconds time_ns = 0;     ///< When the reading was taken.
  JointVector joints = JointVector::Zero();
  bool valid = false;  ///< False without a usable answer; `joints` then is the last pose.
  bool pedal = false;  ///< The device's button, if it has one, is pressed.
};

/// Pose of one instrument in the world.
struct ToolPose {
  Isometry3d X_WT = Isometry3d::Identity();  ///< Tool frame: origin at the tip, z from the tip to
                                             ///< the trocar (along the shaft), y the jaw's axis.
  Vector3d p_trocar_W = Vector3d::Zero();    ///< m; fixed.
  Vector3d v_tip_W = Vector3d::Zero();       ///< m/s, filtered.
  double jaw = 1;                            ///< 0 closed .. 1 open.
  /// Pose of the tool in the tick in which its jaws closed (kJawGrasps), in its present frame; the
  /// identity while they are open.
  Isometry3d X_TC = Isometry3d::Identity();
  int instrument_index = 0;  ///< Instrument in the hand: 0 the first, then its exchanges in order.
  /// The pedal is pressed, at the device or by SessionControl, and the device's last reading is not
  /// older than kHeldAfter (device.h). It energises a hook.
  bool pedal = false;
};

/// A request to restart the exercise at one of its steps (engine/checkpoints.h).
struct RestartRequest {
  int count = 0;  ///< Rises with each request.
  int step = 0;   ///< From 0, one that has begun; or kPresent, and the steps before it below that.
  static constexpr int kPresent = -1;
};

/// The trainee's requests to the running session: window -> haptic loop, latest value.
struct SessionControl {
  bool paused = false;  ///< Tools stand still without force; the session's time continues.
  std::array<int, kMaxInstruments> instrument_index{};  ///< As in ToolPose; taken once the tip is
                                                        ///< free.
  std::array<bool, kMaxInstruments> pedal{};  ///< Pressed, in addition to the device's button.
  RestartRequest restart;
};

/// The material point that a tip or shaft presses at one of its places in a haptic tick. The step
/// puts its own contact there, so the two loops never disagree about it.
struct TickContactPoint {
  int known_organ = -1;  ///< Organ whose surface patch the tick had for this place; -1: none.
  int organ = -1;        ///< Organ that the tip touches; -1: none.
  int triangle = -1;     ///< In the organ's mesh; -1: on the coarse surface, so the step searches.
  Vector3d weights = Vector3d::Zero();     ///< Barycentric in the triangle.
  Vector3d normal_W = Vector3d::Zero();    ///< Outward, unit.
  Vector3d friction_W = Vector3d::Zero();  ///< Tangential force on the tissue over the normal one.
  /// Grasp: way of the held tissue along the jaws' faces since they closed, tool frame, m.
  Vector3d slip_T = Vector3d::Zero();
  double from_trocar = 0;  ///< Shaft: distance of the pressing part from the trocar, m.
};

/// Haptic loop -> deformation loop, latest value, every tick.
struct ToolState {
  std::uint64_t tick = 0;
  Nanoseconds time_ns = 0;         ///< Scheduled time of the tick.
  Nanoseconds device_time_ns = 0;  ///< Time of the newest device sample in it.
  int tool_count = 0;
  std::array<ToolPose, kMaxInstruments> tools;
  std::array<std::array<TickContactPoint, kToolPlaces>, kMaxInstruments> contact_points;
  RestartRequest restart;  ///< The newest one.
};

/// Telemetry loop -> deformation loop, latest value: the present step of the exercise. The state in
/// which it begins is kept, so that it can begin again.
struct ExerciseProgress {
  int step = 0;
  int restarts = 0;  ///< Of the exercise, so far.
};

/// Record of one deformation step; logged in both clocks so that a replay can apply it.
struct StepRecord {
  std::uint64_t number = 0;        ///< Step number, from 1.
  std::uint64_t input_tick = 0;    ///< Tick whose ToolState it used.
  Nanoseconds time_ns = 0;         ///< Start of the step.
  Nanoseconds device_time_ns = 0;  ///< Time of the newest device sample in it.
  Nanoseconds wake_late_ns = 0;    ///< Wake-up minus schedule; 0 in lockstep.
  Nanoseconds compute_ns = 0;      ///< 0 in lockstep, where nothing is measured.
  int iterations = 0;              ///< Relaxation iterations, summed over the organs.
  double residual = 0;             ///< Largest relative residual of the relaxation.
  std::uint32_t flags = 0;         ///< StepFlag, or-ed.
  std::int32_t shed_level = 0;     ///< LoadShedding::level(); 0: full quality.
  /// Step of the exercise as whose beginning the state before this step was kept; -1: it was not.
  std::int32_t kept_step = -1;
  /// Step of the exercise to whose beginning the tissue returned before this step; -1: it did not.
  std::int32_t restarted_step = -1;
};

/// Faults of a step, each with its remedy.
enum StepFlag : std::uint32_t {
  kStepOk = 0,
  kStepBudgetSpent = 1u << 0,      ///< The relaxation stopped early: fewer cells, or "cholesky".
  kStepNotFinite = 1u << 1,        ///< A NaN was caught, tool or organ held back: report the scene.
  kStepContactsDropped = 1u << 2,  ///< More than kMaxToolRows contacts on one organ. Tips
                                   ///< and jaws were kept before shafts, the first tool's first.
  kStepContactsRegularised = 1u << 3,  ///< Contacts (nearly) coincide: they share one force.
  kStepInverted = 1u << 4,    ///< Tissue is inverted: pull back, or use more and finer cells.
  kStepRecovering = 1u << 5,  ///< A finite-strain organ follows its tools only part of the way, to
                              ///< stay valid: pull back, or more newton_iterations.
  kStepShed = 1u << 6,  ///< Quality is reduced because steps exceeded their budget: fewer cells,
                        ///< fewer newton_iterations, a faster machine or a lower deformation_hz.
};

/// Deformation loop -> haptic loop, latest value, every step.
struct ContactPatch {
  StepRecord step;
  int tool_count = 0;
  std::array<ToolPatches, kMaxInstruments> tools;
};

/// An indentation below the lattice's resolution (half_space.h). A vertex at the distance d from
/// `p_rest_W` moves by IndentationProfile(d, radius, resolved_radius) amplitude_W, if its rest
/// normal is less than 90 degrees from `normal_W`, that of the surface at rest.
struct IndentationSnapshot {
  Vector3d p_rest_W = Vector3d::Zero();  ///< m.
  Vector3d normal_W = Vector3d::UnitZ();
  double radius = 0;                        ///< m.
  double resolved_radius = 0;               ///< m.
  Vector3d amplitude_W = Vector3d::Zero();  ///< m^2.
};

/// One organ after a step. All fields but the offset are its shape, which is written only when it
/// changes. A reader that has seen its version need not read it again.
struct OrganSnapshot {
  /// Number of the step that last changed the shape; 0: the rest shape of SizedSnapshot().
  std::uint64_t version = 0;
  Vector3d offset_W = Vector3d::Zero();  ///< Rigid offset to add to the shape, m.
  Points control_displacements;  ///< n x 3, m, world axes (U). On the telemetry edge, V x 3 of the
                                 ///< vertices if OrganModel::HasSplitFunctions().
  std::vector<int> local_functions;  ///< Grid index of each slot's finer spline, or -1.
  Points local_displacements;        ///< Slots x 3, m.
  int indentation_count = 0;
  std::array<IndentationSnapshot, kMaxInstruments> indentations;
  Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>
      vertices;  ///< V x 3, m, world; 0 x 3 on the telemetry edge, whose readers rebuild them.
};

/// The contacts of one tip besides its main one (ToolPatches::main_place); organ -1: none.
using ContactsBeside = std::array<SolvedContact, kMaxPlaces - 1>;

/// Figures of one instrument for the display besides its contact.
struct ToolReadout {
  int clips_left = -1;        ///< In a clip applier's magazine; -1: another instrument.
  bool closed_empty = false;  ///< The jaws closed with no clip left and have not opened since.
  int layer = -1;             ///< Attachment that a hook's tip would burn; -1: none.
  /// Duct nearest to the jaws of scissors or a clip applier when they last closed on no duct; -1: none.
  int missed_duct = -1;
  double missed_by = 0;        ///< m: distance of that duct's surface from the jaws' middle.
  Nanoseconds missed_ns = -1;  ///< Time of that step.
  /// The clip or cut that the open jaws would make now; its duct -1: none. The roll about z of the tool
  /// frame would make it as square as it can be, rad.
  DuctAction clip_ahead;
  double clip_roll = 0;
  ClipsBeside clips_beside;  ///< Of clip_ahead.
};

/// Deformation loop -> render loop and -> telemetry loop, latest value, every step.
struct SceneSnapshot {
  StepRecord step;
  std::vector<OrganSnapshot> organs;
  /// Damage 0..1 of each sample of each attachment's bed, in the scene's order. Empty on the
  /// telemetry edge.
  std::vector<std::vector<float>> damage;
  std::vector<std::vector<float>> burnt;  ///< The same: share 0..1 of each sample that is burnt.
  Smoke smoke;
  std::vector<DuctSnapshot> ducts;  ///< In the scene's order. Empty on the telemetry edge.
  int tool_count = 0;
  std::array<ToolPose, kMaxInstruments> tools;          ///< As the step used them.
  std::array<SolvedContact, kMaxInstruments> contacts;  ///< In the world, offset included.
  std::array<ContactsBeside, kMaxInstruments> beside;   ///< The same.
  std::array<bool, kMaxInstruments> burns{};            ///< A hook whose pedal is pressed.
  std::array<bool, kMaxInstruments> sucks{};            ///< A suction tube whose pedal is pressed.
  std::array<ToolReadout, kMaxInstruments> readouts;
};

/// Outcome of one organ's relaxation.
struct OrganRelaxation {
  std::int32_t iterations = 0;
  bool out_of_time = false;  ///< Stopped by its clock: a replay stops after as many iterations.
  bool inverted = false;     ///< kStepInverted for this organ.
  bool recovering = false;   ///< kStepRecovering for this organ.
  double finite_strain_blend = 0;  ///< From StepQuality; a replay applies it.
  double refinement_weight = 0;    ///< From StepQuality; a replay applies it.
  /// J: of a free organ's motion, and of its weight over its rest pose. 0 for others.
  double body_energy = 0;
};

/// Effect of one instrument on the layers between organs in one step.
struct LayerWork {
  double burning = 0;   ///< J spent on layers by an energised hook.
  double cut_area = 0;  ///< m^2, by scissors.
};

/// Deformation loop -> telemetry loop, every step through a queue: everything of a step that a
/// replay applies or compares.
struct StepSample {
  StepRecord step;
  int organ_count = 0;
  std::array<OrganRelaxation, kMaxOrgans> organs;
  int attachment_count = 0;
  std::array<AttachmentOutcome, kMaxAttachments> attachments;  ///< In the scene's order.
  int duct_count = 0;
  std::array<DuctOutcome, kMaxDucts> ducts;  ///< In the scene's order.
  int layer_count = 0;
  /// Largest tension of each layer of the organs in turn, N/m. Not in the log.
  std::array<double, kMaxLayers> layer_tensions{};
  int lumen_count = 0;
  std::array<LumenOutcome, kMaxLumens>
      lumens{};        ///< Filled ones of the organs in turn. Not in the log.
  int tool_count = 0;  ///< 0 before the first tick.
  std::array<ToolPose, kMaxInstruments> tools;          ///< As the step used them.
  std::array<SolvedContact, kMaxInstruments> contacts;  ///< In the world, offset included.
  std::array<ContactsBeside, kMaxInstruments> beside;   ///< The same.
  std::array<LayerWork, kMaxInstruments> layer_work;
  std::array<DuctAction, kMaxInstruments> duct_actions;  ///< Clips and cuts of the step.
  std::array<NearDuct, kMaxInstruments> near_ducts;      ///< Of energised hooks.
};

/// Skipped ticks by cause, as counted by RunOnSchedule (loop_schedule.h).
struct SkippedTicks {
  std::uint32_t late_wake_up = 0;  ///< The scheduler woke the thread late.
  std::uint32_t long_compute = 0;  ///< The previous tick computed for longer than a period.
  std::uint32_t stalled = 0;       ///< The host took the core: wall time without CPU time.
  std::uint32_t Total() const { return late_wake_up + long_compute + stalled; }
};

/// Actions of the force guard in a tick; or-ed.
enum GuardFlag : std::uint32_t {
  kGuardOk = 0,
  kGuardNotFinite = 1u << 0,      ///< NaN or infinity replaced by the last safe force.
  kGuardClamped = 1u << 1,        ///< The force exceeded the device's limit.
  kGuardSlewed = 1u << 2,         ///< The step exceeded the slew limit.
  kGuardRampIn = 1u << 3,         ///< Start-up ramp in progress.
  kGuardStalePatch = 1u << 4,     ///< The patch is old: the force decays.
  kGuardDeviceInvalid = 1u << 5,  ///< The device gave no valid pose: the force decays.
  kGuardDisabled = 1u << 6,       ///< Forces are off, or the emergency stop was pressed.
  kGuardPassivity = 1u << 7,      ///< The passivity controller damps.
  kGuardPaused = 1u << 8,         ///< The session is paused: the force decays.
  kGuardTrocar = 1u << 9,         ///< No action: the force includes friction in the trocar.
  kGuardTank = 1u << 10,          ///< The energy tank takes over 1 % of soft tissue's force.
};

/// One instrument in one haptic tick.
struct ToolSample {
  JointVector joints = JointVector::Zero();
  Vector3d p_tip_W = Vector3d::Zero();  ///< m.
  Vector3d v_tip_W = Vector3d::Zero();  ///< m/s.
  /// Eq. 29's force on the hand before the guard, N. A force on the shaft counts as the force at
  /// the tip that acts alike on the device's axes (OnTip in haptic_contact.h).
  Vector3d reaction_W = Vector3d::Zero();
  Vector3d force_W = Vector3d::Zero();     ///< Force on the hand sent to the device, N.
  AxisEffort effort = AxisEffort::Zero();  ///< J^T force.
  double depth = 0;                        ///< Tip below the released surface, m; 0 if above it.
  int organ = -1;                          ///< Organ in contact, -1 for none.
  ContactKind kind = ContactKind::kNone;
  std::uint32_t guard_flags = 0;  ///< GuardFlag.
  double slip = 0;     ///< Way that held tissue has slipped through the jaws since they closed, m.
  double energy = 0;   ///< Work done by the hand, from the passivity observer, J.
  double damping = 0;  ///< Damping added by the passivity controller in this tick, N s/m.
  Nanoseconds device_time_ns = 0;  ///< Time of this device's sample.
  bool device_valid = false;
  bool force_on = false;     ///< Device::ForceOn().
  bool pedal = false;        ///< As in ToolPose.
  int instrument_index = 0;  ///< As in ToolPose.
};

/// Haptic loop -> telemetry loop, every tick through a queue.
struct HapticSample {
  std::uint64_t tick = 0;          ///< Number of the period, counting skipped ones.
  Nanoseconds time_ns = 0;         ///< Scheduled time.
  Nanoseconds device_time_ns = 0;  ///< Time of the device sample used.
  std::uint64_t patch_number = 0;  ///< ContactPatch::step.number used; 0 before the first.
  std::uint64_t patch_tick = 0;    ///< First tick that used that patch.
  Nanoseconds patch_age_ns = 0;    ///< time_ns minus the patch's device time.
  Nanoseconds wake_late_ns = 0;    ///< Wake-up minus schedule; 0 in lockstep.
  Nanoseconds written_ns = 0;      ///< Wake-up to the last effort written; 0 in lockstep.
  Nanoseconds compute_ns = 0;      ///< Wall time of the tick; 0 in lockstep.
  SkippedTicks skipped;            ///< Periods skipped just before this one, by cause.
  bool paused = false;             ///< SessionControl::paused: the devices were not read.
  RestartRequest restart;          ///< The newest one.
  int tool_count = 0;
  std::array<ToolSample, kMaxInstruments> tools;
};

/// Most steps and rules of an exercise of which ExerciseStatus has times and counts.
inline constexpr std::size_t kShownSteps = 32, kShownRules = 32;

/// State of the scene's exercise (engine/exercise/exercise_evaluator.h) for the display.
struct ExerciseStatus {
  bool present = false;  ///< The scene has an exercise.
  int step = 0;          ///< Index of the present step; the number of steps once all are done.
  double progress = 0;   ///< Of the present step, 0..1.
  double time = 0;       ///< s since the exercise began.
  double time_left = 0;  ///< s.
  int errors = 0;        ///< So far.
  int last_error = -1;   ///< Index in ExerciseOptions::errors; -1: none.
  double last_error_time = 0;   ///< s since the exercise began.
  double last_error_force = 0;  ///< N on tissue, of the instrument that made it.
  ClipFinding last_error_clip;  ///< Of an error about a clip.
  int last_error_duct = -1;     ///< -1: none.
  double score = 0;             ///< 0..100, as if the exercise ended now.
  bool ended = false;
  bool passed = false;   ///< All steps are done.
  int restarts = 0;      ///< So far.
  double restarted = 0;  ///< s since the exercise began, of the last one.
  /// s since the exercise began, of the first steps that are done.
  std::array<float, kShownSteps> step_times{};
  std::array<std::uint16_t, kShownRules> error_counts{};  ///< Of the first rules.
};

/// Session figures for the display: telemetry loop -> render loop, latest value, a few times per
/// second.
struct SessionHealth {
  struct Tool {
    Vector3d force_W = Vector3d::Zero();  ///< On the hand, without friction in the trocar, N.
    double depth = 0;                     ///< m.
    int organ = -1;
    std::uint32_t guard_flags = 0;  ///< GuardFlag of the last tick.
    double peak_force = 0;          ///< N, since the session began.
  };
  Nanoseconds time_ns = 0;
  std::uint64_t ticks = 0;
  SkippedTicks skipped;              ///< Since the session began.
  double haptic_hz = 0;              ///< Over the last second.
  double deformation_hz = 0;         ///< Over the last second.
  Nanoseconds wake_late_p99_ns = 0;  ///< Haptic loop, over the last second.
  Nanoseconds step_compute_ns = 0;   ///< Compute time of the last step.
  std::uint32_t step_flags = 0;      ///< StepFlag of the last step.
  std::uint64_t log_lost = 0;        ///< Ticks that the log missed.
  int tool_count = 0;
  std::array<Tool, kMaxInstruments> tools;
  ExerciseStatus exercise;
};

/// Render loop -> telemetry loop, every frame through a queue; real clock only.
struct FrameRecord {
  Nanoseconds time_ns = 0;         ///< Session time when the read-back finished.
  Nanoseconds device_time_ns = 0;  ///< Time of the newest device sample shown.
  Nanoseconds compute_ns = 0;      ///< Draw, read back, keep.
};

}  // namespace hpdm
