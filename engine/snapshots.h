#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/base/types.h"
#include "engine/organ_motion.h"

/// The values that threads exchange. Each type crosses exactly the edges named here:
///
///     device -> haptic loop --ToolState--> deformation loop --SceneSnapshot--> render loop
///                 |   ^------ContactPatch-----'     |     |                       |    ^
///                 |               StepSample queue  |     | SceneSnapshot         |    |
///                 |                                 v     v                       |    |
///                 '---HapticSample queue------> telemetry loop <-FrameRecord queue'    |
///                                                      '----------SessionHealth--------'
///
///     window --SessionControl--> haptic loop
///     link of external drivers --DeviceSample--> haptic loop --HapticSample queue--> the same link
///
/// A queue keeps every item (SpscQueue): one HapticSample a tick, one StepSample a step, one
/// FrameRecord a picture. The other edges keep the latest value (TripleBuffer). Everything but
/// SceneSnapshot has a fixed size, so writing one in place allocates nothing; a SceneSnapshot's
/// arrays are sized before the threads start.
namespace hpdm {

inline constexpr int kMaxInstruments = 2;
inline constexpr int kMaxOrgans = 64;
inline constexpr int kMaxHeld = 8;  ///< Instruments that one hand can hold in turn.

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
  bool valid = false;  ///< False: the device answered nothing usable; the pose is the last one.
};

/// Pose of one instrument in the world.
struct ToolPose {
  Isometry3d X_WT = Isometry3d::Identity();  ///< Tool frame: origin at the tip, z from the tip to
                                             ///< the trocar (along the shaft), y the jaw's axis.
  Vector3d p_trocar_W = Vector3d::Zero();    ///< m; fixed.
  Vector3d v_tip_W = Vector3d::Zero();       ///< m/s, filtered.
  double jaw = 1;                            ///< 0 closed .. 1 open.
  int instrument_index = 0;  ///< Which instrument the hand holds: 0 the first, then its exchanges
                             ///< in order.
};

/// What the trainee asks of the running session: window -> haptic loop, latest value.
struct SessionControl {
  bool paused = false;  ///< The hands stand still and feel nothing; the session's time runs on.
  std::array<int, kMaxInstruments> instrument_index{};  ///< As in ToolPose; taken when the tip is
                                                        ///< free.
};

/// The contact of a tip as the haptic loop has it in a tick: which material point it presses and
/// how. The step puts its own contact there, so that the two never disagree about the place.
struct TickContactPoint {
  int known_organ = -1;                    ///< Whose surface the tick had around the tip; -1: none.
  int organ = -1;                          ///< -1: the tip touches nothing.
  int triangle = -1;                       ///< Of the organ's mesh.
  Vector3d weights = Vector3d::Zero();     ///< Barycentric in it.
  Vector3d normal_W = Vector3d::Zero();    ///< Outward, unit.
  Vector3d friction_W = Vector3d::Zero();  ///< Tangential force on the tissue over the normal one.
};

/// Haptic loop -> deformation loop, latest value, every tick.
struct ToolState {
  std::uint64_t tick = 0;
  Nanoseconds time_ns = 0;         ///< Scheduled time of the tick.
  Nanoseconds device_time_ns = 0;  ///< Of the newest device sample in it.
  int tool_count = 0;
  std::array<ToolPose, kMaxInstruments> tools;
  std::array<TickContactPoint, kMaxInstruments> contact_points;
};

/// A mass-spring node as in Eq. 29: the spring k1 to the released position p_original and N
/// springs k2_i of rest length d_i to neighbours p_i, which nothing moves.
struct ReactionNode {
  static constexpr int kMaxNeighbours = 12;
  struct Neighbour {
    Vector3d edge = Vector3d::Zero();  ///< p_original - p_i, m.
    double rest_length = 0;            ///< d_i, m.
    double k2 = 0;                     ///< N/m.
  };
  double k1 = 0;  ///< N/m.
  int neighbour_count = 0;
  std::array<Neighbour, kMaxNeighbours> neighbours;
};

/// Where a tool's reaction force comes from: the lattice's own compliance, or springs set by hand.
enum class ReactionType : std::uint8_t { kLattice = 0, kPaper = 1 };

/// A surface vertex near a tool, prefetched for the haptic loop.
struct PatchPoint {
  Vector3d p_original_W = Vector3d::Zero();  ///< Where it is when the tools let go, m.
  Vector3d normal_W = Vector3d::Zero();      ///< Outward unit normal there.
  /// kLattice: C of the contact if it were here, m/N, symmetric positive definite; the mean over
  /// the corners of the contact's triangle is SolvedContact::compliance_W.
  Matrix3d compliance_W = Matrix3d::Zero();
  Matrix3d coupling_W = Matrix3d::Zero();  ///< kLattice: likewise to the other tool's tip.
  ReactionNode node;                       ///< kPaper.
};

/// A jaw opened beyond this lets go, in the tick as in the step.
inline constexpr double kJawLetsGo = 0.5;

enum class ContactKind : std::uint8_t { kNone = 0, kPress = 1, kGrasp = 2 };

/// The contact of one tool's tip as the step solved it.
struct SolvedContact {
  int organ = -1;  ///< Index of the organ, -1 when none is near.
  ContactKind kind = ContactKind::kNone;
  ReactionType reaction = ReactionType::kPaper;
  bool shaft_contact = false;                     ///< The shaft touches tissue too.
  Vector3d contact_W = Vector3d::Zero();          ///< Deformed contact point x_c, m.
  Vector3d force_on_tissue_W = Vector3d::Zero();  ///< f_c, from the lattice's energy, N.

  // kLattice: with x the contact point, the force on the tissue is C^-1 (x - p_original).
  Vector3d p_original_W = Vector3d::Zero();  ///< Where x_c goes when all tips let go, m.
  Vector3d normal_W = Vector3d::Zero();      ///< Press: the outward unit normal of the contact.
  Matrix3d compliance_W = Matrix3d::Zero();  ///< C, m/N.
  Matrix3d coupling_W = Matrix3d::Zero();    ///< C_ac: what a force on the other tool's tip moves x
                                             ///< by, m/N; zero when that is not on the organ.
  double kernel_radius = 0;                  ///< R, m; press.
};

/// The surface around one tool, as the haptic loop needs it between two deformation steps: a
/// bounded set of triangles around where the tip will be, with what Eq. 29 needs at their corners.
/// A contact that slides to the set's border stays on it, and no new one is made beyond it, until
/// the next patch. The caps bound the set, so its radius shrinks with the mesh's edges: about 5
/// edges, 12 mm on a surface of 2.5 mm edges. Its positions are those of an organ that stands
/// still: `motion` carries them.
struct ToolPatch : SolvedContact {
  static constexpr int kMaxPoints = 64;
  static constexpr int kMaxTriangles = 96;
  int instrument_index = 0;  ///< ToolPose::instrument_index of the instrument it is for.
  OrganMotion motion;
  int point_count = 0;
  int triangle_count = 0;
  std::array<PatchPoint, kMaxPoints> points;
  std::array<std::array<std::uint8_t, 3>, kMaxTriangles> triangles;
  std::array<int, kMaxTriangles> mesh_triangles{};  ///< Their numbers in the organ's mesh.

  // kLattice, press: how the pressed surface's normal leaves the released one's.
  Vector3d tilt_W = Vector3d::Zero();             ///< By the step's forces.
  Matrix3d tilt_compliance_W = Matrix3d::Zero();  ///< 1/N: by more force on the tissue at this tip.

  // Grasp: where the grasped tissue sits in the jaws; it moves rigidly with them.
  Vector3d p_grasp_T = Vector3d::Zero();  ///< m, tool frame.
  ReactionNode grasp_node;                ///< kPaper; p_original_W is its released position.
};

/// How one deformation step went; logged in both clocks so that a replay can apply it.
struct StepRecord {
  std::uint64_t number = 0;        ///< Of the step, from 1.
  std::uint64_t input_tick = 0;    ///< Tick whose ToolState it used.
  Nanoseconds time_ns = 0;         ///< When it started.
  Nanoseconds device_time_ns = 0;  ///< Of the newest device sample in it.
  Nanoseconds wake_late_ns = 0;    ///< Wake-up minus schedule; 0 in lockstep.
  Nanoseconds compute_ns = 0;      ///< 0 in lockstep: nothing measured is logged there.
  int iterations = 0;              ///< Of the relaxation, summed over the organs.
  double residual = 0;             ///< Largest relative residual of the relaxation.
  std::uint32_t flags = 0;         ///< StepFlag, or-ed.
  std::int32_t shed_level = 0;     ///< Of quality, for want of time (load_shedding.h); 0: none.
};

/// What can go wrong in a step, each with its remedy.
enum StepFlag : std::uint32_t {
  kStepOk = 0,
  kStepBudgetSpent = 1u << 0,      ///< The relaxation stopped early: fewer cells, or "cholesky".
  kStepNotFinite = 1u << 1,        ///< A NaN was caught, tool or organ held back: report the scene.
  kStepContactsDropped = 1u << 2,  ///< More contacts than kMaxContacts on one organ: the first
                                   ///< tool's were kept, its jaws' before its shaft's.
  kStepContactsRegularised = 1u << 3,  ///< Contacts (nearly) coincide: they share one force.
  kStepInverted = 1u << 4,    ///< Tissue is turned inside out: pull back, or more and finer
                              ///< cells.
  kStepRecovering = 1u << 5,  ///< An organ of finite strain does not follow its tools all the way,
                              ///< so that it stays sound: pull back, or more newton_iterations.
  kStepShed = 1u << 6,  ///< Steps took longer than their budget and do less: fewer cells, fewer
                        ///< newton_iterations, a faster machine or a lower deformation_hz.
};

/// Deformation loop -> haptic loop, latest value, every step.
struct ContactPatch {
  StepRecord step;
  int tool_count = 0;
  std::array<ToolPatch, kMaxInstruments> tools;
};

/// An indentation below the lattice's resolution (half_space.h): a vertex at the distance d from
/// `p_rest_W` whose rest normal is less than 90 degrees from `normal_W` moves by
/// IndentationProfile(d, radius, resolved_radius) amplitude_W.
struct IndentationSnapshot {
  Vector3d p_rest_W = Vector3d::Zero();  ///< m.
  Vector3d normal_W = Vector3d::UnitZ();
  double radius = 0;                        ///< m.
  double resolved_radius = 0;               ///< m.
  Vector3d amplitude_W = Vector3d::Zero();  ///< m^2.
};

/// One organ as the step left it. All but the offset is its shape, which is written only when it
/// changes: a reader that has seen its version need not look at it again.
struct OrganSnapshot {
  /// Number of the step that changed the shape last; 0: that of SizedSnapshot().
  std::uint64_t version = 0;
  Vector3d offset_W = Vector3d::Zero();  ///< Of the whole organ, m: not in the shape, to which it
                                         ///< comes.
  Points control_displacements;          ///< n x 3, m, world axes (U).
  std::vector<int> local_functions;      ///< Index in the finer splines' grid of each slot, or -1.
  Points local_displacements;            ///< Slots x 3, m.
  int indentation_count = 0;
  std::array<IndentationSnapshot, kMaxInstruments> indentations;
  Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>
      vertices;  ///< V x 3, m, world; 0 x 3 on the telemetry edge, whose readers rebuild them.
};

/// Deformation loop -> render loop and -> telemetry loop, latest value, every step.
struct SceneSnapshot {
  StepRecord step;
  std::vector<OrganSnapshot> organs;
  int tool_count = 0;
  std::array<ToolPose, kMaxInstruments> tools;          ///< As the step used them.
  std::array<SolvedContact, kMaxInstruments> contacts;  ///< Where a moving organ has them.
};

/// How one organ's relaxation ended.
struct OrganRelaxation {
  std::int32_t iterations = 0;
  bool out_of_time = false;  ///< Its clock stopped it: a replay stops after as many iterations.
  bool inverted = false;     ///< kStepInverted, of this organ.
  bool recovering = false;   ///< kStepRecovering, of this organ.
  double finite_strain_blend = 0;  ///< StepQuality, which a replay applies.
  double refinement_weight = 0;    ///< Likewise.
};

/// Deformation loop -> telemetry loop, every step through a queue: all of a step that a replay must
/// apply or compares.
struct StepSample {
  StepRecord step;
  int organ_count = 0;
  std::array<OrganRelaxation, kMaxOrgans> organs;
  int tool_count = 0;                                   ///< 0 before the first tick too.
  std::array<ToolPose, kMaxInstruments> tools;          ///< As the step used them.
  std::array<SolvedContact, kMaxInstruments> contacts;  ///< In the world: moved with the organ.
};

/// Skipped ticks by cause, as RunOnSchedule (loop_schedule.h) finds it.
struct SkippedTicks {
  std::uint32_t late_wake_up = 0;  ///< The scheduler woke the thread late.
  std::uint32_t long_compute = 0;  ///< The previous tick's own computing took over a period.
  std::uint32_t stalled = 0;       ///< The host took the core: wall time without CPU time.
  std::uint32_t Total() const { return late_wake_up + long_compute + stalled; }
};

/// What the force guard did in a tick; or-ed.
enum GuardFlag : std::uint32_t {
  kGuardOk = 0,
  kGuardNotFinite = 1u << 0,      ///< NaN or infinity replaced by the last safe force.
  kGuardClamped = 1u << 1,        ///< Longer than the device's force limit.
  kGuardSlewed = 1u << 2,         ///< The step exceeded the slew limit.
  kGuardRampIn = 1u << 3,         ///< Start-up ramp in progress.
  kGuardStalePatch = 1u << 4,     ///< The patch is old: the force decays.
  kGuardDeviceInvalid = 1u << 5,  ///< The device gave no valid pose: the force decays.
  kGuardDisabled = 1u << 6,       ///< Forces are switched off or the emergency stop is pressed.
  kGuardPassivity = 1u << 7,      ///< The passivity controller damps.
  kGuardPaused = 1u << 8,         ///< The session is paused: the force decays.
};

/// One instrument in one haptic tick.
struct ToolSample {
  JointVector joints = JointVector::Zero();
  Vector3d p_tip_W = Vector3d::Zero();     ///< m.
  Vector3d v_tip_W = Vector3d::Zero();     ///< m/s.
  Vector3d reaction_W = Vector3d::Zero();  ///< Eq. 29's force on the hand before the guard, N.
  Vector3d force_W = Vector3d::Zero();     ///< Force on the hand sent to the device, N.
  AxisEffort effort = AxisEffort::Zero();  ///< The same through J^T.
  double depth = 0;                        ///< Of the tip below the released surface, m; 0 if none.
  int organ = -1;                          ///< In contact with, -1 for none.
  ContactKind kind = ContactKind::kNone;
  std::uint32_t guard_flags = 0;  ///< GuardFlag.
  double energy = 0;   ///< J, that the hand has put in, as the passivity observer has it.
  double damping = 0;  ///< N s/m that the passivity controller adds in this tick.
  Nanoseconds device_time_ns = 0;  ///< Of this device's sample.
  bool device_valid = false;
  bool force_on = false;     ///< Device::ForceOn().
  int instrument_index = 0;  ///< As in ToolPose.
};

/// Haptic loop -> telemetry loop, every tick through a queue.
struct HapticSample {
  std::uint64_t tick = 0;          ///< Number of the period, counting skipped ones.
  Nanoseconds time_ns = 0;         ///< Scheduled time.
  Nanoseconds device_time_ns = 0;  ///< Of the device sample used.
  std::uint64_t patch_number = 0;  ///< ContactPatch::step.number used; 0 before the first.
  std::uint64_t patch_tick = 0;    ///< First tick that used that patch.
  Nanoseconds patch_age_ns = 0;    ///< time_ns minus the patch's device time.
  Nanoseconds wake_late_ns = 0;    ///< Wake-up minus schedule; 0 in lockstep.
  Nanoseconds written_ns = 0;      ///< Wake-up to the last effort written; 0 in lockstep.
  Nanoseconds compute_ns = 0;      ///< Wall time of the tick; 0 in lockstep.
  SkippedTicks skipped;            ///< Periods skipped just before this one, by cause.
  bool paused = false;             ///< SessionControl::paused: the devices were not read.
  int tool_count = 0;
  std::array<ToolSample, kMaxInstruments> tools;
};

/// How the session goes, for the eye: telemetry loop -> render loop, latest value, a few times a
/// second.
struct SessionHealth {
  struct Tool {
    Vector3d force_W = Vector3d::Zero();  ///< On the hand, N.
    double depth = 0;                     ///< m.
    int organ = -1;
    std::uint32_t guard_flags = 0;  ///< GuardFlag, of the last tick.
    double peak_force = 0;          ///< N, since the session began.
  };
  Nanoseconds time_ns = 0;
  std::uint64_t ticks = 0;
  SkippedTicks skipped;              ///< Since the session began.
  double haptic_hz = 0;              ///< Over the last second.
  double deformation_hz = 0;         ///< Likewise.
  Nanoseconds wake_late_p99_ns = 0;  ///< Of the haptic loop over the last second.
  Nanoseconds step_compute_ns = 0;   ///< Of the last step.
  std::uint32_t step_flags = 0;      ///< StepFlag, of the last step.
  std::uint64_t log_lost = 0;        ///< Ticks that the log missed.
  int tool_count = 0;
  std::array<Tool, kMaxInstruments> tools;
};

/// Render loop -> telemetry loop, every frame through a queue; real clock only.
struct FrameRecord {
  Nanoseconds time_ns = 0;         ///< Session time at which the read-back had finished.
  Nanoseconds device_time_ns = 0;  ///< Of the newest device sample shown.
  Nanoseconds compute_ns = 0;      ///< Draw, read back, keep.
};

}  // namespace hpdm
