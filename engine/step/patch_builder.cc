#include "engine/step/patch_builder.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "engine/mesh/curved_surface.h"
#include "engine/step/tip_press.h"

namespace hpdm {
namespace {

// m. The point on the coarse surface may lie this far from a tip's predicted place.
constexpr double kFarReach = 0.2;

// Eq. 29 with the rest neighbours of a vertex and hand-set stiffness (reaction = "paper").
void FillPaperNode(const OrganModel& model, int vertex, const PaperReaction& reaction,
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
  node->k1 = reaction.k1;
  node->neighbour_count = count;
  for (int i = 0; i < count; ++i) {
    const Vector3d edge = model.rest().vertices.row(vertex) - model.rest().vertices.row(ring[i]);
    node->neighbours[i] = {edge, edge.norm(), reaction.k2};
  }
}

// Returns the position of a vertex with row b after all tips let go and its memory has faded.
Vector3d ReleasedVertex(const SparseRow& b, int vertex, const OrganState& state) {
  Vector3d x_W = state.vertices.row(vertex);
  if (!state.memory.IsElastic()) x_W += state.memory.Excess(state.memory.BranchesAt(b));
  return state.tips.Released(b, x_W);
}

// Returns G with G `from` G^T = `to`; the identity if one of them is not positive definite.
Matrix3d Congruence(const Matrix3d& from, const Matrix3d& to) {
  const Eigen::LLT<Matrix3d> root_from(from), root_to(to);
  if (root_from.info() != Eigen::Success || root_to.info() != Eigen::Success) {
    return Matrix3d::Identity();
  }
  const Matrix3d inverse = root_from.matrixL().solve(Matrix3d::Identity());
  return Matrix3d(root_to.matrixL()) * inverse;
}

// The tips on the organ to which a tip's ticks are coupled, -1: none. A shaft's are coupled by
// ToolPatch::couplings.
struct CoupledTips {
  CoupledTips(const TipContact& contact, const TipCompliance& tips) {
    if (contact.tip < 0 || contact.is_shaft()) return;
    other = tips.OtherTip(contact.tip);
    beside = tips.TipBeside(contact.tip);
  }
  int other = -1;   // another tool's that presses most
  int beside = -1;  // the tool's own
};

Matrix3d Congruent(const Matrix3d& rotation, const Matrix3d& C) {
  return rotation * C * rotation.transpose();
}

struct CondensedPlace {
  Vector3d x_W, p_original_W;
  Matrix3d compliance_W;
  Matrix3d series_W;
  BranchStrains branches_W;
};

// Returns the part of a contact's compliance that does not relax. Beside the neighbours of its organ,
// or in finite strain, it may come out larger than the whole: then what fits into that.
Matrix3d SeriesPart(const Matrix3d& series_W, const Matrix3d& compliance_W) {
  if (series_W.isZero(0)) return series_W;
  const double most = (compliance_W.inverse() * series_W).eigenvalues().real().maxCoeff();
  return most > 1 ? Matrix3d(series_W / most) : series_W;
}

// Returns the contact's condensed tip. A shaft that does not touch has none: then its press alone,
// at rest.
CondensedPlace Condensed(const TipContact& contact, const TipPress& press, const OrganModel& model,
                         OrganState* state) {
  if (contact.tip >= 0) {
    const TipCompliance::Tip& tip = state->tips[contact.tip];
    const Matrix3d compliance_W = state->tips.Between(contact.tip, contact.tip);
    return {tip.x_W, tip.p_original_W, compliance_W,
            SeriesPart(state->memory.InSeries(state->tips.Response(contact.tip)), compliance_W),
            tip.branches_W};
  }
  const Vector3d x_W = contact.at.Position(state->vertices, model.rest().triangles);
  const SparseRow b = press.KernelRow(model, state);
  BranchStrains branches_W = NoBranchStrains();
  Vector3d relaxed_W = x_W;
  if (!state->memory.IsElastic()) {
    branches_W = state->memory.BranchesAt(b);
    relaxed_W += state->memory.Excess(branches_W);
  }
  const Matrix3d compliance_W =
      state->present_compliance->PointCompliance(b.Head(model.control_points()));
  return {x_W, state->tips.Released(b, relaxed_W), compliance_W + contact.C_loc_W,
          state->memory.InSeries(b.Head(model.control_points())), branches_W};
}

}  // namespace

// Fills in the solved contact, and the points' values such that their interpolation at the contact
// gives the contact's own. The compliances vary over the surface as at rest, times a factor for the
// kernel and the tangent stiffness.
void PatchBuilder::FillLatticeContact(const ToolGeometry& geometry, const TipContact& contact,
                                      const TipPress& press, const OrganModel& model,
                                      OrganState* state, ToolPatch* patch) {
  const CondensedPlace place = Condensed(contact, press, model, state);
  patch->reaction = ReactionType::kLattice;
  patch->prony = state->memory.prony();
  patch->series_W = place.series_W;
  patch->branches_W = place.branches_W;
  patch->equilibrium_force_W = contact.equilibrium_force_W;
  patch->contact_W = place.x_W;
  patch->p_original_W = place.p_original_W;
  patch->compliance_W = place.compliance_W;
  const auto [other, beside] = CoupledTips(contact, state->tips);
  const bool has_other = other >= 0, has_beside = beside >= 0;
  if (has_other) {
    patch->coupling_W = state->tips.Between(contact.tip, other);
    patch->other = state->tips[other].owner;
  }
  if (has_beside) {
    patch->to_beside_W = state->tips.Between(contact.tip, beside);
    patch->beside = state->tips[beside].owner;
  }
  if (patch->kind == ContactKind::kGrasp) {
    // For the press that remains if the jaws open.
    patch->indentation = model.Indentation(contact.at, TipPress::KernelRadius(geometry))
                             .Turned(state->relaxation->Rotation());
    return;
  }
  patch->indentation = contact.indentation;
  patch->normal_W = contact.normal_W;
  patch->kernel_radius = TipPress::KernelRadius(geometry);
  if (!model.rigid()) {  // the lattice turns as a whole over the radius that it resolves
    press.GatherTilt(model, contact, state, &normal_);
    patch->tilt_W = normal_.Tilt(model, *state);
    if (contact.tip >= 0) {
      patch->tilt_compliance_W = normal_.Compliance(model, contact.tip, state);
    }
  }

  const Matrix3d rotation = state->relaxation->Rotation();
  Vector3d p_original =
      rotation * CurvedOffset(model.rest(), model.topology(), model.rest_normals(), contact.at);
  Matrix3d compliance = Matrix3d::Zero(), coupling = Matrix3d::Zero();
  Matrix3d to_beside = Matrix3d::Zero();
  for (int k = 0; k < 3; ++k) {
    const int v = model.rest().triangles(contact.at.triangle, k);
    const double weight = contact.at.barycentric[k];
    const SparseRow b = VertexRow(model, v, state);
    p_original += weight * ReleasedVertex(b, v, *state);
    compliance += weight * Congruent(rotation, (*state->vertex_compliances)[v]);
    if (has_other) coupling += weight * state->tips.Coupling(b, other);
    if (has_beside) to_beside += weight * state->tips.Coupling(b, beside);
  }
  const Vector3d further = place.p_original_W - p_original;
  const Vector3d in_series = place.series_W * contact.force_W;
  const Matrix3d G = Congruence(compliance, patch->compliance_W - contact.C_loc_W);
  const Matrix3d more_coupling = patch->coupling_W - coupling;
  const Matrix3d more_to_beside = patch->to_beside_W - to_beside;
  for (SurfacePatch* surface : {static_cast<SurfacePatch*>(patch), &patch->far}) {
    for (int i = 0; i < surface->point_count; ++i) {
      PatchPoint& point = surface->points[i];
      point.p_original_W += further;
      point.tissue_W += further - in_series;
      point.compliance_W = (G * point.compliance_W * G.transpose() + contact.C_wall_W).eval();
      point.coupling_W += more_coupling;
      if (has_beside) point.beside_W += more_to_beside;
    }
  }
}

void PatchBuilder::Clear(const ToolPose& tool_W, ToolPatch* patch) {
  static_cast<SolvedContact&>(*patch) = {};
  patch->organ = -1;
  for (SurfacePatch* surface : {static_cast<SurfacePatch*>(patch), &patch->far}) {
    surface->point_count = surface->triangle_count = surface->node_count = 0;
    surface->Pack();
  }
  patch->id = patch->other = patch->beside = -1;
  patch->coupling_count = 0;
  patch->tilt_W.setZero();
  patch->tilt_compliance_W.setZero();
  patch->prony = {};
  patch->series_W.setZero();
  patch->branches_W = NoBranchStrains();
  patch->equilibrium_force_W.setZero();
  patch->indentation = {};
  patch->contact_W = tool_W.X_WT.translation();
  patch->motion = {};
}

void PatchBuilder::Fill(const ToolPose& tool, const ToolGeometry& geometry,
                        const TipContact& contact, const TipPress& press, const Grasp* grasp,
                        const OrganModel& model, OrganState* state, ToolPatch* patch) {
  patch->organ = contact.organ;
  patch->rigid = model.rigid();
  patch->motion = model.options().motion;
  patch->kind = grasp != nullptr ? ContactKind::kGrasp : ContactKind::kPress;
  patch->force_on_tissue_W = contact.force_W;
  Prefetch(tool, contact, model, state);
  FillSurface(model.rest().triangles, contact, press, model, state, patch);
  std::copy_n(prefetched_.triangles.begin(), prefetched_.count, patch->mesh_triangles.begin());
  if (PrefetchFar(tool, contact, model, state)) {
    FillSurface(model.coarse_surface()->triangles(), contact, press, model, state, &patch->far);
    patch->far.mesh_triangles.fill(-1);
  }
  patch->hold = geometry.Hold();
  patch->slip_T = grasp != nullptr ? grasp->slip_T() : Vector3d::Zero();
  if (contact.tip >= 0 || contact.alone) {
    FillLatticeContact(geometry, contact, press, model, state, patch);
    patch->R_WT = tool.X_WT.linear();
    patch->p_grasp_T = tool.X_WT.inverse() * patch->contact_W;
    if (contact.tip >= 0) patch->turn_W = state->tips[contact.tip].turn_W;
  } else {
    FillPaperContact(contact, grasp, model, *state, patch);
  }
  FillCouplings(contact, press, model, state, patch);
  patch->Pack();
  patch->far.Pack();
}

// Fills in the couplings between the step's places.
void PatchBuilder::FillCouplings(const TipContact& contact, const TipPress& press,
                                 const OrganModel& model, OrganState* state,
                                 ToolPatch* patch) const {
  if (model.rigid() || patch->reaction == ReactionType::kPaper) return;
  const TipCompliance& tips = state->tips;
  SparseRow b;
  if (contact.tip < 0) b = press.KernelRow(model, state);
  for (int t = 0; t < tips.size(); ++t) {
    if (t == contact.tip) continue;
    patch->couplings[patch->coupling_count++] = {
        .to = tips[t].owner,
        .compliance_W = contact.tip >= 0 ? tips.Between(contact.tip, t) : tips.Coupling(b, t)};
  }
}

// Fills in a contact of an organ without lattice forces.
void PatchBuilder::FillPaperContact(const TipContact& contact, const Grasp* grasp,
                                    const OrganModel& model, const OrganState& state,
                                    ToolPatch* patch) const {
  const Triangles& triangles = model.rest().triangles;
  patch->reaction = ReactionType::kPaper;
  patch->contact_W = contact.at.Position(state.vertices, triangles);
  if (grasp == nullptr) return;
  int corner = 0;
  contact.at.barycentric.maxCoeff(&corner);
  FillPaperNode(model, triangles(contact.at.triangle, corner), reaction_, &patch->grasp_node);
  patch->p_original_W = contact.at.Position(model.rest().vertices, triangles);
  patch->p_grasp_T = grasp->ContactInTool();
}

// Gathers the surface around the predicted tip position, with the contact well inside.
void PatchBuilder::Prefetch(const ToolPose& tool, const TipContact& contact,
                            const OrganModel& model, OrganState* state) {
  const SurfaceMesh& rest = model.rest();
  const Vector3d p = contact.at.Position(rest.vertices, rest.triangles);
  double reach2 = 0;
  for (int i = 0; i < contact.around.count; ++i) {
    for (int k = 0; k < 3; ++k) {
      const Vector3d corner = rest.vertices.row(rest.triangles(contact.around.triangles[i], k));
      reach2 = std::max(reach2, (corner - p).squaredNorm());
    }
  }
  Vector3d ahead = state->relaxation->Rotation().transpose() * (prefetch_ * tool.v_tip_W);
  const double longest = std::sqrt(reach2) / 3;
  if (ahead.norm() > longest) ahead *= longest / ahead.norm();
  const SurfacePoint centre = ClosestIn(contact.around, rest.vertices, rest.triangles, p + ahead);
  state->neighbourhoods.Collect(rest.vertices, centre,
                                {ToolPatch::kMaxTriangles, ToolPatch::kMaxPoints}, &prefetched_);
  // Across a sharp edge, or if the triangles ahead are much smaller, the contact may lie outside.
  const auto end = prefetched_.triangles.begin() + prefetched_.count;
  if (std::find(prefetched_.triangles.begin(), end, contact.at.triangle) == end)
    prefetched_ = contact.around;
}

// Gathers the coarse surface around the point where a tip that slides on arrives. False if the
// organ has none.
bool PatchBuilder::PrefetchFar(const ToolPose& tool, const TipContact& contact,
                               const OrganModel& model, OrganState* state) {
  const CoarseSurface* coarse = model.coarse_surface();
  if (coarse == nullptr) return false;
  const SurfaceMesh& rest = model.rest();
  const Matrix3d rotation = state->relaxation->Rotation();
  const Vector3d normal = rotation * contact.at.Position(model.rest_normals(), rest.triangles);
  const Vector3d along =
      rotation.transpose() * (tool.v_tip_W - normal.dot(tool.v_tip_W) * normal);  // at rest
  const Vector3d p = contact.at.Position(rest.vertices, rest.triangles);
  const SurfacePoint centre = coarse->Closest(p + prefetch_ * along, kFarReach);
  if (centre.triangle < 0) return false;
  state->coarse_neighbourhoods->Collect(
      rest.vertices, centre,
      {.triangles = SurfacePatch::kMaxTriangles, .vertices = SurfacePatch::kMaxPoints},
      &prefetched_);
  return true;
}

// Fills in the prefetched triangles and, at their corners, the data that depend on the vertex
// alone. `triangles`: those that the prefetched numbers refer to.
void PatchBuilder::FillSurface(const Triangles& triangles, const TipContact& contact,
                               const TipPress& press, const OrganModel& model, OrganState* state,
                               SurfacePatch* patch) const {
  const bool in_lattice = contact.tip >= 0 || contact.alone;
  std::array<int, SurfacePatch::kMaxPoints> vertex;
  for (int i = 0; i < prefetched_.count; ++i) {
    for (int k = 0; k < 3; ++k) {
      const int v = triangles(prefetched_.triangles[i], k);
      const auto end = vertex.begin() + patch->point_count;
      const auto found = std::find(vertex.begin(), end, v);
      patch->triangles[i][k] = static_cast<std::uint8_t>(found - vertex.begin());
      if (found != end) continue;
      vertex[patch->point_count++] = v;
    }
  }
  patch->triangle_count = prefetched_.count;
  patch->node_count = in_lattice ? 0 : patch->point_count;
  const Matrix3d rotation = state->relaxation->Rotation();
  const auto [other, beside] = CoupledTips(contact, state->tips);
  for (int i = 0; i < patch->point_count; ++i) {
    const int v = vertex[i];
    PatchPoint& point = patch->points[i] = PatchPoint();
    point.normal_W = rotation * model.rest_normals().row(v).transpose();
    if (model.rigid()) point.wall = press.WallAt(model, contact.organ, v);
    if (!in_lattice) {
      point.p_original_W = model.rest().vertices.row(v);
      FillPaperNode(model, v, reaction_, &patch->nodes[i]);
      continue;
    }
    const SparseRow b = VertexRow(model, v, state);
    point.p_original_W = ReleasedVertex(b, v, *state);
    if (!state->memory.IsElastic()) {
      point.tissue_W = state->vertices.row(v);
      point.branches_W = state->memory.BranchesAt(b);
    }
    point.compliance_W = Congruent(rotation, (*state->vertex_compliances)[v]);
    point.coupling_W = other >= 0 ? state->tips.Coupling(b, other) : Matrix3d::Zero();
    if (beside >= 0) point.beside_W = state->tips.Coupling(b, beside);
  }
}

}  // namespace hpdm
