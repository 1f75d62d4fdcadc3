#include <Eigen/LU>
#include <algorithm>

#include "haptics/contact/haptic_contact.h"
#include "haptics/contact/reaction_force.h"

namespace hpdm {

void HapticContact::LocateGrasp(const TipPose& tip) {
  R_WT_ = tip.X_WT.linear();
  result_.organ = organ_;
  result_.kind = ContactKind::kGrasp;
  if (patch_->reaction == ReactionType::kPaper) {
    const Vector3d p_W = tip.X_WT * (patch_->p_grasp_T + slip_T_ - patch_->slip_T);
    result_.reaction_W = ForceOnHand(patch_->grasp_node, p_W - patch_->p_original_W);
    return;
  }
  in_lattice_ = true;
  tip_ = {.holds = true,
          .p_original_W = patch_->p_original_W,
          .compliance_W = patch_->compliance_W,
          .p_current_W = HeldPoint(tip.X_WT)};
  coupling_W_ = patch_->coupling_W;
  if (!IsViscous()) return;
  if (!memory_.known || !memory_of_grasp_) {
    memory_ = {};
    memory_.known = memory_of_grasp_ = true;
    memory_.tissue = {patch_->contact_W - patch_->series_W * patch_->force_on_tissue_W,
                      patch_->branches_W};
    step_ = MaxwellStep(patch_->prony, std::max(period_, ToSeconds(tip.time_ns - patch_->time_ns)));
  } else if (is_new_) {  // the same tissue, as the new patch describes it
    memory_.tissue.at = HeldPoint(X_WT_last_) - patch_->series_W * force_on_held_W_;
  }
  Vector3d memory_W;
  memory_.tissue.Memory(step_, tip_.p_original_W, &memory_W);
  tip_.p_original_W -= memory_W / step_.stiffening;
  tip_.compliance_W = ComplianceOfTick();
  coupling_W_ /= step_.stiffening;
}

// Returns the point that jaws at this pose hold, moved as their turn since the step acts.
Vector3d HapticContact::HeldPoint(const Isometry3d& X_WT) const {
  const Eigen::AngleAxisd turned(Matrix3d(X_WT.linear() * patch_->R_WT.transpose()));
  return X_WT * (patch_->p_grasp_T + slip_T_ - patch_->slip_T) +
         patch_->turn_W * (turned.angle() * turned.axis());
}

// Returns the part of a force along the jaws' faces, tool frame.
Vector3d HapticContact::AlongFaces(const Vector3d& force_W) const {
  return (R_WT_.transpose() * force_W).cwiseProduct(Vector3d(0, 1, 1));
}

// Returns the way of the held point along the faces (tool frame, m) after which friction can hold
// the rest of this tip's force, if the other tip does nothing.
Vector3d HapticContact::WayInJaws(const Vector3d& force_on_tissue_W) const {
  const Vector3d along_T = AlongFaces(force_on_tissue_W);
  const double pull = along_T.norm();
  if (!tip_.holds || !(pull > patch_->hold)) return Vector3d::Zero();
  const Matrix3d S_T = R_WT_.transpose() * tip_.compliance_W.inverse() * R_WT_;
  const Vector3d excess_T = (1 - patch_->hold / pull) * along_T;
  Vector3d way_T = Vector3d::Zero();
  way_T.tail<2>() = -S_T.bottomRightCorner<2, 2>().inverse() * excess_T.tail<2>();
  return way_T.allFinite() ? way_T : Vector3d::Zero();
}

// Returns the share of a way after which the pull has fallen to what friction holds. The law is
// linear: `before` and `after` are the forces without the way and after all of it.
double HapticContact::ShareOfWay(const Vector3d& before_W, const Vector3d& after_W) const {
  const Vector3d along_T = AlongFaces(before_W);
  const double pull = along_T.norm();
  const double fallen = pull - along_T.dot(AlongFaces(after_W)) / std::max(pull, 1e-300);
  return fallen > 0 ? std::clamp((pull - patch_->hold) / fallen, 0.0, 1.0) : 0;
}

void HapticContact::SlipInJaws(const Vector3d& way_T) {
  way_T_ += way_T;
  tip_.p_current_W += R_WT_ * way_T;
}

// Puts the held point back to where it was in the jaws when the tick began. Each round over the contacts
// finds the slip of the whole tick, so a force that only an early round has leaves none.
void HapticContact::TakeSlipBack() { SlipInJaws(Vector3d(-way_T_)); }

// Ends the tick: its slip stays.
void HapticContact::KeepSlip() {
  slip_T_ += way_T_;
  slip_length_ += way_T_.norm();
  way_T_.setZero();
}

}  // namespace hpdm
