#include "engine/step/tip_contact.h"

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
  auto row = state->tips.ScratchRow();
  model.AddToRow(model.topology().AtVertex(model.rest().triangles, vertex), 1, refinement, row);
  return state->tips.Compress(row);
}

void TipContact::UpdateNeighbourhood(const OrganModel& model, OrganState* state) {
  state->neighbourhoods.Collect(model.rest().vertices, at,
                                {ToolPatch::kMaxTriangles, ToolPatch::kMaxPoints}, &around);
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
