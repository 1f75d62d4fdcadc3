#include "engine/step/tool_tracker.h"

#include <limits>

#include "engine/base/check.h"
#include "engine/step/shaft_contact.h"

namespace hpdm {

ToolTracker::ToolTracker(int tool, const ToolOptions& options)
    : tool_(tool),
      reaction_(options.reaction),
      geometries_(options.geometries),
      press_(tool, options.wall_stiffness),
      grasp_(tool),
      patch_builder_(options.prefetch, {.k1 = options.k1, .k2 = options.k2}) {
  HPDM_CHECK(!geometries_.empty());
}

// The haptic loop exchanges only a free tip; a grasp can end here only by the two loops' delay.
void ToolTracker::TakeInstrument(const ToolPose& tool) {
  const auto instrument_index = static_cast<std::size_t>(tool.instrument_index);
  if (instrument_index == instrument_index_) return;
  HPDM_CHECK(instrument_index < geometries_.size());
  instrument_index_ = instrument_index;
  grasp_.Release();
  contact_.touching = false;
  jaw_last_ = tool.jaw;
}

void ToolTracker::Track(const ToolPose& tool, const TickContactPoint& contact_point,
                        std::vector<OrganStep>* organs) {
  TakeInstrument(tool);
  if (tool.jaw > kJawLetsGo) grasp_.Release();
  TrackTip(tool, contact_point, organs);
  UpdateGrasp(tool, organs);
  p_tip_last_W_ = tool.X_WT.translation();
  jaw_last_ = tool.jaw;
  started_ = true;
}

Vector3d ToolTracker::RestPoint(const std::vector<OrganStep>& organs) const {
  const SurfaceMesh& rest = organs[contact_.organ].model().rest();
  return contact_.at.Position(rest.vertices, rest.triangles);
}

void ToolTracker::TrackTip(const ToolPose& tool, const TickContactPoint& contact_point,
                           std::vector<OrganStep>* organs) {
  const Vector3d p_tip_W = tool.X_WT.translation();
  contact_.normal_W.setZero();
  contact_.friction_W.setZero();
  contact_.from_tick = !grasp_.holds() && contact_point.organ >= 0;
  if (contact_.from_tick) {
    contact_.organ = contact_point.organ;
    contact_.at = {contact_point.triangle, contact_point.weights};
    contact_.normal_W = contact_point.normal_W;
    contact_.friction_W = contact_point.friction_W;
  } else if (!grasp_.holds() &&
             (!contact_.touching || contact_point.known_organ == contact_.organ)) {
    if (!FindEntry(p_tip_W, *organs) && !FindNearest(p_tip_W, *organs)) return;
  } else if (!grasp_.holds()) {
    const OrganStep& organ = (*organs)[contact_.organ];
    contact_.at = ClosestIn(contact_.around, organ.state().vertices, organ.model().rest().triangles,
                            p_tip_W - organ.state().offset_W);
  }  // else the contact is the grasp
  const OrganModel& model = (*organs)[contact_.organ].model();
  OrganState& state = (*organs)[contact_.organ].state();
  contact_.UpdateNeighbourhood(model, &state);
  const Vector3d offset =
      p_tip_W - state.offset_W - contact_.at.Position(state.vertices, model.rest().triangles);
  const Vector3d normal =
      InterpolatedNormal(state.vertices, model.rest().triangles, model.topology(), contact_.at);
  contact_.gap = (normal.dot(offset) < 0 ? -offset.norm() : offset.norm()) - geometry().tip_radius;
}

bool ToolTracker::FindEntry(const Vector3d& p_tip_W, const std::vector<OrganStep>& organs) {
  contact_.organ = -1;
  double earliest = std::numeric_limits<double>::infinity();
  for (std::size_t o = 0; started_ && o < organs.size(); ++o) {
    const OrganState& state = organs[o].state();
    const SurfaceHit entry =
        state.tree.FirstEntry(p_tip_last_W_ - state.offset_last_W, p_tip_W - state.offset_W);
    if (entry.at.triangle < 0 || entry.along >= earliest) continue;
    earliest = entry.along;
    contact_.organ = static_cast<int>(o);
    contact_.at = entry.at;
  }
  return contact_.organ >= 0;
}

bool ToolTracker::FindNearest(const Vector3d& p_tip_W, const std::vector<OrganStep>& organs) {
  contact_.organ = -1;
  double nearest = kReach;
  for (std::size_t o = 0; o < organs.size(); ++o) {
    const OrganState& state = organs[o].state();
    const SurfaceHit hit = state.tree.Closest(p_tip_W - state.offset_W, nearest);
    if (hit.at.triangle < 0) continue;
    nearest = hit.distance;
    contact_.organ = static_cast<int>(o);
    contact_.at = hit.at;
  }
  return contact_.organ >= 0;
}

void ToolTracker::UpdateGrasp(const ToolPose& tool, std::vector<OrganStep>* organs) {
  const bool closes = started_ && tool.jaw < Grasp::kJawClosed && jaw_last_ >= Grasp::kJawClosed;
  if (!geometry().can_grasp || !closes || grasp_.holds() || contact_.organ < 0) return;
  OrganStep& organ = (*organs)[contact_.organ];
  if (organ.model().rigid()) return;
  grasp_.Take(InOrganFrame(organ.state(), tool), geometry(), organ.model(), &organ.state(),
              &contact_);
}

bool ToolTracker::AddContacts(const ToolPose& tool, std::vector<OrganStep>* organs) {
  bool complete = contact_.organ < 0 || AddTipRows(tool, &(*organs)[contact_.organ]);
  shaft_touches_ = false;
  const double below = contact_.organ >= 0 ? std::max(-contact_.gap, 0.0) : 0;
  for (OrganStep& organ : *organs) {
    const ShaftContact shaft =
        AddShaftContact(tool_, tool, geometry(), below, organ.model(), &organ.state());
    shaft_touches_ = shaft_touches_ || shaft.touches;
    complete = complete && shaft.complete;
  }
  return complete;
}

bool ToolTracker::AddTipRows(const ToolPose& tool_W, OrganStep* organ) {
  const ToolPose tool = InOrganFrame(organ->state(), tool_W);
  if (grasp_.holds()) return grasp_.AddRows(tool, organ->model(), &organ->state());
  return press_.AddRow(tool, geometry(), organ->model(), &organ->state(), &contact_);
}

void ToolTracker::AddTip(std::vector<OrganStep>* organs) {
  contact_.touching = false;
  contact_.force_W.setZero();
  contact_.C_loc_W.setZero();
  contact_.tip = -1;
  if (contact_.organ < 0) return;
  const OrganModel& model = (*organs)[contact_.organ].model();
  OrganState& state = (*organs)[contact_.organ].state();
  ContactConstraints& contacts = state.contacts;
  const bool has_lattice = model.rigid() || (reaction_ == ReactionType::kLattice &&
                                             state.relaxation->compliance() != nullptr);
  for (int i = 0; i < contacts.size(); ++i) {
    const ContactConstraints::Row& row = contacts[i];
    if (row.tool != tool_ || row.shaft) continue;
    contact_.force_W += row.force_W;
    // A slipping contact stands off the tissue by its slip compliance; the tick starts there.
    contact_.C_loc_W = row.local_compliance_W + row.slip * Matrix3d::Identity();
    if (!has_lattice) continue;
    if (contact_.tip < 0) contact_.tip = state.tips.AddTip();
    const Vector3d x_W = row.p_rest_W +
                         (contacts.Weights().row(i) * state.control_displacements).transpose() +
                         contact_.C_loc_W * row.force_W;
    state.tips.AddRow(contact_.C_loc_W, x_W, row.force_W) = contacts.Weights().row(i);
  }
  contact_.touching = contact_.force_W.squaredNorm() > 0;
  if (!has_lattice || contact_.tip >= 0 || grasp_.holds()) return;
  // Without a row: the tip is too far away in this step, but it may touch before the next one.
  contact_.tip = state.tips.AddTip();
  contact_.C_loc_W = press_.LocalCompliance(model);
  const Vector3d x_W = contact_.at.Position(state.vertices, model.rest().triangles);
  press_.AddKernelToRow(model, state, state.tips.AddRow(contact_.C_loc_W, x_W, Vector3d::Zero()));
}

void ToolTracker::FillPatch(const ToolPose& tool, std::vector<OrganStep>* organs,
                            ToolPatch* patch) {
  PatchBuilder::Clear(tool, patch);
  patch->shaft_contact = shaft_touches_;
  if (contact_.organ < 0) return;
  OrganStep& organ = (*organs)[contact_.organ];
  patch_builder_.Fill(InOrganFrame(organ.state(), tool), geometry(), contact_, grasp_,
                      organ.model(), &organ.state(), patch);
}

}  // namespace hpdm
