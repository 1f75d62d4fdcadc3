#pragma once

#include <array>
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

/// Everything that a scene describes, built and owned in one place: the constant organs, the
/// devices, and the edges between the loops (snapshots.h). The loops themselves are made by the
/// command that runs them, which is where the threads are wired. Main thread.
class Session {
 public:
  /// Builds what `scene` says, with its own devices. Throws InputError.
  explicit Session(const Scene& scene) : Session(scene, ChooseDevices({}, scene.instruments)) {}
  /// The same with a chosen device for each instrument.
  Session(Scene scene, std::vector<DeviceChoice> devices);

  /// Reads the displacements that kOverlayError compares an organ with: "FILE", or "ORGAN=FILE"
  /// where there are several. Throws InputError when the organ or its mesh is another one.
  void LoadReference(const std::string& argument);

  const Scene& scene() const { return scene_; }
  const std::vector<OrganModel>& organs() const { return organs_; }
  /// What moves each instrument.
  const std::vector<DeviceChoice>& device_choices() const { return choices_; }
  /// Length of the longest trace when every instrument plays one, else 0.
  Nanoseconds trace_length() const { return trace_length_; }
  /// Repairs of the meshes and things that are probably not meant, one line each.
  const std::vector<std::string>& remarks() const { return remarks_; }

  /// Where each organ is stiffest for each instrument, against what its device displays; remarks()
  /// names those beyond it.
  struct ContactFact {
    std::string instrument;
    std::string organ;
    StiffestContact stiffest;
  };
  const std::vector<ContactFact>& contacts() const { return contacts_; }
  /// What rigid organs are to each instrument; empty when the scene has none.
  const std::vector<VirtualWall>& walls() const { return walls_; }

  Nanoseconds haptic_period_ns() const { return kNanosecondsPerSecond / scene_.timing.haptic_hz; }

  /// Homes the devices and switches their forces on (or off, at the end).
  void EnableForces(bool on);

  // What the loops are made of.
  std::vector<HapticInstrument> HapticInstruments() const;
  std::vector<ToolOptions> DeformationTools() const;
  std::vector<OrganVisual> OrganVisuals() const;
  std::vector<InstrumentVisual> InstrumentVisuals() const;
  const Image* Background() const;  ///< Null: none.
  SessionInfo Info() const;
  std::vector<TrainerInput::Instrument> TrainerInstruments() const;
  StatusNames Names() const;

  // The edges. Two seconds of samples, steps and frames fit their queues: a telemetry thread that a
  // disk holds up for less loses nothing.
  TripleBuffer<ToolState> tool_states;
  TripleBuffer<ContactPatch> patches;
  std::unique_ptr<TripleBuffer<SceneSnapshot>> render_scenes;
  std::unique_ptr<TripleBuffer<SceneSnapshot>> telemetry_scenes;
  SpscQueue<HapticSample> samples;
  SpscQueue<StepSample> steps;
  /// Of the instruments that are driven from outside, null for the others; and the forces for them.
  std::array<TripleBuffer<DeviceSample>*, kMaxInstruments> external_readings{};
  SpscQueue<HapticSample> external_forces;
  bool HasExternalDevice() const;
  DeviceLink::Edges LinkEdges() { return {external_readings, external_forces, &link_events}; }
  SpscQueue<FrameRecord> frames;
  /// Of a window or a ControlScript; nothing writes it without one.
  TripleBuffer<SessionControl> control;
  SpscQueue<LoopEvent> render_events{64};
  SpscQueue<LoopEvent> link_events{64};
  TripleBuffer<SessionHealth> health;
  // Of a window; nothing writes them without one.
  TripleBuffer<ViewSettings> view_settings;
  /// Of the instruments that the mouse moves, null for the others.
  std::array<TripleBuffer<HandTarget>*, kMaxInstruments> hand_targets{};

 private:
  void ReadTraces();
  void ReadPictures();
  void BuildOrgans();
  void BuildInstruments();
  void CompareStiffness();
  void BuildWalls();
  std::unique_ptr<Device> BuildDevice(std::size_t instrument, const HandSite& site);
  std::unique_ptr<Device> BuildTraceDevice(std::size_t instrument, const HandSite& site);
  HandSite SiteOf(const InstrumentOptions& instrument) const;

  Scene scene_;
  Image background_;             // empty where the scene names none
  std::vector<Image> textures_;  // by organ, likewise
  std::vector<OrganModel> organs_;
  std::vector<std::vector<InstrumentMeshes>>
      instrument_meshes_;           // [instrument][ToolPose::instrument_index]
  std::vector<Points> references_;  // by organ, V x 3, m; 0 rows without
  std::vector<ImpulseEngineKinematics> kinematics_;
  std::vector<DeviceChoice> choices_;
  std::vector<TraceFile> traces_;  // by instrument; without rows where it plays none
  std::vector<std::unique_ptr<Device>> devices_;
  Nanoseconds trace_length_ = 0;
  std::vector<std::string> remarks_;
  std::vector<ContactFact> contacts_;
  std::vector<VirtualWall> walls_;
};

}  // namespace hpdm
