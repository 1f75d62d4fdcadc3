#include "engine/tool_contact.h"

#include <algorithm>
#include <limits>

#include "engine/closest_point.h"

namespace hpdm {
namespace {

// Rows of presses that are farther away than this would never act in one step.
constexpr double kNear = 0.005;

// Closest point to `p` among the neighbourhood's triangles as they are now.
SurfacePoint ClosestIn(const Neighbourhood& neighbourhood, const Points& vertices,
                       const Triangles& triangles, const Vector3d& p) {
  SurfacePoint best;
  double best2 = std::numeric_limits<double>::infinity();
  for (int i = 0; i < neighbourhood.count; ++i) {
    const int t = neighbourhood.triangles[i];
    const TrianglePoint closest =
        ClosestOnTriangle(p, vertices.row(triangles(t, 0)), vertices.row(triangles(t, 1)),
                          vertices.row(triangles(t, 2)));
    const double distance2 = (closest.point - p).squaredNorm();
    if (distance2 >= best2) continue;
    best2 = distance2;
    best = {t, closest.barycentric};
  }
  return best;
}

// Eq. 29 with the rest neighbours of a vertex and hand-set stiffness (reaction = "paper").
void FillPaperNode(const OrganModel& model, int vertex, const ToolOptions& options,
                   ReactionNode* node) {
  const Triangles& triangles = model.rest().triangles;
  std::array<int, ReactionNode::kMaxNeighbours> ring;
  int count = 0;
  for (int t : model.topology().TrianglesAround(vertex)) {
    for (int k = 0; k < 3; ++k) {
      const int w = triangles(t, k);
      const auto end = ring.begin() + count;
      if (w == vertex || count == ReactionNode::kMaxNeighbours ||
          std::find(ring.begin(), end, w) != end) {
        continue;
      }
      ring[count++] = w;
    }
  }
  node->k1 = options.k1;
  node->neighbour_count = count;
  for (int i = 0; i < count; ++i) {
    const Vector3d edge = model.rest().vertices.row(vertex) - model.rest().vertices.row(ring[i]);
    node->neighbours[i] = {edge, edge.norm(), options.k2};
  }
}

}  // namespace

void ToolContact::Follow(const ToolPose& tool, const std::vector<OrganModel>& models,
                         std::vector<OrganState>* states) {
  FollowTip(tool, models, states);
  UpdateGrasp(tool, models, states);
  p_tip_last_W_ = tool.X_WT.translation();
  jaw_last_ = tool.jaw;
  started_ = true;
}

Vector3d ToolContact::RestPoint(const std::vector<OrganModel>& models) const {
  const SurfaceMesh& rest = models[organ_].rest();
  return at_.Position(rest.vertices, rest.triangles);
}

bool ToolContact::AddContacts(const ToolPose& tool, const std::vector<OrganModel>& models,
                              std::vector<OrganState>* states) {
  bool complete = organ_ < 0 || AddTipRows(tool, models, states);
  shaft_touches_ = false;
  for (std::size_t o = 0; o < models.size(); ++o) {
    complete = AddShaftRow(tool, models[o], &(*states)[o]) && complete;
  }
  return complete;
}

void ToolContact::FollowTip(const ToolPose& tool, const std::vector<OrganModel>& models,
                            std::vector<OrganState>* states) {
  const Vector3d p_tip = tool.X_WT.translation();
  if (!touching_ && grasped_count_ == 0) {
    if (!FindEntry(p_tip, *states) && !FindNearest(p_tip, *states)) return;
    Recentre(models, states);
  }
  const OrganModel& model = models[organ_];
  OrganState& state = (*states)[organ_];
  if (grasped_count_ == 0) {  // else the contact is what the jaws hold
    at_ = ClosestIn(around_, state.vertices, model.rest().triangles, p_tip);
    Recentre(models, states);
  }
  const Vector3d offset = p_tip - at_.Position(state.vertices, model.rest().triangles);
  const Vector3d normal =
      InterpolatedNormal(state.vertices, model.rest().triangles, model.topology(), at_);
  gap_ = (normal.dot(offset) < 0 ? -offset.norm() : offset.norm()) - options_.tip_radius;
}

bool ToolContact::FindEntry(const Vector3d& p_tip_W, const std::vector<OrganState>& states) {
  organ_ = -1;
  double earliest = std::numeric_limits<double>::infinity();
  for (std::size_t o = 0; started_ && o < states.size(); ++o) {
    const SurfaceHit entry = states[o].tree.FirstEntry(p_tip_last_W_, p_tip_W);
    if (entry.at.triangle < 0 || entry.along >= earliest) continue;
    earliest = entry.along;
    organ_ = static_cast<int>(o);
    at_ = entry.at;
  }
  return organ_ >= 0;
}

bool ToolContact::FindNearest(const Vector3d& p_tip_W, const std::vector<OrganState>& states) {
  organ_ = -1;
  double nearest = kReach;
  for (std::size_t o = 0; o < states.size(); ++o) {
    const SurfaceHit hit = states[o].tree.Closest(p_tip_W, nearest);
    if (hit.at.triangle < 0) continue;
    nearest = hit.distance;
    organ_ = static_cast<int>(o);
    at_ = hit.at;
  }
  return organ_ >= 0;
}

void ToolContact::Recentre(const std::vector<OrganModel>& models, std::vector<OrganState>* states) {
  (*states)[organ_].neighbourhoods.Collect(models[organ_].rest().vertices, at_,
                                           ToolPatch::kMaxPoints, &around_);
}

void ToolContact::UpdateGrasp(const ToolPose& tool, const std::vector<OrganModel>& models,
                              std::vector<OrganState>* states) {
  if (tool.jaw > kJawOpen) grasped_count_ = 0;
  const bool closes = started_ && tool.jaw < kJawClosed && jaw_last_ >= kJawClosed;
  if (!options_.can_grasp || !closes || grasped_count_ > 0 || organ_ < 0 || gap_ > kGraspReach) {
    return;
  }
  const OrganModel& model = models[organ_];
  OrganState& state = (*states)[organ_];
  const Triangles& triangles = model.rest().triangles;
  const Isometry3d X_TW = tool.X_WT.inverse();
  grasped_[grasped_count_++] = {at_, X_TW * at_.Position(state.vertices, triangles)};
  // Each vertex belongs to several triangles: take it with the first of those that lists it.
  std::array<int, kMaxGraspRows> taken;
  int taken_count = 0;
  for (int i = 0; i < around_.count; ++i) {
    const int t = around_.triangles[i];
    for (int k = 0; k < 3 && grasped_count_ < kMaxGraspRows; ++k) {
      const int v = triangles(t, k);
      const auto end = taken.begin() + taken_count;
      const Vector3d p_W = state.vertices.row(v);
      if ((p_W - tool.X_WT.translation()).norm() > kGraspRadius) continue;
      if (std::find(taken.begin(), end, v) != end) continue;
      taken[taken_count++] = v;
      grasped_[grasped_count_++] = {{t, Vector3d::Unit(k)}, X_TW * p_W};
    }
  }
}

bool ToolContact::AddTipRows(const ToolPose& tool, const std::vector<OrganModel>& models,
                             std::vector<OrganState>* states) {
  const OrganModel& model = models[organ_];
  OrganState& state = (*states)[organ_];
  const SurfaceMesh& rest = model.rest();
  for (int i = 0; i < grasped_count_; ++i) {
    ContactSet::Row* row = state.contacts.Add();
    if (row == nullptr) return false;
    row->kind = ContactSet::RowKind::kGrasp;
    row->tool = tool_;
    row->p_rest_W = grasped_[i].at.Position(rest.vertices, rest.triangles);
    row->target_W = tool.X_WT * grasped_[i].p_T;
    model.AddToRow(row->p_rest_W, 1, state.contacts.local,
                   state.contacts.WeightRow(state.contacts.size() - 1));
  }
  if (grasped_count_ > 0 || gap_ > kNear) return true;
  const Vector3d normal = InterpolatedNormal(state.vertices, rest.triangles, model.topology(), at_);
  if (normal.squaredNorm() == 0) return true;
  ContactSet::Row* row = state.contacts.Add();
  if (row == nullptr) return false;
  row->tool = tool_;
  row->p_rest_W = at_.Position(rest.vertices, rest.triangles);
  row->normal_W = normal;
  row->target_W = tool.X_WT.translation() - options_.tip_radius * normal;
  model.AddToRow(row->p_rest_W, 1, state.contacts.local,
                 state.contacts.WeightRow(state.contacts.size() - 1));
  return true;
}

bool ToolContact::AddShaftRow(const ToolPose& tool, const OrganModel& model, OrganState* state) {
  const SurfaceMesh& rest = model.rest();
  // The first two diameters belong to the tip.
  const Vector3d start = tool.X_WT * Vector3d(0, 0, 4 * options_.tip_radius);
  const SurfaceHit hit =
      state->tree.ClosestToSegment(start, tool.p_trocar_W, options_.shaft_radius);
  if (hit.at.triangle < 0) return true;
  const Vector3d normal =
      InterpolatedNormal(state->vertices, rest.triangles, model.topology(), hit.at);
  if (normal.squaredNorm() == 0) return true;
  ContactSet::Row* row = state->contacts.Add();
  if (row == nullptr) return false;
  const Vector3d on_axis = start + hit.along * (tool.p_trocar_W - start);
  row->tool = tool_;
  row->shaft = true;
  row->p_rest_W = hit.at.Position(rest.vertices, rest.triangles);
  row->normal_W = normal;
  row->target_W = on_axis - options_.shaft_radius * normal;
  model.AddToRow(row->p_rest_W, 1, state->contacts.local,
                 state->contacts.WeightRow(state->contacts.size() - 1));
  shaft_touches_ = true;
  return true;
}

void ToolContact::FillPatch(const ToolPose& tool, const std::vector<OrganModel>& models,
                            std::vector<OrganState>* states, ToolPatch* patch) {
  patch->organ = organ_;
  patch->kind = ContactKind::kNone;
  patch->point_count = 0;
  patch->triangle_count = 0;
  patch->contact_W = tool.X_WT.translation();
  patch->force_on_tissue_W.setZero();
  patch->shaft_contact = shaft_touches_;
  touching_ = false;
  if (organ_ < 0) return;

  const OrganModel& model = models[organ_];
  OrganState& state = (*states)[organ_];
  const SurfaceMesh& rest = model.rest();
  for (int i = 0; i < state.contacts.size(); ++i) {
    const ContactSet::Row& row = state.contacts[i];
    if (row.tool == tool_ && !row.shaft) patch->force_on_tissue_W += row.force_W;
  }
  touching_ = patch->force_on_tissue_W.squaredNorm() > 0;
  patch->contact_W = at_.Position(state.vertices, rest.triangles);

  patch->kind = ContactKind::kPress;
  std::array<int, ToolPatch::kMaxPoints> vertex;
  for (int i = 0; i < around_.count; ++i) {
    for (int k = 0; k < 3; ++k) {
      const int v = rest.triangles(around_.triangles[i], k);
      const auto end = vertex.begin() + patch->point_count;
      const auto found = std::find(vertex.begin(), end, v);
      patch->triangles[i][k] = static_cast<std::uint8_t>(found - vertex.begin());
      if (found != end) continue;
      PatchPoint& point = patch->points[patch->point_count];
      point.p_original_W = rest.vertices.row(v);
      point.normal_W = model.rest_normals().row(v);
      FillPaperNode(model, v, options_, &point.node);
      vertex[patch->point_count++] = v;
    }
  }
  patch->triangle_count = around_.count;

  if (grasped_count_ == 0) return;
  patch->kind = ContactKind::kGrasp;
  int corner;
  grasped_[0].at.barycentric.maxCoeff(&corner);
  FillPaperNode(model, rest.triangles(grasped_[0].at.triangle, corner), options_,
                &patch->grasp_node);
  patch->p_grasp_original_W = grasped_[0].at.Position(rest.vertices, rest.triangles);
  patch->p_grasp_T = grasped_[0].p_T;
}

}  // namespace hpdm
