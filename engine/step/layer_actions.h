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

/// Applies the instruments to the layers of attachments, once a step, where the last step left
/// the organs.
/// A sample of a bed is taken as fibres between its points on the two organs, over its area A.
///
/// 1. A hook whose pedal is pressed heats the samples whose fibres pass within kHeatReach of its tip.
///    The heat P dt burns away the area P dt / e, with e = AttachmentOptions::burn_energy, the
///    nearest sample first. Heat beyond what these samples take is not counted.
/// 2. Scissors that close (kJawGrasps) cut the samples whose fibres cross the plane of the blades
///    within the angle that they opened to since they were last closed.
///
/// The tip of a hook is the ball of its tip_radius. A sample is burnt and cut as a whole: cuts are
/// as fine as the samples, about 2 mm. Deformation thread; allocates nothing after construction.
class LayerActions {
 public:
  static constexpr double kHeatReach = 0.001;       ///< m, from the tip's surface.
  static constexpr double kBladeThickness = 0.002;  ///< m.
  static constexpr double kLongestStep = 0.1;       ///< s: a late step burns no longer than this.

  explicit LayerActions(const std::vector<ToolOptions>& tools);

  /// Applies the tools of a step, `dt` (s) after the last, whose jaws `jaws` follows. Returns the work
  /// of each.
  std::array<LayerWork, kMaxInstruments> Apply(const ToolState& tools, const JawClosings& jaws,
                                               double dt, const std::vector<OrganStep>& organs,
                                               std::span<AttachmentLink> links);

  /// Attachment that the tool's hook would burn where the last step left it; -1: none.
  int InReach(int tool) const { return in_reach_[ToSize(tool)]; }

 private:
  // A sample that an instrument reaches.
  struct Reached {
    AttachmentLink* link = nullptr;
    std::size_t layer = 0;
    int sample = 0;
    double distance = 0;  // m, from the tool's reference
  };
  // The fibres of a sample.
  struct Fibres {
    Vector3d a_W, b_W;  // m
    double radius = 0;  // m, of a disc of the sample's area
  };

  void FindHeated(const ToolPose& tool, const ToolGeometry& geometry,
                  const std::vector<OrganStep>& organs, std::span<AttachmentLink> links);
  double Burn(double energy);
  double Cut(const ToolPose& tool, const ToolGeometry& geometry, double widest,
             const std::vector<OrganStep>& organs, std::span<AttachmentLink> links);
  template <typename Distance>
  void Find(const std::vector<OrganStep>& organs, std::span<AttachmentLink> links,
            const Distance& distance_of);

  std::vector<std::vector<ToolGeometry>> geometries_;  // of each tool
  std::vector<Reached> reached_;                       // of the present tool
  std::array<int, kMaxInstruments> in_reach_{};
};

}  // namespace hpdm
