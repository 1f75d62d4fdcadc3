#pragma once

#include <array>
#include <span>
#include <vector>

#include "engine/attachment/attachment_link.h"
#include "engine/contact/contact_solver.h"
#include "engine/contact/pair_hold.h"
#include "engine/step/organ_step.h"

namespace hpdm {

/// Stage B of a step for all organs. Organs that pairs or attachments connect are solved together,
/// each such group as one contact problem. An organ that sleeps takes part in its group and wakes if
/// a pair presses it or an attachment moves it. Deformation thread; never throws or allocates.
class JointRelaxation {
 public:
  /// `pairs`: pairs of organs in the scene; `links`: the joints of attached organs.
  explicit JointRelaxation(std::size_t pairs, std::vector<AttachmentLink> links = {});

  /// The contacts with other organs that hold organ number `organ` since the last Relax(), and its
  /// number among their bodies; nullptr: none.
  struct Hold {
    const PairHold* hold = nullptr;
    int body = 0;
  };
  const Hold& HoldOn(std::size_t organ) const { return hold_on_[organ]; }

  std::span<const AttachmentLink> links() const { return links_; }
  std::span<AttachmentLink> links() { return links_; }

  /// Relaxes the organs that are awake and their groups, `dt` (s) after the last step. Their tools'
  /// and pairs' rows are complete. `pairs`: OrganContact::body holds the organs' indices; their
  /// forces are filled in. Adds the iterations, residual and flags to `record`.
  void Relax(double dt, std::span<OrganContact> pairs, std::vector<OrganStep>* organs,
             StepRecord* record);

 private:
  void Join(int first, int second);
  void FindGroups(std::span<const OrganContact> pairs, std::size_t organs);
  int GroupOf(std::size_t organ) const;
  std::span<const Vector3d> OffsetsOf(const AttachmentLink& link,
                                      const std::vector<OrganStep>& organs);
  // Solutions of a group in one step: a finite-strain organ may reject the first one.
  enum class Attempt { kOnly, kFirst, kAgain };
  void BeginLinks(const std::vector<OrganStep>& organs, Attempt attempt);
  void RelaxGroup(double dt, std::span<OrganContact> pairs, std::vector<OrganStep>* organs,
                  StepRecord* record);

  ContactSolver solver_;                  // working memory
  std::array<int, kMaxOrgans> parent_{};  // of each organ, in a forest with one tree for a group
  std::size_t count_ = 0;                 // organs of the present group
  std::array<int, kMaxOrgans> group_{};   // their indices
  std::array<BodyInStep, kMaxOrgans> bodies_;
  std::vector<AttachmentLink> links_;
  std::vector<BodyLink*> group_links_;
  std::array<Vector3d, kMaxOrgans> offsets_W_;  // of a link's members, m
  std::vector<OrganContact> group_pairs_;
  std::vector<std::size_t> pair_of_;  // index of each of them among all pairs
  std::vector<PairHold> holds_;       // of the groups with more than one organ
  std::size_t hold_count_ = 0;
  std::array<Hold, kMaxOrgans> hold_on_;
};

}  // namespace hpdm
