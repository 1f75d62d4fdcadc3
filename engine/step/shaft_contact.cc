#include "engine/step/shaft_contact.h"

namespace hpdm {
namespace {

// Largest cosine between the shaft's axis and the normal where it touches. A shaft that enters the
// surface end on only follows its own tip's indentation.
constexpr double kMaxEndOn = 0.7;

}  // namespace

ShaftContact AddShaftContact(int tool, const ToolPose& pose_W, const ToolGeometry& geometry,
                             double below, const Grasp* grasp, const OrganModel& model,
                             OrganState* state) {
  const ToolPose pose = InOrganFrame(*state, pose_W);
  const SurfaceMesh& rest = model.rest();
  const Vector3d start = pose.X_WT * (JawsEnd(geometry) + Vector3d(0, 0, below));
  const SurfaceHit hit =
      state->tree.ClosestToSegment(start, pose.p_trocar_W, geometry.shaft_radius);
  if (hit.at.triangle < 0) return {};
  const Vector3d p_rest_W = hit.at.Position(rest.vertices, rest.triangles);
  if (grasp != nullptr && grasp->Holds(p_rest_W)) return {};
  const Vector3d facing =
      InterpolatedNormal(state->vertices, rest.triangles, model.topology(), hit.at);
  const Vector3d axis = pose.X_WT.linear().col(2);
  const double end_on = axis.dot(facing);
  if (facing.squaredNorm() == 0 || std::abs(end_on) > kMaxEndOn) return {};
  if (model.rigid()) return {.touches = true};
  const Vector3d normal = (facing - end_on * axis).normalized();
  ContactConstraints::Row* row = state->contacts.Add();
  if (row == nullptr) return {.touches = true, .complete = false};
  const Vector3d on_axis = start + hit.along * (pose.p_trocar_W - start);
  row->tool = tool;
  row->shaft = true;
  row->p_rest_W = p_rest_W;
  row->normal_W = normal;
  row->target_W = on_axis - geometry.shaft_radius * normal;
  model.AddToRow(hit.at, 1, state->contacts.refinement,
                 state->contacts.WeightRow(state->contacts.size() - 1));
  return {.touches = true};
}

}  // namespace hpdm
