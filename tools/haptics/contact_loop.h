#pragma once

#include <memory>
#include <string>

#include "engine/deformation_loop.h"
#include "haptics/haptic_loop.h"
#include "tools/haptics/stability_plant.h"
#include "tools/session/lockstep.h"
#include "tools/session/session.h"

namespace hpdm {

/// One instrument's contact with one organ of a scene. The tip moves along a straight guide.
struct ShippedContact {
  std::string name;  ///< "scene: instrument on organ".
  std::shared_ptr<const Session> session;
  int instrument = 0;
  int organ = 0;
  bool grasps = false;
  bool rigid = false;
  Vector3d p_touch_W = Vector3d::Zero();  ///< Tip's centre as it touches, or as the jaws close, m.
  Vector3d way_W = Vector3d::Zero();  ///< The guide: unit, into the organ; of a grasp out of it.
  ImpulseEngineKinematics kinematics;

  // At the reference pose, `depth` along the guide from p_touch_W.
  double depth = 0;          ///< m.
  double force = 0;          ///< N against the motion.
  double stiffness = 0;      ///< N/m along the guide.
  ToolPatches patches = {};  ///< Of the step there.
};

/// The conditions under which a contact is displayed.
struct DisplayConditions {
  double period = 1e-3;  ///< s, of the haptic loop.
  double delay = 0;      ///< s, in addition to the hold.
  double hand = 1;       ///< Impedance of the hand over the scene's.
  bool control = true;   ///< Passivity controller.
  bool guard = true;     ///< The guard's limits of force and slew.
  bool ideal = false;    ///< Device without friction and encoders.

  bool operator==(const DisplayConditions&) const = default;
};

inline const InstrumentOptions& InstrumentOf(const ShippedContact& contact) {
  return contact.session->scene().instruments[static_cast<std::size_t>(contact.instrument)];
}

/// Returns the device of a contact as felt along the guide at `x` (m from p_touch_W): inertia,
/// damping and friction are those of the axes that move, without a hand.
StabilityPlantOptions GuidedDevice(const ShippedContact& contact, const DisplayConditions& display,
                                   double x);
/// Returns the joints of the tip at `x` m along the guide.
JointVector JointsAt(const ShippedContact& contact, double x);
/// Returns one encoder count of all axes along the guide, m.
double EncoderStepAlong(const ShippedContact& contact, double x);

/// Returns the patches of the same contacts on tissue `stiffer` times as stiff: material, supports
/// and walls. The released surface and the jaws' friction stay.
ToolPatches Stiffened(const ToolPatches& patches, const std::vector<OrganModel>& organs,
                      double stiffer);

/// Returns the force against the motion at `x` (m along the guide) that a tip gets which appears
/// there on the given patches, N.
double StaticForce(const ShippedContact& contact, const ToolPatches& patches, double x);

/// The production haptic loop of one contact on a guided plant, in virtual time.
///
/// With live steps the session's deformation loop runs in lockstep. Without them the patches of the
/// contact's reference pose stay. Both get the stiffness of `stiffer` times the scene's.
class ContactLoop {
 public:
  /// `origin`: the plant's x = 0, m along the guide. `contact` must outlive it.
  ContactLoop(const ShippedContact& contact, const DisplayConditions& display, double origin,
              double stiffer, bool live);

  void Tick();
  /// Moves the held plant along the guide from x = `from` to `to` (m) with `speed` (m/s), or for at
  /// least one tick.
  void Hold(double from, double to, double speed);
  /// Leaves it there.
  void Rest(double seconds);

  StabilityPlant& plant() { return plant_; }
  /// The mass, damping and spring along the guide, the hand included.
  const AxisDynamics& axis() const { return axis_; }
  /// The newest patches of the tool, as stiff as the scene's.
  const ToolPatches& patches() const;
  double period() const { return ToSeconds(period_ns_); }

 private:
  StabilityPlantOptions PlantOptions(const DisplayConditions& display, double origin) const;
  HapticInstrument Instrument(const DisplayConditions& display);
  void PassPatches();

  // The deformation loop and what it writes.
  struct Steps {
    Steps(const ShippedContact& contact, const TimingOptions& timing, HapticLoop* haptics,
          TripleBuffer<ToolState>* tool_states);
    TripleBuffer<ContactPatch> patches;
    TripleBuffer<SceneSnapshot> scenes, unread_scenes;
    DeformationLoop deformation;
    Lockstep clock;
  };

  const ShippedContact& contact_;
  double stiffer_;
  bool live_;
  Nanoseconds period_ns_;
  AxisDynamics axis_;
  StabilityPlant plant_;
  TripleBuffer<ToolState> tool_states_;
  std::unique_ptr<TripleBuffer<ContactPatch>> patches_;  // stiffer; large
  SpscQueue<HapticSample> samples_{2};                   // overflows, since nothing reads it
  HapticLoop haptics_;
  std::unique_ptr<Steps> steps_;  // null without live steps
  std::uint64_t tick_ = 0;        // without live steps
};

}  // namespace hpdm
