#include "engine/step/tip_contact.h"

#include <algorithm>
#include <limits>

#include "engine/mesh/closest_point.h"

namespace hpdm {

ToolPose InOrganFrame(const OrganState& state, ToolPose tool) {
  tool.X_WT.translation() -= state.offset_W;
  tool.p_trocar_W -= state.offset_W;
  return tool;
}

SparseRow VertexRow(const OrganModel& model, int vertex, OrganState* state) {
  const ActiveRefinement& refinement = state->contacts.refinement;
  if (refinement.slots() == 0) return model.LatticeRow(vertex);
  return state->tips.Join(model.LatticeRow(vertex), model.FinerRow(vertex), refinement);
}

void TipContact::UpdateNeighbourhood(const OrganModel& model, OrganState* state) {
  state->neighbourhoods.Collect(model.rest().vertices, at,
                                {ToolPatch::kMaxTriangles, ToolPatch::kMaxPoints}, &around);
}

namespace {

// Adds row i of viscoelastic tissue, whose lattice point is at `x_lattice_W`, to the contact's tip.
// The compliances are those after relaxation.
void AddViscousRow(int i, const Vector3d& x_lattice_W, OrganState* state, TipContact* contact) {
  const ContactConstraints& contacts = state->contacts;
  const ContactConstraints::Row& row = contacts[i];
  const MaxwellMemory::LocalPart& local = state->memory.local(i);
  contact->equilibrium_force_W += local.equilibrium_force_W;
  if (row.kind == ContactConstraints::RowKind::kPress && row.indentation.indents()) {
    const double pressing = std::max(0.0, -row.normal_W.dot(local.equilibrium_force_W));
    contact->C_loc_W = contact->C_wall_W + row.indentation.UnderBall(pressing).Compliance();
  }
  Vector3d relaxed_W = contact->C_loc_W * row.force_W;
  for (int j = 0; j < contacts.size(); ++j) {
    if (j != i) relaxed_W += row.coupled.To(contacts[j].coupled) * contacts[j].force_W;
  }
  auto weights = state->tips.ScratchRow();
  weights = contacts.Weights().row(i);
  const Vector3d slipped_W = row.slip * row.force_W;
  RowMemory memory;
  memory.branches_W = state->memory.BranchesAt(state->tips.Compress(weights));
  memory.excess_W =
      state->memory.Excess(memory.branches_W) + relaxed_W - slipped_W - local.displacement_W;
  for (std::size_t k = 0; k < memory.branches_W.size(); ++k) {
    memory.branches_W[k] += local.branches_W[k];
  }
  state->tips.AddRow(contact->C_loc_W, x_lattice_W + local.displacement_W + slipped_W, row.force_W,
                     row.coupled, memory) = weights;
}

}  // namespace

void AddRowToTip(int i, int owner, bool has_lattice, OrganState* state, TipContact* contact) {
  const ContactConstraints& contacts = state->contacts;
  const ContactConstraints::Row& row = contacts[i];
  contact->force_W += row.force_W;
  // A slipping contact stands off the tissue by its slip compliance; the tick starts there.
  contact->C_wall_W = row.local_compliance_W + row.slip * Matrix3d::Identity();
  contact->C_loc_W = row.LocalCompliance() + row.slip * Matrix3d::Identity();
  contact->indentation = row.indentation;
  if (!has_lattice) return;
  if (contact->tip < 0) contact->tip = state->tips.AddTip(owner);
  const Vector3d x_lattice_W =
      row.p_rest_W + (contacts.Weights().row(i) * state->control_displacements).transpose();
  if (!state->memory.IsElastic()) {
    AddViscousRow(i, x_lattice_W, state, contact);
    return;
  }
  Vector3d x_W = x_lattice_W + contact->C_loc_W * row.force_W;
  for (int j = 0; j < contacts.size(); ++j) {
    if (j != i) x_W += row.coupled.To(contacts[j].coupled) * contacts[j].force_W;
  }
  state->tips.AddRow(contact->C_loc_W, x_W, row.force_W, row.coupled) = contacts.Weights().row(i);
}

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

}  // namespace hpdm
