#include "tools/haptics/edge_grasp.h"

#include <limits>

#include "engine/organ/organ_state.h"
#include "engine/step/grasp.h"
#include "tools/shared/edge_wedge.h"

namespace hpdm {
namespace {

constexpr double kTurn = 1e-3;  // rad

// Closed jaws on the wedge. Their tips are at the origin.
class HeldEdge {
 public:
  HeldEdge(double edge, int cells, int functions)
      : model_(EdgeWedge::Options(cells, functions), EdgeWedge::Surface(edge)), state_(model_, 1) {
    ActiveRefinement& active = state_.contacts.refinement;
    active.ChooseNearest(model_.refinement_basis()->centres(), {&middle_, 1}, functions);
    state_.relaxation->SetActiveFunctions(active);
    grasp_.Reserve(state_.control_displacements.rows());
    TipContact contact;
    grasp_.Take(ToolPose{}, ToolGeometry{}, TipPress(0, 0, 0), model_, &state_, &contact);
  }

  // Returns the torque (N m) on the tissue for a rotation of the jaws about an axis by kTurn.
  Vector3d Turn(const Vector3d& axis) {
    ToolPose tool;
    tool.X_WT.linear() = Eigen::AngleAxisd(kTurn, axis).toRotationMatrix();
    tool.X_WT.translation() = middle_ - tool.X_WT.linear() * middle_;
    ContactConstraints& contacts = state_.contacts;
    contacts.Clear();
    if (!grasp_.holds() || !grasp_.AddRows(tool, model_, &state_)) {
      return Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
    }
    Points U = Points::Zero(state_.control_displacements.rows(), 3);
    state_.relaxation->Relax(&contacts, &U);
    Vector3d torque = Vector3d::Zero();
    for (int k = 0; k < contacts.size(); ++k) {
      torque += (contacts[k].p_rest_W - middle_).cross(contacts[k].force_W);
    }
    return torque;
  }

 private:
  OrganModel model_;
  OrganState state_;
  Grasp grasp_{0};
  Vector3d middle_ = {0, 0, EdgeWedge::kHeld / 2};
};

}  // namespace

GraspTurns ExactGraspTurns() {
  return {EdgeWedge::kTurnInFaces, EdgeWedge::kTurnAboutEdge, EdgeWedge::kTwist};
}

GraspTurns TurnGrasp(double edge, int cells, int functions) {
  HeldEdge held(edge, cells, functions);
  return {held.Turn(Vector3d::UnitX()).x() / kTurn, held.Turn(Vector3d::UnitY()).y() / kTurn,
          held.Turn(Vector3d::UnitZ()).z() / kTurn};
}

}  // namespace hpdm
