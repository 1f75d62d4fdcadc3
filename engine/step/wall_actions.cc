#include "engine/step/wall_actions.h"

#include <algorithm>

namespace hpdm {

WallActions::WallActions(const std::vector<ToolOptions>& tools) {
  for (const ToolOptions& tool : tools) {
    tools_.push_back({.geometries = tool.geometries});
  }
}

void WallActions::Apply(const ToolState& tools, const JawClosings& jaws, double dt,
                        std::span<const SolvedContact> contacts, std::span<const LayerWork> work,
                        std::vector<OrganStep>* organs) {
  for (std::size_t t = 0; t < ToSize(tools.tool_count); ++t) {
    const ToolPose& pose = tools.tools[t];
    Tool& tool = tools_[t];
    const ToolGeometry& geometry = tool.geometries[ToSize(pose.instrument_index)];
    const SolvedContact& contact = contacts[t];
    const bool burns = geometry.action == ToolAction::kBurn && pose.pedal && !(work[t].burning > 0);
    const bool cuts = geometry.action == ToolAction::kCut && jaws.ClosingFrom(t) > 0;
    // A tip near an organ has a contact there without a force.
    const bool presses = contact.kind == ContactKind::kPress && contact.organ >= 0 &&
                         !contact.force_on_tissue_W.isZero(0);
    if (!presses || !burns) tool.heat = 0;
    if (!presses || (!burns && !cuts)) continue;
    OrganState& organ = (*organs)[ToSize(contact.organ)].state();
    double thickness = 0;
    const int lumen =
        organ.leaks.NearestTo(contact.contact_W - organ.offset_W, organ.vertices, &thickness);
    if (lumen < 0) continue;
    if (cuts && thickness < geometry.JawsLength()) organ.leaks.Perforate(ToSize(lumen));
    if (!burns) continue;
    if (tool.heat == 0 || (contact.contact_W - tool.p_W).norm() > kSamePlace) {
      tool.heat = 0;
      tool.p_W = contact.contact_W;
    }
    tool.heat += geometry.power * std::clamp(dt, 0.0, kLongestBurning);
    if (tool.heat >= kBurning * kHoleArea * thickness) organ.leaks.Perforate(ToSize(lumen));
  }
}

}  // namespace hpdm
