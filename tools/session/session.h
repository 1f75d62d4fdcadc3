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
#include "haptics/device/mouse_hand.h"
#include "haptics/device/trace_file.h"
#include "haptics/haptic_loop.h"
#include "lcmtypes/live/device_link.h"
#include "lcmtypes/telemetry/telemetry_loop.h"
#include "render/render_loop.h"
#include "scenes/loader/scene.h"
#include "tools/session/device_choice.h"
#include "tools/session/session_model.h"
#include "tools/session/teacher_desk.h"
#include "tools/session/trainer_input.h"

namespace hpdm {

/// Builds and owns everything that a scene describes: its constant model, the devices, and the
/// edges between the loops (snapshots.h). The command that runs the loops builds them and wires
/// the threads. Main thread.
class Session {
 public:
  /// Builds the session of `scene` with the scene's own devices. Throws InputError.
  explicit Session(const Scene& scene) : Session(scene, ChooseDevices({}, scene.instruments)) {}
  using Progress = SessionModel::Progress;
  /// The same with a chosen device for each instrument. `progress` may be null.
  Session(Scene scene, std::vector<DeviceChoice> devices, const Progress& progress = nullptr);

  /// Reads the displacements that kOverlayError compares an organ with. `argument` is "FILE", or
  /// "ORGAN=FILE" if there are several organs. Throws InputError if the organ is unknown or the
  /// file is of another mesh.
  void LoadReference(const std::string& argument);

  const SessionModel& model() const { return *model_; }
  const Scene& scene() const { return model_->scene(); }
  const std::vector<OrganModel>& organs() const { return model_->organs(); }
  const std::vector<AttachmentBed>& beds() const { return model_->beds(); }
  const std::vector<DuctModel>& ducts() const { return model_->ducts(); }
  /// Returns the number of the steps of the scene's exercise; 0 without one.
  std::size_t ExerciseSteps() const {
    return scene().exercise ? scene().exercise->steps.size() : 0;
  }
  const std::vector<Vector3d>& borne_W() const { return model_->borne_W(); }
  /// Returns the device of each instrument.
  const std::vector<DeviceChoice>& device_choices() const { return choices_; }
  /// Returns the length of the longest trace if every instrument plays one, else 0.
  Nanoseconds trace_length() const { return trace_length_; }
  /// Returns the repairs of the meshes and probable mistakes in the scene, one line each.
  const std::vector<std::string>& remarks() const { return remarks_; }

  using ContactFact = SessionModel::ContactFact;
  const std::vector<ContactFact>& contacts() const { return model_->contacts(); }
  HandSite SiteOf(const InstrumentOptions& instrument) const { return model_->SiteOf(instrument); }
  const std::vector<VirtualWall>& walls() const { return model_->walls(); }

  Nanoseconds haptic_period_ns() const { return model_->haptic_period_ns(); }

  /// Homes the devices and switches their forces on (or off, at the end).
  void EnableForces(bool on);

  // Inputs of the loops.
  std::vector<HapticInstrument> HapticInstruments() const {
    return model_->HapticInstruments(devices_);
  }
  std::vector<ToolOptions> DeformationTools() const { return model_->DeformationTools(); }
  std::vector<OrganVisual> OrganVisuals() const;  ///< With the references.
  std::vector<InstrumentVisual> InstrumentVisuals() const { return model_->InstrumentVisuals(); }
  std::vector<AttachmentVisual> AttachmentVisuals() const { return model_->AttachmentVisuals(); }
  std::vector<DuctVisual> DuctVisuals() const { return model_->DuctVisuals(); }
  const Image* Background() const { return model_->Background(); }
  SessionInfo Info() const { return model_->Info(); }
  std::vector<TrainerInput::Instrument> TrainerInstruments() const;
  StatusNames Names() const { return model_->Names(); }

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
  // They are used if the session listens to a teacher.
  SpscQueue<TeacherRequest> teacher_requests{64};
  SpscQueue<LoopEvent> teacher_events{64};
  TripleBuffer<PictureMarks> picture_marks;
  TeacherDesk::Edges TeacherEdges() { return {teacher_requests, picture_marks, teacher_events}; }
  TripleBuffer<SessionHealth> health;
  // Written by a window; without one nothing writes them.
  TripleBuffer<ViewSettings> view_settings;
  /// Targets of the instruments that the mouse moves, null for the others.
  std::array<TripleBuffer<HandTarget>*, kMaxInstruments> hand_targets{};

 private:
  void MakeDevices(const std::vector<TraceFile>& traces);

  std::shared_ptr<const SessionModel> model_;
  std::vector<Points> references_;  // by organ, V x 3, m; 0 rows if none was loaded
  std::vector<DeviceChoice> choices_;
  std::vector<std::unique_ptr<Device>> devices_;
  Nanoseconds trace_length_ = 0;
  std::vector<std::string> remarks_;
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
