#include "engine/step/tip_press.h"

#include <algorithm>

#include "engine/mesh/curved_surface.h"

namespace hpdm {
namespace {

// m. Largest gap at which a tip's press found by the step gets a row; farther away it does not act.
// A shaft gets one where it reaches into the tissue.
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
  const Matrix3d rotation = state->relaxation->Rotation();
  indentation_ = model.Indentation(contact->at, radius).Turned(rotation);
  resolved_.sample_count = 0;
  resolved_at_.triangle = -1;
  if (!model.rigid()) {
    state->neighbourhoods.Collect(rest.vertices, contact->at,
                                  {.reach = indentation_.resolved_radius()}, &resolved_around_);
    GatherKernel(rest, resolved_around_, contact->at, facing, indentation_.resolved_radius(),
                 &resolved_);
    resolved_at_ = contact->at;
  }
  if (contact->normal_W.squaredNorm() == 0) {
    normal_.Gather(model, contact->at, radius, state);
    contact->normal_W =
        (rotation * facing.stableNormalized() + normal_.Tilt(model, *state)).stableNormalized();
    if (contact->is_shaft()) contact->normal_W = Across(contact->axis_W, contact->normal_W);
  }
  contact->row = -1;
  const double near = contact->is_shaft() ? 0 : kNear;
  const bool too_far = (contact->gap > near || contact->beside) && !contact->from_tick;
  if (too_far || contact->normal_W.squaredNorm() == 0) return true;
  ContactConstraints::Row* row = state->contacts.Add();
  if (row == nullptr) return false;
  contact->row = state->contacts.size() - 1;
  row->tool = tool_;
  row->place = place_;
  row->shaft = contact->is_shaft();
  row->normal_W = contact->normal_W;
  row->friction_W = contact->friction_W;
  row->target_W = tool.X_WT.translation() - geometry.tip_radius * contact->normal_W;
  row->indentation = indentation_;
  row->local_compliance_W = WallCompliance(model, *contact);
  AddKernelToRow(model, *state, state->contacts.WeightRow(contact->row));
  const Vector3d p_rest_W = contact->at.Position(rest.vertices, rest.triangles) +
                            CurvedOffset(rest, model.topology(), model.rest_normals(), contact->at);
  row->p_rest_W = state->TurnedRest(model, p_rest_W, state->contacts.WeightRow(contact->row));
  return true;
}

const WallField* TipPress::Field(const OrganModel& model, int organ) const {
  const auto index = static_cast<std::size_t>(organ);
  if (model.options().wall_stiffness || index >= walls_.size()) return nullptr;
  return walls_[index].rows() > 0 ? &walls_[index] : nullptr;
}

WallStiffness TipPress::UniformWall(const OrganModel& model) const {
  const double stiffness = model.options().wall_stiffness.value_or(wall_stiffness_);
  return {stiffness, stiffness};
}

Matrix3d TipPress::WallCompliance(const OrganModel& model, const TipContact& contact) const {
  if (!model.rigid()) return Matrix3d::Zero();
  const WallField* field = Field(model, contact.organ);
  if (field == nullptr) return UniformWall(model).Compliance(contact.normal_W);
  const Eigen::RowVector3i corners = model.rest().triangles.row(contact.at.triangle);
  Eigen::RowVector2d wall = Eigen::RowVector2d::Zero();
  for (int k = 0; k < 3; ++k) wall += contact.at.barycentric[k] * field->row(corners[k]);
  return WallStiffness{wall[0], wall[1]}.Compliance(contact.normal_W);
}

WallStiffness TipPress::WallAt(const OrganModel& model, int organ, int vertex) const {
  const WallField* field = Field(model, organ);
  if (field == nullptr) return UniformWall(model);
  return {(*field)(vertex, 0), (*field)(vertex, 1)};
}

void TipPress::AddKernelToRow(const OrganModel& model, const OrganState& state,
                              Eigen::Ref<Eigen::RowVectorXd> row) const {
  for (int i = 0; i < resolved_.sample_count; ++i) {
    const SurfaceSample& sample = resolved_.samples[i];
    model.AddToRow({sample.triangle, sample.barycentric}, sample.weight, state.contacts.refinement,
                   row);
  }
}

void TipPress::GatherTilt(const OrganModel& model, const TipContact& contact, OrganState* state,
                          PressNormal* normal) const {
  const double radius = contact.indentation.resolved_radius();
  const bool gathered = resolved_at_.triangle == contact.at.triangle &&
                        resolved_at_.barycentric == contact.at.barycentric &&
                        indentation_.resolved_radius() == radius;
  if (gathered && PressNormal::TakesAll(resolved_around_)) {
    normal->Take(resolved_);
  } else {
    normal->Gather(model, contact.at, radius, state);
  }
}

SparseRow TipPress::KernelRow(const OrganModel& model, OrganState* state) const {
  auto row = state->tips.ScratchRow();
  AddKernelToRow(model, *state, row);
  return state->tips.Compress(row);
}

}  // namespace hpdm
