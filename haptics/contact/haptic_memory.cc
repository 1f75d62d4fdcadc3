#include <algorithm>
#include <cmath>

#include "haptics/contact/haptic_contact.h"

namespace hpdm {
namespace {

// s. A contact that has carried no force for so long takes up the memory of the newest patch, which
// knows of its end: two steps at 30 Hz, and the delay of a patch.
constexpr double kForgets = 0.15;

}  // namespace

bool HapticContact::IsViscous() const {
  return organ_ >= 0 && patch_->prony.count > 0 && patch_->reaction == ReactionType::kLattice;
}

Vector3d HapticContact::PositionOf(const Place& place) const {
  return (place.on_far ? far_surface() : mesh_surface()).Position(place.foot);
}

// Returns how far the curved surface lies outside of its flat triangle, m.
Vector3d HapticContact::OffsetOf(const Place& place) const {
  return (place.on_far ? far_surface() : mesh_surface()).Offset(place.foot);
}

// Returns the tissue as the patch's step left it, held in place since then.
MaxwellState<Vector3d> HapticContact::TissueOfPatch(const Place& place) const {
  MaxwellState<Vector3d> tissue{At(place, &PatchPoint::tissue_W) + OffsetOf(place),
                                NoBranchStrains()};
  const auto& points = place.on_far ? patch_->far.points : patch_->points;
  const double age = std::max(0.0, ToSeconds(time_ns_ - patch_->time_ns));
  for (int i = 0; i < patch_->prony.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    for (int j = 0; j < 3; ++j) {
      tissue.branches[k] += place.foot.weights[j] *
                            points[place.foot.corners[static_cast<std::size_t>(j)]].branches_W[k];
    }
    tissue.branches[k] *= std::exp(-age / patch_->prony.terms[k].time);
  }
  return tissue;
}

HapticContact::Memory HapticContact::MemoryAtFoot() const {
  const Place here{on_far_, foot_};
  if (!memory_.known || memory_of_grasp_) return {true, TissueOfPatch(here), {}};
  const double way = (PositionOf(here) - p_memory_W_).norm();
  if (way == 0) return memory_;
  Memory memory{true, TissueOfPatch(here), memory_.dent};
  const double kept = std::exp(-way / patch_->indentation.resolved_radius());
  memory.tissue.at += kept * (memory_.tissue.at - patch_tissue_.at);
  for (std::size_t k = 0; k < memory.tissue.branches.size(); ++k) {
    memory.tissue.branches[k] += kept * (memory_.tissue.branches[k] - patch_tissue_.branches[k]);
  }
  memory.dent.Slide(way, patch_->indentation.radius());
  return memory;
}

// Finds the remembered tissue on a new patch.
void HapticContact::FindMemoryAgain() {
  SurfaceFoot& foot = memory_place_.foot;
  const Vector3d weights = foot.weights;
  memory_place_.on_far = !mesh_surface().Has(foot.mesh_triangle) && !far_surface().empty() &&
                         !mesh_surface().Covers(p_memory_W_) &&
                         far_surface().Find(-1, weights, p_memory_W_, &foot);
  memory_.known =
      memory_place_.on_far || mesh_surface().Find(foot.mesh_triangle, weights, p_memory_W_, &foot);
  if (!memory_.known) return;
  p_memory_W_ = PositionOf(memory_place_);
  patch_tissue_ = TissueOfPatch(memory_place_);
}

// Returns the compliance of viscoelastic tissue to a force of this tick, with the part in series.
Matrix3d HapticContact::ComplianceOfTick() const {
  return (tip_.compliance_W + (step_.stiffening - 1) * patch_->series_W) / step_.stiffening;
}

// Sets what the tissue at the foot shows to a force of this tick.
void HapticContact::ApplyMemory() {
  present_ = MemoryAtFoot();
  Vector3d memory_W, dent_W;
  present_.tissue.Memory(step_, tip_.p_original_W, &memory_W);
  p_free_W_ = tip_.p_original_W - memory_W / step_.stiffening;
  tip_.indentation = present_.dent.Law(patch_->indentation, step_, &dent_W);
  tip_.p_original_W = p_free_W_ + dent_W;
  tip_.compliance_W = ComplianceOfTick();
  coupling_W_ /= step_.stiffening;
}

// Ends the tick of viscoelastic tissue. `moved_W`: displacement by the other tip, m.
void HapticContact::Remember(const Vector3d& force_on_tissue_W, const Vector3d& moved_W) {
  if (!IsViscous()) return;
  if (!in_lattice_) {
    if (memory_.known) Recover();
    return;
  }
  if (tip_.holds) {
    force_on_held_W_ = force_on_tissue_W;
    memory_.tissue.Advance(step_, tip_.p_current_W - patch_->series_W * force_on_tissue_W);
    return;
  }
  unpressed_ = force_on_tissue_W.squaredNorm() > 0 || !memory_.known ? 0 : unpressed_ + period_;
  memory_ = present_;
  const Matrix3d of_tissue_W = tip_.compliance_W - patch_->series_W;
  memory_.tissue.Advance(step_, p_free_W_ + of_tissue_W * force_on_tissue_W + moved_W);
  memory_.dent.Advance(step_, force_on_tissue_W);
  memory_.known = unpressed_ < kForgets;
  memory_place_ = {on_far_, foot_};
  p_memory_W_ = PositionOf(memory_place_);
  patch_tissue_ = TissueOfPatch(memory_place_);
}

// The tissue where the tip has been returns by itself.
void HapticContact::Recover() {
  unpressed_ += period_;
  memory_.known = unpressed_ < kForgets;
  const Vector3d p_inf_W = At(memory_place_, &PatchPoint::p_original_W) + OffsetOf(memory_place_);
  Vector3d memory_W;
  memory_.tissue.Memory(step_, p_inf_W, &memory_W);
  memory_.tissue.Advance(step_, p_inf_W - memory_W / step_.stiffening);
  memory_.dent.Advance(step_, Vector3d::Zero());
}

}  // namespace hpdm
