#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engine/attachment/attachment_bed.h"
#include "engine/duct/duct_model.h"
#include "engine/organ.h"
#include "engine/step/tool_options.h"
#include "haptics/device/hand_script.h"
#include "haptics/device/impulse_engine.h"
#include "haptics/haptic_loop.h"
#include "lcmtypes/telemetry/session_info.h"
#include "render/image/image.h"
#include "render/instrument/instrument_renderer.h"
#include "render/overlay/status_text.h"
#include "render/render_loop.h"
#include "scenes/generator/shapes/instrument_mesh.h"
#include "scenes/loader/scene.h"
#include "tools/session/contact_stiffness.h"
#include "tools/session/virtual_wall.h"

namespace hpdm {

/// Throws InputError if an organ of the scene has a cut: the drawn surface, the tick's patch and the
/// log know no cuts. A session that only `hpdm check` looks at may have them.
void RefuseCuts(const Scene& scene);

/// The constant part of a session: what is built once from a scene, and what any number of sessions
/// share. Any thread may read it.
class SessionModel {
 public:
  /// Hears, before each slow part of the construction, what is being built.
  using Progress = std::function<void(const std::string& what)>;
  /// Builds the model of `scene`. `progress` may be null. Throws InputError.
  explicit SessionModel(Scene scene, const Progress& progress = nullptr);
  SessionModel(const SessionModel&) = delete;
  SessionModel& operator=(const SessionModel&) = delete;

  /// Returns the model of the same scene in which organ number `organ` has Young's modulus `young`
  /// (Pa) and everything else is shared: that of a scene file with this value. Throws InputError.
  std::shared_ptr<const SessionModel> WithYoung(std::size_t organ, double young) const;

  const Scene& scene() const { return scene_; }
  /// False for a model of WithYoung().
  bool IsOfSceneFile() const { return is_of_scene_file_; }
  const std::vector<OrganModel>& organs() const { return organs_; }
  /// The beds of the scene's attachments.
  const std::vector<AttachmentBed>& beds() const { return beds_; }
  /// The scene's ducts, at rest.
  const std::vector<DuctModel>& ducts() const { return ducts_; }
  /// The weight that each bed's layer bears at the start, as a force on its organ b, N.
  const std::vector<Vector3d>& borne_W() const { return borne_W_; }
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
  /// The same of instrument number `instrument`.
  const HandSite& site(std::size_t instrument) const { return sites_[instrument]; }
  const ImpulseEngineKinematics& kinematics(std::size_t instrument) const {
    return kinematics_[instrument];
  }
  /// Returns the virtual wall of each instrument; empty if the scene has no rigid organ.
  const std::vector<VirtualWall>& walls() const { return walls_; }

  Nanoseconds haptic_period_ns() const { return kNanosecondsPerSecond / scene_.timing.haptic_hz; }

  // Inputs of the loops.
  std::vector<HapticInstrument> HapticInstruments(
      const std::vector<std::unique_ptr<Device>>& devices) const;
  std::vector<ToolOptions> DeformationTools() const;
  std::vector<AttachmentVisual> AttachmentVisuals() const;
  std::vector<DuctVisual> DuctVisuals() const;
  std::vector<OrganVisual> OrganVisuals() const;
  std::vector<InstrumentVisual> InstrumentVisuals() const;
  const Image* Background() const;  ///< Null if the scene has none.
  SessionInfo Info() const;
  StatusNames Names() const;

 private:
  SessionModel(const SessionModel& other, std::size_t organ, double young);
  void ReadPictures();
  void BuildBeds();
  void BuildDucts();
  void BuildOrgans(const Progress& progress);
  void CheckTip(const InstrumentDescription& held) const;
  void BuildInstruments();
  void CompareStiffness(const Progress& progress);
  void BuildWalls();

  // What does not depend on the tissue's stiffness. Shared by the models of WithYoung().
  struct Pictures {
    Image background;             // empty if the scene names none
    std::vector<Image> textures;  // by organ; empty if it names none
    std::vector<std::vector<InstrumentMeshes>>
        instruments;  // [instrument][ToolPose::instrument_index]
  };

  Scene scene_;
  bool is_of_scene_file_ = true;
  std::shared_ptr<Pictures> pictures_;
  std::vector<OrganModel> organs_;
  std::vector<AttachmentBed> beds_;
  std::vector<DuctModel> ducts_;
  std::vector<Vector3d> borne_W_;
  std::vector<HandSite> sites_;  // by instrument
  std::vector<ImpulseEngineKinematics> kinematics_;
  std::vector<std::string> remarks_;
  std::vector<ContactFact> contacts_;
  std::vector<VirtualWall> walls_;
};

}  // namespace hpdm
