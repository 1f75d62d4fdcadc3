#include "engine/step/tip_press.h"

#include <algorithm>

namespace hpdm {
namespace {

// m. Largest gap at which a press found by the step gets a row; farther away it does not act.
constexpr double kNear = 0.005;

}  // namespace

double TipPress::KernelRadius(const ToolGeometry& geometry) {
  return std::max(geometry.tip_radius, kMinKernelRadius);
}

bool TipPress::AddRow(const ToolPose& tool, const ToolGeometry& geometry, const OrganModel& model,
                      OrganState* state, TipContact* contact) {
  const SurfaceMesh& rest = model.rest();
  const Vector3d facing = contact->at.Position(model.rest_normals(), rest.triangles);
  const double radius = KernelRadius(geometry);
  indentation_ = model.Indentation(contact->at, radius);
  resolved_.sample_count = 0;
  if (!model.rigid()) {
    state->neighbourhoods.Collect(rest.vertices, contact->at,
                                  {.reach = indentation_.resolved_radius()}, &resolved_around_);
    GatherKernel(rest, resolved_around_, contact->at, facing, indentation_.resolved_radius(),
                 &resolved_);
  }
  if (contact->normal_W.squaredNorm() == 0) {
    contact->normal_W = KernelNormal(model, *state, *contact, facing, radius);
  }
  const bool too_far = contact->gap > kNear && !contact->from_tick;
  if (too_far || contact->normal_W.squaredNorm() == 0) return true;
  ContactConstraints::Row* row = state->contacts.Add();
  if (row == nullptr) return false;
  row->tool = tool_;
  row->p_rest_W = contact->at.Position(rest.vertices, rest.triangles);
  row->normal_W = contact->normal_W;
  row->friction_W = contact->friction_W;
  row->target_W = tool.X_WT.translation() - geometry.tip_radius * contact->normal_W;
  row->indentation = indentation_;
  row->local_compliance_W = LocalCompliance(model);
  AddKernelToRow(model, *state, state->contacts.WeightRow(state->contacts.size() - 1));
  return true;
}

Matrix3d TipPress::LocalCompliance(const OrganModel& model) const {
  if (!model.rigid()) return indentation_.Compliance();
  return Matrix3d::Identity() / model.options().wall_stiffness.value_or(wall_stiffness_);
}

void TipPress::AddKernelToRow(const OrganModel& model, const OrganState& state,
                              Eigen::Ref<Eigen::RowVectorXd> row) const {
  for (int i = 0; i < resolved_.sample_count; ++i) {
    const SurfaceSample& sample = resolved_.samples[i];
    model.AddToRow({sample.triangle, sample.barycentric}, sample.weight, state.contacts.refinement,
                   row);
  }
}

// Returns the kernel-weighted normal of the surface after the last step.
Vector3d TipPress::KernelNormal(const OrganModel& model, const OrganState& state,
                                const TipContact& contact, const Vector3d& facing, double radius) {
  GatherKernel(model.rest(), contact.around, contact.at, facing, radius, &kernel_);
  Vector3d normal = Vector3d::Zero();
  for (int i = 0; i < kernel_.vertex_count; ++i) {
    normal += kernel_.weights[i] * VertexNormal(state.vertices, model.rest().triangles,
                                                model.topology(), kernel_.vertices[i]);
  }
  return normal.stableNormalized();
}

}  // namespace hpdm
