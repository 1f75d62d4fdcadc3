#include "engine/step/tool_tracker.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "engine/base/check.h"
#include "engine/mesh/closest_point.h"

namespace hpdm {
namespace {

// m. Largest gap at which a press found by the step gets a row; farther away it does not act.
constexpr double kNear = 0.005;

// Largest cosine between the shaft's axis and the normal where it touches. A shaft that enters the
// surface end on only follows its own tip's indentation.
constexpr double kMaxEndOn = 0.7;

}  // namespace

ToolPose InOrganFrame(const OrganState& state, ToolPose tool) {
  tool.X_WT.translation() -= state.offset_W;
  tool.p_trocar_W -= state.offset_W;
  return tool;
}

ToolTracker::ToolTracker(int tool, const ToolOptions& options)
    : tool_(tool),
      options_(options),
      geometries_{{.tip_radius = options.tip_radius,
                   .shaft_radius = options.shaft_radius,
                   .can_grasp = options.can_grasp}} {
  geometries_.insert(geometries_.end(), options.exchanges.begin(), options.exchanges.end());
}

// The haptic loop exchanges only a free tip; a grasp can end here only by the two loops' delay.
void ToolTracker::TakeInstrument(const ToolPose& tool) {
  const auto instrument_index = static_cast<std::size_t>(tool.instrument_index);
  if (instrument_index == instrument_index_) return;
  HPDM_CHECK(instrument_index < geometries_.size());
  instrument_index_ = instrument_index;
  grasped_count_ = 0;
  touching_ = false;
  jaw_last_ = tool.jaw;
}

void ToolTracker::Track(const ToolPose& tool, const TickContactPoint& contact_point,
                        const std::vector<OrganModel>& models, std::vector<OrganState>* states) {
  TakeInstrument(tool);
  if (tool.jaw > kJawLetsGo) grasped_count_ = 0;
  TrackTip(tool, contact_point, models, states);
  UpdateGrasp(tool, models, states);
  p_tip_last_W_ = tool.X_WT.translation();
  jaw_last_ = tool.jaw;
  started_ = true;
}

Vector3d ToolTracker::RestPoint(const std::vector<OrganModel>& models) const {
  const SurfaceMesh& rest = models[organ_].rest();
  return at_.Position(rest.vertices, rest.triangles);
}

bool ToolTracker::AddContacts(const ToolPose& tool, const std::vector<OrganModel>& models,
                              std::vector<OrganState>* states) {
  bool complete = organ_ < 0 || AddTipRows(tool, models, states);
  shaft_touches_ = false;
  for (std::size_t o = 0; o < models.size(); ++o) {
    complete = AddShaftRow(tool, models[o], &(*states)[o]) && complete;
  }
  return complete;
}

void ToolTracker::TrackTip(const ToolPose& tool, const TickContactPoint& contact_point,
                           const std::vector<OrganModel>& models, std::vector<OrganState>* states) {
  const Vector3d p_tip_W = tool.X_WT.translation();
  normal_.setZero();
  friction_.setZero();
  from_tick_ = grasped_count_ == 0 && contact_point.organ >= 0;
  if (from_tick_) {
    organ_ = contact_point.organ;
    at_ = {contact_point.triangle, contact_point.weights};
    normal_ = contact_point.normal_W;
    friction_ = contact_point.friction_W;
  } else if (grasped_count_ == 0 && (!touching_ || contact_point.known_organ == organ_)) {
    if (!FindEntry(p_tip_W, *states) && !FindNearest(p_tip_W, *states)) return;
  } else if (grasped_count_ == 0) {
    const OrganState& state = (*states)[organ_];
    at_ = ClosestIn(around_, state.vertices, models[organ_].rest().triangles,
                    p_tip_W - state.offset_W);
  }  // else the contact is the grasp
  UpdateNeighbourhood(models, states);
  const OrganModel& model = models[organ_];
  const OrganState& state = (*states)[organ_];
  const Vector3d offset =
      p_tip_W - state.offset_W - at_.Position(state.vertices, model.rest().triangles);
  const Vector3d normal =
      InterpolatedNormal(state.vertices, model.rest().triangles, model.topology(), at_);
  gap_ = (normal.dot(offset) < 0 ? -offset.norm() : offset.norm()) - geometry().tip_radius;
}

SurfacePoint ToolTracker::ClosestIn(const Neighbourhood& neighbourhood, const Points& vertices,
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

bool ToolTracker::FindEntry(const Vector3d& p_tip_W, const std::vector<OrganState>& states) {
  organ_ = -1;
  double earliest = std::numeric_limits<double>::infinity();
  for (std::size_t o = 0; started_ && o < states.size(); ++o) {
    const OrganState& state = states[o];
    const SurfaceHit entry =
        state.tree.FirstEntry(p_tip_last_W_ - state.offset_last_W, p_tip_W - state.offset_W);
    if (entry.at.triangle < 0 || entry.along >= earliest) continue;
    earliest = entry.along;
    organ_ = static_cast<int>(o);
    at_ = entry.at;
  }
  return organ_ >= 0;
}

bool ToolTracker::FindNearest(const Vector3d& p_tip_W, const std::vector<OrganState>& states) {
  organ_ = -1;
  double nearest = kReach;
  for (std::size_t o = 0; o < states.size(); ++o) {
    const SurfaceHit hit = states[o].tree.Closest(p_tip_W - states[o].offset_W, nearest);
    if (hit.at.triangle < 0) continue;
    nearest = hit.distance;
    organ_ = static_cast<int>(o);
    at_ = hit.at;
  }
  return organ_ >= 0;
}

void ToolTracker::UpdateNeighbourhood(const std::vector<OrganModel>& models,
                                      std::vector<OrganState>* states) {
  (*states)[organ_].neighbourhoods.Collect(models[organ_].rest().vertices, at_,
                                           {ToolPatch::kMaxTriangles, ToolPatch::kMaxPoints},
                                           &around_);
}

std::optional<Vector3d> ToolTracker::TouchOnJaws(const Isometry3d& X_WT,
                                                 const std::vector<OrganModel>& models,
                                                 std::vector<OrganState>* states) {
  if (from_tick_ || gap_ <= kTouch) return X_WT.translation();
  const Vector3d end = X_WT * JawsEnd();
  const SurfaceHit hit = (*states)[organ_].tree.ClosestToSegment(X_WT.translation(), end,
                                                                 geometry().tip_radius + kTouch);
  if (hit.at.triangle < 0) return std::nullopt;
  at_ = hit.at;
  UpdateNeighbourhood(models, states);
  return X_WT.translation() + hit.along * (end - X_WT.translation());
}

void ToolTracker::UpdateGrasp(const ToolPose& tool, const std::vector<OrganModel>& models,
                              std::vector<OrganState>* states) {
  const bool closes = started_ && tool.jaw < kJawClosed && jaw_last_ >= kJawClosed;
  if (!geometry().can_grasp || !closes || grasped_count_ > 0 || organ_ < 0) return;
  const OrganModel& model = models[organ_];
  if (model.rigid()) return;
  OrganState& state = (*states)[organ_];
  const Isometry3d X_WT = InOrganFrame(state, tool).X_WT;
  const std::optional<Vector3d> middle = TouchOnJaws(X_WT, models, states);
  if (!middle) return;
  const Triangles& triangles = model.rest().triangles;
  const Isometry3d X_TW = X_WT.inverse();
  grasped_[grasped_count_++] = {at_, X_TW * at_.Position(state.vertices, triangles)};
  // Each vertex belongs to several triangles: it is taken with the first that lists it.
  std::array<int, kMaxGraspRows> taken;
  int taken_count = 0;
  for (int i = 0; i < around_.count; ++i) {
    const int t = around_.triangles[i];
    for (int k = 0; k < 3 && grasped_count_ < kMaxGraspRows; ++k) {
      const int v = triangles(t, k);
      const auto end = taken.begin() + taken_count;
      const Vector3d p_W = state.vertices.row(v);
      if ((p_W - *middle).norm() > kGraspRadius) continue;
      if (std::find(taken.begin(), end, v) != end) continue;
      taken[taken_count++] = v;
      grasped_[grasped_count_++] = {{t, Vector3d::Unit(k)}, X_TW * p_W};
    }
  }
}

bool ToolTracker::AddTipRows(const ToolPose& tool_W, const std::vector<OrganModel>& models,
                             std::vector<OrganState>* states) {
  const OrganModel& model = models[organ_];
  OrganState& state = (*states)[organ_];
  const ToolPose tool = InOrganFrame(state, tool_W);
  const SurfaceMesh& rest = model.rest();
  for (int i = 0; i < grasped_count_; ++i) {
    ContactConstraints::Row* row = state.contacts.Add();
    if (row == nullptr) return false;
    row->kind = ContactConstraints::RowKind::kGrasp;
    row->tool = tool_;
    row->p_rest_W = grasped_[i].at.Position(rest.vertices, rest.triangles);
    row->target_W = tool.X_WT * grasped_[i].p_T;
    model.AddToRow(grasped_[i].at, 1, state.contacts.refinement,
                   state.contacts.WeightRow(state.contacts.size() - 1));
  }
  if (grasped_count_ > 0) return true;
  const Vector3d facing = at_.Position(model.rest_normals(), rest.triangles);
  const double radius = std::max(geometry().tip_radius, kMinKernelRadius);
  indentation_ = model.Indentation(at_, radius);
  resolved_.sample_count = 0;
  if (!model.rigid()) {
    state.neighbourhoods.Collect(rest.vertices, at_, {.reach = indentation_.resolved_radius()},
                                 &resolved_around_);
    GatherKernel(rest, resolved_around_, at_, facing, indentation_.resolved_radius(), &resolved_);
  }
  if (normal_.squaredNorm() == 0) normal_ = KernelNormal(model, state, facing, radius);
  if ((gap_ > kNear && !from_tick_) || normal_.squaredNorm() == 0) return true;
  ContactConstraints::Row* row = state.contacts.Add();
  if (row == nullptr) return false;
  row->tool = tool_;
  row->p_rest_W = at_.Position(rest.vertices, rest.triangles);
  row->normal_W = normal_;
  row->friction_W = friction_;
  row->target_W = tool.X_WT.translation() - geometry().tip_radius * normal_;
  row->indentation = indentation_;
  row->local_compliance_W = LocalCompliance(model);
  AddKernelToRow(model, state, state.contacts.WeightRow(state.contacts.size() - 1));
  return true;
}

// Returns the local compliance of the press under the tip.
Matrix3d ToolTracker::LocalCompliance(const OrganModel& model) const {
  if (!model.rigid()) return indentation_.Compliance();
  return Matrix3d::Identity() / model.options().wall_stiffness.value_or(options_.wall_stiffness);
}

// Returns the kernel-weighted normal of the surface after the last step.
Vector3d ToolTracker::KernelNormal(const OrganModel& model, const OrganState& state,
                                   const Vector3d& facing, double radius) {
  GatherKernel(model.rest(), around_, at_, facing, radius, &kernel_);
  Vector3d normal = Vector3d::Zero();
  for (int i = 0; i < kernel_.vertex_count; ++i) {
    normal += kernel_.weights[i] * VertexNormal(state.vertices, model.rest().triangles,
                                                model.topology(), kernel_.vertices[i]);
  }
  return normal.stableNormalized();
}

// Tissue next to the grasp moves with the jaws. A shaft that pushed it away would lever the grasped
// tissue out of the jaws, with forces far beyond both.
bool ToolTracker::GraspsNearby(const Vector3d& p_rest_W, const ContactConstraints& contacts) const {
  for (int i = 0; i < contacts.size(); ++i) {
    const ContactConstraints::Row& row = contacts[i];
    const bool held = row.tool == tool_ && row.kind == ContactConstraints::RowKind::kGrasp;
    if (held && (row.p_rest_W - p_rest_W).norm() < kGraspRadius) return true;
  }
  return false;
}

bool ToolTracker::AddShaftRow(const ToolPose& tool_W, const OrganModel& model, OrganState* state) {
  const ToolPose tool = InOrganFrame(*state, tool_W);
  const SurfaceMesh& rest = model.rest();
  // The jaws' part, and the part below the surface, belong to the tip.
  const double below = organ_ >= 0 ? std::max(-gap_, 0.0) : 0;
  const Vector3d start = tool.X_WT * (JawsEnd() + Vector3d(0, 0, below));
  const SurfaceHit hit =
      state->tree.ClosestToSegment(start, tool.p_trocar_W, geometry().shaft_radius);
  if (hit.at.triangle < 0) return true;
  const Vector3d p_rest_W = hit.at.Position(rest.vertices, rest.triangles);
  if (GraspsNearby(p_rest_W, state->contacts)) return true;
  const Vector3d facing =
      InterpolatedNormal(state->vertices, rest.triangles, model.topology(), hit.at);
  const Vector3d axis = tool.X_WT.linear().col(2);
  const double end_on = axis.dot(facing);
  if (facing.squaredNorm() == 0 || std::abs(end_on) > kMaxEndOn) return true;
  shaft_touches_ = true;
  if (model.rigid()) return true;  // the hand does not feel the shaft, and nothing moves
  const Vector3d normal = (facing - end_on * axis).normalized();
  ContactConstraints::Row* row = state->contacts.Add();
  if (row == nullptr) return false;
  const Vector3d on_axis = start + hit.along * (tool.p_trocar_W - start);
  row->tool = tool_;
  row->shaft = true;
  row->p_rest_W = p_rest_W;
  row->normal_W = normal;
  row->target_W = on_axis - geometry().shaft_radius * normal;
  model.AddToRow(hit.at, 1, state->contacts.refinement,
                 state->contacts.WeightRow(state->contacts.size() - 1));
  return true;
}

void ToolTracker::AddTip(const std::vector<OrganModel>& models, std::vector<OrganState>* states) {
  touching_ = false;
  force_W_.setZero();
  C_loc_.setZero();
  tip_ = -1;
  if (organ_ < 0) return;
  const OrganModel& model = models[organ_];
  OrganState& state = (*states)[organ_];
  ContactConstraints& contacts = state.contacts;
  const bool has_lattice = model.rigid() || (options_.reaction == ReactionType::kLattice &&
                                             state.relaxation->compliance() != nullptr);
  for (int i = 0; i < contacts.size(); ++i) {
    const ContactConstraints::Row& row = contacts[i];
    if (row.tool != tool_ || row.shaft) continue;
    force_W_ += row.force_W;
    // A slipping contact stands off the tissue by its slip compliance; the tick starts there.
    C_loc_ = row.local_compliance_W + row.slip * Matrix3d::Identity();
    if (!has_lattice) continue;
    if (tip_ < 0) tip_ = state.tips.AddTip();
    const Vector3d x_W = row.p_rest_W +
                         (contacts.Weights().row(i) * state.control_displacements).transpose() +
                         C_loc_ * row.force_W;
    state.tips.AddRow(C_loc_, x_W, row.force_W) = contacts.Weights().row(i);
  }
  touching_ = force_W_.squaredNorm() > 0;
  if (!has_lattice || tip_ >= 0 || grasped_count_ > 0) return;
  // Without a row: the tip is too far away in this step, but it may touch before the next one.
  tip_ = state.tips.AddTip();
  C_loc_ = LocalCompliance(model);
  AddKernelToRow(model, state,
                 state.tips.AddRow(C_loc_, at_.Position(state.vertices, model.rest().triangles),
                                   Vector3d::Zero()));
}

void ToolTracker::AddKernelToRow(const OrganModel& model, const OrganState& state,
                                 Eigen::Ref<Eigen::RowVectorXd> row) const {
  for (int i = 0; i < resolved_.sample_count; ++i) {
    const SurfaceSample& sample = resolved_.samples[i];
    model.AddToRow({sample.triangle, sample.barycentric}, sample.weight, state.contacts.refinement,
                   row);
  }
}

}  // namespace hpdm
