#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/snapshots.h"
#include "engine/step/tool_geometry.h"

/// A scene's instruments, validated by the loader (scenes/loader/scene.h), SI units.
namespace hpdm {

/// Figures of a laparoscopic haptic device. No figures of the Laparoscopic Impulse Engine are
/// available. Every value below is assumed, from devices of its class; the scene can override it
/// ([instrument.device]).
struct DeviceProfile {
  double mass = 0.15;                    ///< kg, moving along the insertion axis (assumed).
  double rotational_inertia = 3e-3;      ///< kg m^2, about the trocar: pitch and yaw (assumed).
  double damping = 0.5;                  ///< N s/m along the insertion axis (assumed).
  double rotational_damping = 0.01;      ///< N m s/rad, pitch and yaw (assumed).
  double friction = 0.1;                 ///< N, Coulomb, insertion (assumed).
  double rotational_friction = 2e-3;     ///< N m, Coulomb, pitch and yaw (assumed).
  double encoder_step = 2.5e-5;          ///< m, insertion (assumed).
  double angle_encoder_step = 1e-4;      ///< rad, pitch, yaw and roll (assumed).
  double jaw_encoder_step = 1.0 / 1024;  ///< Fraction of the jaw's full range (assumed).
  double max_force = 8.9;                ///< N, at the tip and on the insertion axis (assumed).
  double max_torque = 1.0;               ///< N m, pitch and yaw (assumed).
  double max_force_rate = 2000;          ///< N/s: the guard's slew limit (assumed).
  double max_angle = 1.2;                ///< rad, pitch and yaw from the home direction (assumed).
  double min_insertion = 0.02;           ///< m (assumed).
  double max_insertion = 0.30;           ///< m (assumed).
  double delay = 0;                      ///< s, from a reading to the force that answers it, in
                                         ///< addition to the hold over a period.
  bool passivity_control = true;         ///< passivity.h; it damps only energy that the device
                                         ///< cannot dissipate itself.
};

enum class InstrumentType { kProbe, kGrasper, kScissors, kHook, kClipApplier, kSuction };
enum class HandScript { kPalpate, kTap, kSlide, kGraspLift, kGraspPull, kRandom };

/// A simulated trainee's hand (simulated_hand.h).
struct HandOptions {
  HandScript script = HandScript::kPalpate;
  std::uint32_t seed = 1;
  std::string organ;               ///< Name of the target organ; default by the loader: the first.
  std::optional<Vector3d> target;  ///< World point on the organ's surface, m; absent: where the
                                   ///< line from the trocar to the organ's centre enters it.
  double depth = 0.015;            ///< m: intended press depth (or lift, or pull).
  double spread = 0.02;            ///< m: farthest place from the target along the surface.
  double speed = 0.08;             ///< m/s: mean speed of a reach.
  double stiffness = 300;          ///< N/m: the hand's impedance.
  double damping = 6;              ///< N s/m.
  double tremor = 1e-4;            ///< m, amplitude at 8-12 Hz.
};

/// A recorded motion that moves the instrument (trace_file.h, trace_device.h).
struct TraceOptions {
  std::string file;                      ///< Path; empty: the scene names none.
  double scale = 1;                      ///< m per unit of the file's px, py, pz.
  Matrix3d R_WF = Matrix3d::Identity();  ///< Rotates the file's axes to the world.
  std::optional<Vector3d> position;      ///< World position of the file's origin, m; absent: fitted
                                         ///< so that the deepest row lies at HandOptions::depth.
  double speed = 1;                      ///< Playback speed over recorded speed.
};

/// Jaw parts that turn about the line x = 0, z = pivot of the tool frame.
struct JawOptions {
  std::vector<std::string> meshes;  ///< Paths, at most two, jaws closed; the first opens towards
                                    ///< +x, the second towards -x.
  double pivot = 0;                 ///< m.
  double opening = 0;               ///< rad per jaw.
};

/// An instrument that a hand can hold at its device.
struct InstrumentDescription {
  std::string name;
  InstrumentType type = InstrumentType::kProbe;
  std::string mesh;  ///< Path of the fixed part's mesh; empty: drawn by its type.
  JawOptions jaws;   ///< Only with `mesh`.
  std::optional<double> insulated_from;  ///< m: z of the tool frame where the shaft's insulation
                                         ///< begins; absent: by its type, none with `mesh`.
  ToolGeometry geometry;
};

struct InstrumentOptions : InstrumentDescription {
  std::vector<InstrumentDescription> exchanges;  ///< Further instruments of this hand:
                                                 ///< ToolPose::instrument_index 1 and up.
  Vector3d p_trocar_W = Vector3d::Zero();        ///< m.
  ReactionType reaction = ReactionType::kLattice;
  double k1 = 120;             ///< N/m, Eq. 29 ("paper").
  double k2 = 10;              ///< N/m, Eq. 29 ("paper").
  double trocar_friction = 0;  ///< N, Coulomb friction along the shaft in the trocar; 0: none.
  double trocar_torque = 0;    ///< N m, the same about the pivot.
  DeviceProfile device;
  HandOptions hand;
  TraceOptions trace;

  /// Returns the instrument with this ToolPose::instrument_index.
  const InstrumentDescription& Held(int instrument_index) const {
    return instrument_index == 0 ? *this
                                 : exchanges[static_cast<std::size_t>(instrument_index - 1)];
  }
  int HeldCount() const { return 1 + static_cast<int>(exchanges.size()); }
};

}  // namespace hpdm
