#pragma once

#include <array>
#include <span>
#include <vector>

#include "engine/attachment/attachment_link.h"
#include "engine/snapshots.h"
#include "engine/step/jaw_closings.h"
#include "engine/step/organ_step.h"
#include "engine/step/tool_options.h"

namespace hpdm {

/// Applies the instruments to ducts, once a step, where the last step left them.
///
/// 1. Jaws that close (kJawGrasps) act on the duct that crosses the plane y = 0 of the tool frame between
///    them, the crossing nearest to the middle of the jaws.
/// 2. A grasper holds the duct's nearest node, which then moves with the jaws until they open
///    (kJawLetsGo) or it has slipped out of their faces. The hand feels it (FillPatch), unless the jaws
///    hold an organ's tissue too.
/// 3. Scissors cut it where it lies within the angle that they opened to since they were last closed. A
///    clip applier closes the lumen there, as long as its magazine has clips. It loses a clip where it
///    closes on no duct. An applier that the hand exchanges for another instrument and takes again has a
///    full magazine.
///
/// Deformation thread; allocates nothing after construction.
class DuctActions {
 public:
  /// The tip's place whose patch is that of a held duct.
  static constexpr std::size_t kPlace = kMaxPlaces - 1;

  explicit DuctActions(const std::vector<ToolOptions>& tools);

  /// Applies the tools of a step, whose jaws `jaws` follows. The contact point of a held duct is taken
  /// out of `tools`. Returns the clips and cuts of each tool.
  std::array<DuctAction, kMaxInstruments> Apply(ToolState* tools, const JawClosings& jaws,
                                                std::span<AttachmentLink> links);
  /// Finds the duct that is nearest to the tip of each energised hook, where the last step left it.
  std::array<NearDuct, kMaxInstruments> NearHooks(const ToolState& tools,
                                                  std::span<AttachmentLink> links) const;
  /// Fills the patch of the duct that a tool holds, after the step.
  void FillPatch(int tool, const ToolPose& pose, std::span<AttachmentLink> links,
                 const std::vector<OrganStep>& organs, ToolPatches* patches);
  /// True if the tool's last patch at kPlace is that of a duct.
  bool FillsPatch(int tool) const { return tools_[ToSize(tool)].fills_patch; }
  /// Lets go of all ducts.
  void LetGo(std::span<AttachmentLink> links);
  /// Fills in what a display shows of the tool's magazine and of the duct that it missed.
  void FillReadout(int tool, ToolReadout* readout) const;

 private:
  // A node of a duct, or a place on one.
  struct Place {
    int link = -1;
    std::size_t duct = 0;
    double arc = 0;  // m, at rest
    int node = -1;
    Vector3d p_T = Vector3d::Zero();        // of the crossing, m
    Vector3d tangent_T = Vector3d::Zero();  // of the duct there, unit
  };
  struct Tool {
    std::vector<ToolGeometry> geometries;
    std::vector<int> clips;  // left, of each instrument
    int instrument_index = 0;
    ToolReadout readout;
    Place held;
    bool fills_patch = false;
    Vector3d p_T = Vector3d::Zero();     // of the held node as the jaws closed, m
    Vector3d slip_T = Vector3d::Zero();  // m
  };

  DuctAction Close(const ToolPose& pose, double widest, Nanoseconds time_ns, Tool* tool,
                   std::span<AttachmentLink> links);
  static NearDuct Nearest(const Vector3d& p_W, std::span<AttachmentLink> links);
  static void LookAhead(const ToolPose& pose, const ToolGeometry& geometry,
                        std::span<AttachmentLink> links, ToolReadout* readout);
  static DuctAction MeasureAction(const DuctState& duct, const Place& place, double jaws);
  void MoveHeld(const ToolPose& pose, Tool* tool, std::span<AttachmentLink> links) const;
  void Release(Tool* tool, std::span<AttachmentLink> links) const;
  static Place Between(const Isometry3d& X_WT, double reach_x, double slope, double length,
                       std::span<AttachmentLink> links);

  std::vector<Tool> tools_;
};

}  // namespace hpdm
