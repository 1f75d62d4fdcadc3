#include "engine/step/grasp.h"

#include <algorithm>

namespace hpdm {
namespace {

// Returns the point of the jaws' axis where the contact's organ touches them; none if it does not.
// Moves the contact there. `X_WT` is in the organ's frame.
std::optional<Vector3d> TouchOnJaws(const Isometry3d& X_WT, const ToolGeometry& geometry,
                                    const OrganModel& model, OrganState* state,
                                    TipContact* contact) {
  if (contact->from_tick || contact->gap <= Grasp::kTouch) return X_WT.translation();
  const Vector3d end = X_WT * JawsEnd(geometry);
  const SurfaceHit hit =
      state->tree.ClosestToSegment(X_WT.translation(), end, geometry.tip_radius + Grasp::kTouch);
  if (hit.at.triangle < 0) return std::nullopt;
  contact->at = hit.at;
  contact->UpdateNeighbourhood(model, state);
  return X_WT.translation() + hit.along * (end - X_WT.translation());
}

}  // namespace

void Grasp::Take(const ToolPose& tool, const ToolGeometry& geometry, const OrganModel& model,
                 OrganState* state, TipContact* contact) {
  const std::optional<Vector3d> middle = TouchOnJaws(tool.X_WT, geometry, model, state, contact);
  if (!middle) return;
  const Triangles& triangles = model.rest().triangles;
  const Isometry3d X_TW = tool.X_WT.inverse();
  points_[count_++] = {contact->at, X_TW * contact->at.Position(state->vertices, triangles)};
  // Each vertex belongs to several triangles: it is taken with the first that lists it.
  std::array<int, kMaxRows> taken;
  int taken_count = 0;
  for (int i = 0; i < contact->around.count; ++i) {
    const int t = contact->around.triangles[i];
    for (int k = 0; k < 3 && count_ < kMaxRows; ++k) {
      const int v = triangles(t, k);
      const auto end = taken.begin() + taken_count;
      const Vector3d p_W = state->vertices.row(v);
      if ((p_W - *middle).norm() > kRadius) continue;
      if (std::find(taken.begin(), end, v) != end) continue;
      taken[taken_count++] = v;
      points_[count_++] = {{t, Vector3d::Unit(k)}, X_TW * p_W};
    }
  }
}

bool Grasp::AddRows(const ToolPose& tool, const OrganModel& model, OrganState* state) const {
  const SurfaceMesh& rest = model.rest();
  for (int i = 0; i < count_; ++i) {
    ContactConstraints::Row* row = state->contacts.Add();
    if (row == nullptr) return false;
    row->kind = ContactConstraints::RowKind::kGrasp;
    row->tool = tool_;
    row->p_rest_W = points_[i].at.Position(rest.vertices, rest.triangles);
    row->target_W = tool.X_WT * points_[i].p_T;
    model.AddToRow(points_[i].at, 1, state->contacts.refinement,
                   state->contacts.WeightRow(state->contacts.size() - 1));
  }
  return true;
}

}  // namespace hpdm
