#include "engine/step/duct_actions.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/mesh/closest_point.h"
#include "engine/step/grasp.h"
#include "engine/step/patch_builder.h"

namespace hpdm {

DuctActions::DuctActions(const std::vector<ToolOptions>& tools) {
  for (const ToolOptions& options : tools) {
    Tool& tool = tools_.emplace_back();
    tool.geometries = options.geometries;
    for (const ToolGeometry& geometry : options.geometries) tool.clips.push_back(geometry.clips);
  }
}

std::array<DuctAction, kMaxInstruments> DuctActions::Apply(ToolState* tools,
                                                           const JawClosings& jaws,
                                                           std::span<AttachmentLink> links) {
  std::array<DuctAction, kMaxInstruments> actions;
  for (int t = 0; t < tools->tool_count; ++t) {
    const ToolPose& pose = tools->tools[ToSize(t)];
    Tool& tool = tools_[ToSize(t)];
    if (pose.instrument_index != tool.instrument_index) {
      Release(&tool, links);
      tool.instrument_index = pose.instrument_index;
      tool.readout = {};
      const auto index = ToSize(tool.instrument_index);
      tool.clips[index] = tool.geometries[index].clips;
    }
    if (pose.jaw > kJawLetsGo) tool.readout.closed_empty = false;
    if (tool.fills_patch) {
      TickContactPoint& point = tools->contact_points[ToSize(t)][kPlace];
      if (point.slip_T.allFinite()) tool.slip_T = point.slip_T;
      point = {};
    }
    if (tool.held.link >= 0 && pose.jaw > kJawLetsGo) Release(&tool, links);
    const double widest = jaws.ClosingFrom(ToSize(t));
    if (widest > 0 && tool.held.link < 0) {
      actions[ToSize(t)] = Close(pose, widest, tools->time_ns, &tool, links);
    }
    if (tool.held.link >= 0) MoveHeld(pose, &tool, links);
    LookAhead(pose, tool.geometries[ToSize(tool.instrument_index)], links, &tool.readout);
  }
  return actions;
}

// Finds where a duct crosses the plane y = 0 of the tool frame between its jaws: |x| up to `reach_x`,
// or up to `slope` times the distance from the end of the jaws.
DuctActions::Place DuctActions::Between(const Isometry3d& X_WT, double reach_x, double slope,
                                        double length, std::span<AttachmentLink> links) {
  const Isometry3d X_TW = X_WT.inverse();
  Place nearest;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t l = 0; l < links.size(); ++l) {
    const std::span<DuctState> ducts = links[l].ducts();
    for (std::size_t d = 0; d < ducts.size(); ++d) {
      const Rod& rod = ducts[d].rod();
      for (int i = 0; i + 1 < rod.nodes(); ++i) {
        if (!rod.IsSegment(i)) continue;
        const Vector3d a_T = X_TW * rod.node(i), b_T = X_TW * rod.node(i + 1);
        if (a_T.y() * b_T.y() > 0 || a_T.y() == b_T.y()) continue;
        const double share = a_T.y() / (a_T.y() - b_T.y());
        const Vector3d p_T = a_T + share * (b_T - a_T);
        const double reach = reach_x > 0 ? reach_x : slope * (length - p_T.z());
        if (p_T.z() < 0 || p_T.z() > length || std::abs(p_T.x()) > reach) continue;
        const double distance = std::hypot(p_T.x(), p_T.z() - length / 2);
        if (distance >= least) continue;
        least = distance;
        nearest.link = static_cast<int>(l);
        nearest.duct = d;
        nearest.arc = rod.ArcLength(i) + share * (rod.ArcLength(i + 1) - rod.ArcLength(i));
        nearest.p_T = p_T;
        nearest.tangent_T = (b_T - a_T).normalized();
      }
    }
  }
  return nearest;
}

// Returns the duct whose surface is nearest to a point, and its distance.
NearDuct DuctActions::Nearest(const Vector3d& p_W, std::span<AttachmentLink> links) {
  NearDuct nearest{.gap = std::numeric_limits<double>::infinity()};
  for (const AttachmentLink& link : links) {
    for (const DuctState& duct : link.state().ducts()) {
      const Rod& rod = duct.rod();
      for (int i = 0; i + 1 < rod.nodes(); ++i) {
        if (!rod.IsSegment(i)) continue;
        const Vector3d near_W = ClosestPointOnSegment(p_W, rod.node(i), rod.node(i + 1));
        const double gap = (p_W - near_W).norm() - duct.model().options.radius;
        if (gap < nearest.gap) nearest = {duct.model().index, gap};
      }
    }
  }
  return nearest.duct < 0 ? NearDuct() : nearest;
}

std::array<NearDuct, kMaxInstruments> DuctActions::NearHooks(
    const ToolState& tools, std::span<AttachmentLink> links) const {
  std::array<NearDuct, kMaxInstruments> near;
  for (int t = 0; t < tools.tool_count; ++t) {
    const ToolPose& pose = tools.tools[ToSize(t)];
    const ToolGeometry& geometry = tools_[ToSize(t)].geometries[ToSize(pose.instrument_index)];
    if (geometry.action != ToolAction::kBurn || !pose.pedal) continue;
    near[ToSize(t)] = Nearest(pose.X_WT.translation(), links);
    if (near[ToSize(t)].duct >= 0) near[ToSize(t)].gap -= geometry.tip_radius;
  }
  return near;
}

void DuctActions::LetGo(std::span<AttachmentLink> links) {
  for (Tool& tool : tools_) {
    Release(&tool, links);
    tool.fills_patch = false;
  }
}

void DuctActions::FillReadout(int tool, ToolReadout* readout) const {
  const Tool& from = tools_[ToSize(tool)];
  const auto index = ToSize(from.instrument_index);
  const int layer = readout->layer;
  *readout = from.readout;
  readout->layer = layer;
  const bool clips = from.geometries[index].action == ToolAction::kClip;
  readout->clips_left = clips ? from.clips[index] : -1;
}

// `widest`: the opening from which the jaws close.
DuctAction DuctActions::Close(const ToolPose& pose, double widest, Nanoseconds time_ns, Tool* tool,
                              std::span<AttachmentLink> links) {
  const auto index = ToSize(tool->instrument_index);
  const ToolGeometry& geometry = tool->geometries[index];
  const bool clips = geometry.action == ToolAction::kClip;
  if (!geometry.can_grasp && !clips && geometry.action != ToolAction::kCut) return {};
  tool->readout.missed_duct = -1;
  if (clips && tool->clips[index] == 0) {
    tool->readout.closed_empty = true;
    return {};
  }
  const Isometry3d X_WC = pose.X_WT * pose.X_TC;
  const double opening = Grasp::kHalfOpening * geometry.tip_radius;
  Place place = Between(X_WC, geometry.can_grasp ? opening : 0, std::tan(widest * geometry.opening),
                        geometry.JawsLength(), links);
  if (clips) --tool->clips[index];
  if (place.link < 0) {
    if (!geometry.can_grasp) {
      const NearDuct missed = Nearest(X_WC * Vector3d(0, 0, geometry.JawsLength() / 2), links);
      tool->readout.missed_duct = missed.duct;
      tool->readout.missed_by = std::max(0.0, missed.gap);
      tool->readout.missed_ns = time_ns;
    }
    DuctAction action;
    action.kind = clips ? DuctActionKind::kLostClip : DuctActionKind::kNone;
    action.place_W = X_WC.translation();
    return action;
  }
  DuctState& duct = links[ToSize(place.link)].ducts()[place.duct];
  if (geometry.can_grasp) {
    place.node = duct.NodeToHold(place.arc);
    if (place.node < 0) return {};
    tool->held = place;
    tool->p_T = X_WC.inverse() * duct.rod().node(place.node);
    tool->slip_T.setZero();
    return {};
  }
  DuctAction action = MeasureAction(duct, place, geometry.JawsLength());
  action.place_W = X_WC * place.p_T;
  if (clips) {
    action.kind = duct.Clip(place.arc) ? DuctActionKind::kClip : DuctActionKind::kLostClip;
    return action;
  }
  const int node = duct.Cut(place.arc);
  if (node < 0) return {};
  action.kind = DuctActionKind::kCut;
  action.arc = duct.rod().ArcLength(node);
  // The nodes behind the cut have moved on.
  for (Tool& other : tools_) {
    const bool same = other.held.link == place.link && other.held.duct == place.duct;
    if (same && other.held.node > node) ++other.held.node;
  }
  return action;
}

// Jaws flatten the tube across the duct along z: a circle of radius r becomes pi r wide.
DuctAction DuctActions::MeasureAction(const DuctState& duct, const Place& place, double jaws) {
  const DuctModel& model = duct.model();
  const Rod& rod = duct.rod();
  DuctAction action;
  action.duct = model.index;
  action.arc = place.arc;
  action.length = rod.rest_length();
  action.angle = std::acos(std::min(1.0, std::abs(place.tangent_T.y())));
  const double half = std::numbers::pi / 2 * (model.options.radius - model.options.wall);
  const double covered = std::min(place.p_T.z() + half, jaws) - std::max(place.p_T.z() - half, 0.0);
  action.coverage = std::clamp(covered / (2 * half), 0.0, 1.0);
  return action;
}

// Measures the clip that the open jaws of a clip applier would put on now; of scissors the cut likewise.
void DuctActions::LookAhead(const ToolPose& pose, const ToolGeometry& geometry,
                            std::span<AttachmentLink> links, ToolReadout* readout) {
  readout->clip_ahead = {};
  const bool closes = geometry.action == ToolAction::kClip || geometry.action == ToolAction::kCut;
  if (!closes || pose.jaw < kJawGrasps) return;
  const double length = geometry.JawsLength();
  const Place place = Between(pose.X_WT, 0, std::tan(pose.jaw * geometry.opening), length, links);
  if (place.link < 0) return;
  const DuctState& duct = links[ToSize(place.link)].ducts()[place.duct];
  readout->clip_ahead = MeasureAction(duct, place, length);
  const int node = geometry.action == ToolAction::kCut ? duct.NodeToCut(place.arc) : -1;
  readout->clips_beside = duct.ClipsBesideOf(node >= 0 ? duct.rod().ArcLength(node) : place.arc);
  readout->clip_ahead.place_W = pose.X_WT * place.p_T;
  // The jaws' axis y turns into the plane of the shaft and the duct, by less than a quarter turn.
  const Vector3d& along_T = place.tangent_T;
  const double sign = along_T.y() < 0 ? -1 : 1;
  readout->clip_roll = std::atan2(-sign * along_T.x(), sign * along_T.y());
}

// Moves the held node with the jaws. Lets go of one that has left the faces.
void DuctActions::MoveHeld(const ToolPose& pose, Tool* tool,
                           std::span<AttachmentLink> links) const {
  const ToolGeometry& geometry = tool->geometries[ToSize(tool->instrument_index)];
  const Vector3d p_T = tool->p_T + tool->slip_T;
  const bool on_faces =
      std::abs(p_T.y()) <= geometry.tip_radius && p_T.z() >= 0 && p_T.z() <= geometry.JawsLength();
  if (!on_faces) {
    Release(tool, links);
    return;
  }
  links[ToSize(tool->held.link)].ducts()[tool->held.duct].MoveHeld(tool->held.node,
                                                                   pose.X_WT * p_T);
}

void DuctActions::Release(Tool* tool, std::span<AttachmentLink> links) const {
  if (tool->held.link < 0) return;
  links[ToSize(tool->held.link)].ducts()[tool->held.duct].Release(tool->held.node);
  tool->held = {};
}

void DuctActions::FillPatch(int tool, const ToolPose& pose, std::span<AttachmentLink> links,
                            const std::vector<OrganStep>& organs, ToolPatches* patches) {
  Tool& holder = tools_[ToSize(tool)];
  holder.fills_patch = false;
  if (holder.held.link < 0 || patches->main().kind == ContactKind::kGrasp) return;
  AttachmentLink& link = links[ToSize(holder.held.link)];
  const AttachmentJoint::Duct& joined = link.joint().ducts()[holder.held.duct];
  const int member = joined.members[0] >= 0 ? joined.members[0] : joined.members[1];
  const int organ = link.joint().members()[ToSize(member)].organ;
  const Vector3d& offset_W = organs[ToSize(organ)].state().offset_W;
  const DuctState& duct = link.ducts()[holder.held.duct];
  ToolPatch& patch = patches->places[kPlace];
  PatchBuilder::Clear(pose, &patch);
  patch.organ = organ;
  patch.kind = ContactKind::kGrasp;
  patch.reaction = ReactionType::kLattice;
  patch.id = tool * kToolPlaces + static_cast<PlaceId>(kPlace);
  patch.motion = organs[ToSize(organ)].model().options().motion;
  patch.force_on_tissue_W = duct.HoldingForce(holder.held.node);
  patch.contact_W = duct.rod().node(holder.held.node) - offset_W;
  patch.compliance_W = link.ComplianceOf(holder.held.duct, holder.held.node);
  patch.p_original_W = patch.contact_W - patch.compliance_W * patch.force_on_tissue_W;
  const ToolGeometry& geometry = holder.geometries[ToSize(holder.instrument_index)];
  patch.hold = geometry.Hold();
  patch.slip_T = holder.slip_T;
  patch.R_WT = pose.X_WT.linear();
  patch.turn_W.setZero();
  patch.p_grasp_T = pose.X_WT.inverse() * (patch.contact_W + offset_W);
  patches->main_place = static_cast<int>(kPlace);
  holder.fills_patch = true;
}

}  // namespace hpdm
