#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engine/deformation_loop.h"
#include "engine/organ.h"
#include "engine/snapshots.h"
#include "engine/threads/spsc_queue.h"
#include "engine/threads/triple_buffer.h"
#include "haptics/device/hand_script.h"
#include "haptics/device/mouse_hand.h"
#include "haptics/device/trace_file.h"
#include "haptics/haptic_loop.h"
#include "lcmtypes/live/device_link.h"
#include "lcmtypes/telemetry/telemetry_loop.h"
#include "render/render_loop.h"
#include "scenes/generator/shapes/instrument_mesh.h"
#include "scenes/loader/scene.h"
#include "tools/session/contact_stiffness.h"
#include "tools/session/device_choice.h"
#include "tools/session/trainer_input.h"
#include "tools/session/virtual_wall.h"

namespace hpdm {

/// Builds and owns everything that a scene describes: the constant organs, the devices, and the
/// edges between the loops (snapshots.h). The command that runs the loops builds them and wires
/// the threads. Main thread.
class Session {
 public:
  /// Builds the session of `scene` with the scene's own devices. Throws InputError.
  explicit Session(const Scene& scene) : Session(scene, ChooseDevices({}, scene.instruments)) {}
  /// Hears, before each slow part of the construction, what is being built.
  using Progress = std::function<void(const std::string& what)>;
  /// The same with a chosen device for each instrument. `progress` may be null.
  Session(Scene scene, std::vector<DeviceChoice> devices, const Progress& progress = nullptr);

  /// Reads the displacements that kOverlayError compares an organ with. `argument` is "FILE", or
  /// "ORGAN=FILE" if there are several organs. Throws InputError if the organ is unknown or the
  /// file is of another mesh.
  void LoadReference(const std::string& argument);

  const Scene& scene() const { return scene_; }
  const std::vector<OrganModel>& organs() const { return organs_; }
  /// Returns the device of each instrument.
  const std::vector<DeviceChoice>& device_choices() const { return choices_; }
  /// Returns the length of the longest trace if every instrument plays one, else 0.
  Nanoseconds trace_length() const { return trace_length_; }
  /// Returns the repairs of the meshes and probable mistakes in the scene, one line each.
  const std::vector<std::string>& remarks() const { return remarks_; }

  /// The stiffest contact of each organ with each instrument. remarks() has a line for each one
  /// that exceeds the limit of its device.
  struct ContactFact {
    std::string instrument;
    std::string organ;
    StiffestContact stiffest;
  };
  const std::vector<ContactFact>& contacts() const { return contacts_; }
  /// Returns the place that an instrument's hand goes to. Throws InputError if there is none.
  HandSite SiteOf(const InstrumentOptions& instrument) const;
  /// Returns the virtual wall of each instrument; empty if the scene has no rigid organ.
  const std::vector<VirtualWall>& walls() const { return walls_; }

  Nanoseconds haptic_period_ns() const { return kNanosecondsPerSecond / scene_.timing.haptic_hz; }

  /// Homes the devices and switches their forces on (or off, at the end).
  void EnableForces(bool on);

  // Inputs of the loops.
  std::vector<HapticInstrument> HapticInstruments() const;
  std::vector<ToolOptions> DeformationTools() const;
  std::vector<OrganVisual> OrganVisuals() const;
  std::vector<InstrumentVisual> InstrumentVisuals() const;
  const Image* Background() const;  ///< Null if the scene has none.
  SessionInfo Info() const;
  std::vector<TrainerInput::Instrument> TrainerInstruments() const;
  StatusNames Names() const;

  // The edges. The queues hold two seconds of samples, steps and frames, so that a telemetry thread
  // that waits less than that for a disk loses nothing.
  TripleBuffer<ToolState> tool_states;
  TripleBuffer<ContactPatch> patches;
  std::unique_ptr<TripleBuffer<SceneSnapshot>> render_scenes;
  std::unique_ptr<TripleBuffer<SceneSnapshot>> telemetry_scenes;
  SpscQueue<HapticSample> samples;
  SpscQueue<StepSample> steps;
  /// Readings of the instruments that external drivers move, null for the others.
  std::array<TripleBuffer<DeviceSample>*, kMaxInstruments> external_readings{};
  SpscQueue<HapticSample> external_forces;  ///< Forces for those drivers.
  bool HasExternalDevice() const;
  DeviceLink::Edges LinkEdges() { return {external_readings, external_forces, &link_events}; }
  SpscQueue<FrameRecord> frames;
  /// Written by a window or a ControlScript; without one nothing writes it.
  TripleBuffer<SessionControl> control;
  SpscQueue<LoopEvent> render_events{64};
  SpscQueue<LoopEvent> link_events{64};
  TripleBuffer<SessionHealth> health;
  // Written by a window; without one nothing writes them.
  TripleBuffer<ViewSettings> view_settings;
  /// Targets of the instruments that the mouse moves, null for the others.
  std::array<TripleBuffer<HandTarget>*, kMaxInstruments> hand_targets{};

 private:
  void ReadTraces();
  void ReadPictures();
  void BuildOrgans(const Progress& progress);
  void CheckTip(const InstrumentDescription& held) const;
  void BuildInstruments();
  void CompareStiffness(const Progress& progress);
  void BuildWalls();
  std::unique_ptr<Device> BuildDevice(std::size_t instrument, const HandSite& site);
  std::unique_ptr<Device> BuildTraceDevice(std::size_t instrument, const HandSite& site);

  Scene scene_;
  Image background_;             // empty if the scene names none
  std::vector<Image> textures_;  // by organ; empty if it names none
  std::vector<OrganModel> organs_;
  std::vector<std::vector<InstrumentMeshes>>
      instrument_meshes_;           // [instrument][ToolPose::instrument_index]
  std::vector<Points> references_;  // by organ, V x 3, m; 0 rows if none was loaded
  std::vector<ImpulseEngineKinematics> kinematics_;
  std::vector<DeviceChoice> choices_;
  std::vector<TraceFile> traces_;  // by instrument; without rows if it plays none
  std::vector<std::unique_ptr<Device>> devices_;
  Nanoseconds trace_length_ = 0;
  std::vector<std::string> remarks_;
  std::vector<ContactFact> contacts_;
  std::vector<VirtualWall> walls_;
};

/// The forces of a session's devices are on while this lives, and off after it however it ends. The
/// devices' owner.
class ForcesOn {
 public:
  explicit ForcesOn(Session* session) : session_(*session) { session_.EnableForces(true); }
  ~ForcesOn() { session_.EnableForces(false); }
  ForcesOn(const ForcesOn&) = delete;
  ForcesOn& operator=(const ForcesOn&) = delete;

 private:
  Session& session_;
};

}  // namespace hpdm
