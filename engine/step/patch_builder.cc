#include "engine/step/patch_builder.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "engine/step/tip_press.h"

namespace hpdm {
namespace {

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

// Returns G with G `from` G^T = `to`; the identity if one of them is not positive definite.
Matrix3d Congruence(const Matrix3d& from, const Matrix3d& to) {
  const Eigen::LLT<Matrix3d> root_from(from), root_to(to);
  if (root_from.info() != Eigen::Success || root_to.info() != Eigen::Success) {
    return Matrix3d::Identity();
  }
  const Matrix3d inverse = root_from.matrixL().solve(Matrix3d::Identity());
  return Matrix3d(root_to.matrixL()) * inverse;
}

// Returns the lattice's row at a vertex, valid until the next call.
SparseRow VertexRow(const OrganModel& model, int vertex, OrganState* state) {
  const ActiveRefinement& refinement = state->contacts.refinement;
  if (refinement.slots() == 0) return model.LatticeRow(vertex);
  auto row = state->tips.ScratchRow();
  model.AddToRow(model.topology().AtVertex(model.rest().triangles, vertex), 1, refinement, row);
  return state->tips.Compress(row);
}

// Computes the tilt from the contact's triangle, over which the lattice is smooth.
void FillTilt(const TipContact& contact, const OrganModel& model, OrganState* state,
              ToolPatch* patch) {
  const Points& rest = model.rest().vertices;
  const Eigen::RowVector3i corners = model.rest().triangles.row(contact.at.triangle);
  std::array<Vector3d, 3> p_rest, p;
  std::array<Matrix3d, 3> moved;  // corners' displacements, one column per unit force
  for (int k = 0; k < 3; ++k) {
    p_rest[k] = rest.row(corners[k]);
    p[k] = state->vertices.row(corners[k]);
    moved[k] = state->tips.Coupling(VertexRow(model, corners[k], state), contact.tip);
  }
  const Vector3d face_rest = (p_rest[1] - p_rest[0]).cross(p_rest[2] - p_rest[0]);
  const Vector3d a = p[1] - p[0], b = p[2] - p[0];
  const Vector3d face = a.cross(b);
  const double size = face.norm();
  if (!(size > 0) || !(face_rest.squaredNorm() > 0)) return;
  const Vector3d n = face / size;
  patch->tilt_W = n - face_rest.normalized();
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d da = moved[1].col(axis) - moved[0].col(axis);
    const Vector3d db = moved[2].col(axis) - moved[0].col(axis);
    const Vector3d rate = (da.cross(b) + a.cross(db)) / size;
    patch->tilt_compliance_W.col(axis) = rate - n.dot(rate) * n;
  }
}

// Fills in the solved contact, and the points' values such that their interpolation at the contact
// gives the contact's own. The compliances vary over the surface as at rest, times a factor for the
// kernel and the tangent stiffness, plus the local part.
void FillLatticeContact(const ToolGeometry& geometry, const TipContact& contact,
                        const OrganModel& model, OrganState* state, ToolPatch* patch) {
  const TipCompliance::Tip& tip = state->tips[contact.tip];
  patch->reaction = ReactionType::kLattice;
  patch->contact_W = tip.x_W;
  patch->p_original_W = tip.p_original_W;
  patch->compliance_W = state->tips.Between(contact.tip, contact.tip);
  const bool has_other = state->tips.size() > 1;
  if (has_other) patch->coupling_W = state->tips.Between(contact.tip, 1 - contact.tip);
  if (patch->kind == ContactKind::kGrasp) {
    // For the press that remains if the jaws open.
    const Matrix3d C_loc =
        model.Indentation(contact.at, TipPress::KernelRadius(geometry)).Compliance();
    for (int i = 0; i < patch->point_count; ++i) patch->points[i].compliance_W += C_loc;
    return;
  }
  patch->normal_W = contact.normal_W;
  patch->kernel_radius = TipPress::KernelRadius(geometry);
  FillTilt(contact, model, state, patch);

  Vector3d p_original = Vector3d::Zero();
  Matrix3d compliance = Matrix3d::Zero(), coupling = Matrix3d::Zero();
  for (int k = 0; k < 3; ++k) {
    const int v = model.rest().triangles(contact.at.triangle, k);
    const double weight = contact.at.barycentric[k];
    const SparseRow b = VertexRow(model, v, state);
    p_original += weight * state->tips.Released(b, state->vertices.row(v));
    compliance += weight * state->vertex_compliances[v];
    if (has_other) coupling += weight * state->tips.Coupling(b, 1 - contact.tip);
  }
  const Vector3d further = tip.p_original_W - p_original;
  const Matrix3d G = Congruence(compliance, patch->compliance_W - contact.C_loc_W);
  const Matrix3d more_coupling = patch->coupling_W - coupling;
  for (int i = 0; i < patch->point_count; ++i) {
    PatchPoint& point = patch->points[i];
    point.p_original_W += further;
    point.compliance_W = (G * point.compliance_W * G.transpose() + contact.C_loc_W).eval();
    point.coupling_W += more_coupling;
  }
}

}  // namespace

void PatchBuilder::Clear(const ToolPose& tool_W, ToolPatch* patch) {
  static_cast<SolvedContact&>(*patch) = {};
  patch->instrument_index = tool_W.instrument_index;
  patch->organ = -1;
  patch->point_count = 0;
  patch->triangle_count = 0;
  patch->tilt_W.setZero();
  patch->tilt_compliance_W.setZero();
  patch->contact_W = tool_W.X_WT.translation();
  patch->motion = {};
}

void PatchBuilder::Fill(const ToolPose& tool, const ToolGeometry& geometry,
                        const TipContact& contact, const Grasp& grasp, const OrganModel& model,
                        OrganState* state, ToolPatch* patch) {
  const Triangles& triangles = model.rest().triangles;
  patch->organ = contact.organ;
  patch->motion = model.options().motion;
  patch->kind = grasp.holds() ? ContactKind::kGrasp : ContactKind::kPress;
  patch->force_on_tissue_W = contact.force_W;
  Prefetch(tool, contact, model, state);
  FillPoints(contact.tip, model, state, patch);
  if (contact.tip >= 0) {
    FillLatticeContact(geometry, contact, model, state, patch);
    patch->p_grasp_T = tool.X_WT.inverse() * patch->contact_W;
    return;
  }
  patch->reaction = ReactionType::kPaper;
  patch->contact_W = contact.at.Position(state->vertices, triangles);
  if (!grasp.holds()) return;
  const Grasp::Point& first = grasp.first();
  int corner = 0;
  first.at.barycentric.maxCoeff(&corner);
  FillPaperNode(model, triangles(first.at.triangle, corner), reaction_, &patch->grasp_node);
  patch->p_original_W = first.at.Position(model.rest().vertices, triangles);
  patch->p_grasp_T = first.p_T;
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
  Vector3d ahead = prefetch_ * tool.v_tip_W;
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

// Fills in the triangles and, at their corners, the data that depend on the vertex alone.
void PatchBuilder::FillPoints(int tip, const OrganModel& model, OrganState* state,
                              ToolPatch* patch) const {
  const Triangles& triangles = model.rest().triangles;
  std::array<int, ToolPatch::kMaxPoints> vertex;
  for (int i = 0; i < prefetched_.count; ++i) {
    patch->mesh_triangles[i] = prefetched_.triangles[i];
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
  const bool has_other = tip >= 0 && state->tips.size() > 1;
  for (int i = 0; i < patch->point_count; ++i) {
    const int v = vertex[i];
    PatchPoint& point = patch->points[i];
    point.normal_W = model.rest_normals().row(v);
    if (tip < 0) {
      point.p_original_W = model.rest().vertices.row(v);
      FillPaperNode(model, v, reaction_, &point.node);
      continue;
    }
    const SparseRow b = VertexRow(model, v, state);
    point.p_original_W = state->tips.Released(b, state->vertices.row(v));
    point.compliance_W = state->vertex_compliances[v];
    point.coupling_W = has_other ? state->tips.Coupling(b, 1 - tip) : Matrix3d::Zero();
  }
}

}  // namespace hpdm
