#include "engine/step/joint_relaxation.h"

#include <algorithm>
#include <utility>

#include "engine/solver/contact_body.h"

namespace hpdm {

JointRelaxation::JointRelaxation(std::size_t pairs, std::vector<AttachmentLink> links)
    : links_(std::move(links)), holds_(std::min(pairs, std::size_t{kMaxOrgans / 2})) {
  group_pairs_.reserve(kMaxContacts);
  pair_of_.reserve(kMaxContacts);
  group_links_.reserve(links_.size());
}

void JointRelaxation::Relax(double dt, std::span<OrganContact> pairs,
                            std::vector<OrganStep>* organs, StepRecord* record) {
  FindGroups(pairs, organs->size());
  hold_count_ = 0;
  hold_on_.fill({});
  for (std::size_t first = 0; first < organs->size(); ++first) {
    if (GroupOf(first) != static_cast<int>(first)) continue;
    bool awake = false;
    count_ = 0;
    for (std::size_t o = first; o < organs->size(); ++o) {
      if (GroupOf(o) != static_cast<int>(first)) continue;
      group_[count_++] = static_cast<int>(o);
      awake = awake || (*organs)[o].state().awake;
    }
    const auto overlaps = [&](const OrganContact& pair) {
      return pair.gap < 0 &&
             GroupOf(static_cast<std::size_t>(pair.body[0])) == static_cast<int>(first);
    };
    awake = awake || std::any_of(pairs.begin(), pairs.end(), overlaps);
    for (const AttachmentLink& link : links_) {
      if (GroupOf(ToSize(link.joint().members()[0].organ)) != static_cast<int>(first)) continue;
      awake = awake || link.acted() || link.IsMovedApart(OffsetsOf(link, *organs));
    }
    if (awake) RelaxGroup(dt, pairs, organs, record);
  }
}

// The root of a group is its first organ.
void JointRelaxation::FindGroups(std::span<const OrganContact> pairs, std::size_t organs) {
  for (std::size_t o = 0; o < organs; ++o) parent_[o] = static_cast<int>(o);
  for (const OrganContact& pair : pairs) Join(pair.body[0], pair.body[1]);
  for (const AttachmentLink& link : links_) {
    for (const auto& member : link.joint().members()) {
      Join(link.joint().members()[0].organ, member.organ);
    }
  }
}

void JointRelaxation::Join(int first, int second) {
  const int a = GroupOf(static_cast<std::size_t>(first));
  const int b = GroupOf(static_cast<std::size_t>(second));
  parent_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
}

std::span<const Vector3d> JointRelaxation::OffsetsOf(const AttachmentLink& link,
                                                     const std::vector<OrganStep>& organs) {
  std::size_t count = 0;
  for (const auto& member : link.joint().members()) {
    offsets_W_[count++] = organs[static_cast<std::size_t>(member.organ)].state().offset_W;
  }
  return {offsets_W_.data(), count};
}

// Lists the links of the present group and begins their step. After a rejected attempt they begin it
// again from the same state.
void JointRelaxation::BeginLinks(const std::vector<OrganStep>& organs, Attempt attempt) {
  group_links_.clear();
  const auto begin = group_.begin(), end = begin + static_cast<std::ptrdiff_t>(count_);
  for (AttachmentLink& link : links_) {
    std::array<int, kMaxOrgans> bodies;
    std::size_t count = 0;
    for (const auto& member : link.joint().members()) {
      const auto found = std::find(begin, end, member.organ);
      if (found != end) bodies[count++] = static_cast<int>(found - begin);
    }
    if (count == 0) continue;
    if (attempt == Attempt::kFirst) link.Keep();
    if (attempt == Attempt::kAgain) link.TakeBack();
    link.Begin(OffsetsOf(link, organs), {bodies.data(), count});
    group_links_.push_back(&link);
  }
}

int JointRelaxation::GroupOf(std::size_t organ) const {
  while (parent_[organ] != static_cast<int>(organ)) {
    organ = static_cast<std::size_t>(parent_[organ]);
  }
  return static_cast<int>(organ);
}

void JointRelaxation::RelaxGroup(double dt, std::span<OrganContact> pairs,
                                 std::vector<OrganStep>* organs, StepRecord* record) {
  const auto organ = [&](std::size_t b) -> OrganStep& {
    return (*organs)[static_cast<std::size_t>(group_[b])];
  };
  for (std::size_t b = 0; b < count_; ++b) organ(b).BeginRelax(dt);
  if (organ(0).state().relaxation->body() == nullptr) {
    organ(0).EndRelax(organ(0).RelaxAlone(), record);
    return;
  }
  const auto begin = group_.begin(), end = begin + static_cast<std::ptrdiff_t>(count_);
  group_pairs_.clear();
  pair_of_.clear();
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const auto body = [&](int index) {
      return static_cast<int>(std::find(begin, end, index) - begin);
    };
    if (std::find(begin, end, pairs[p].body[0]) == end) continue;
    if (group_pairs_.size() == kMaxContacts) break;
    group_pairs_.push_back(pairs[p]);
    group_pairs_.back().body = {body(pairs[p].body[0]), body(pairs[p].body[1])};
    pair_of_.push_back(p);
  }
  const std::span<BodyInStep> bodies(bodies_.data(), count_);
  Attempt attempt = Attempt::kOnly;
  for (std::size_t b = 0; b < count_; ++b) {
    if (organ(b).MayReject()) attempt = Attempt::kFirst;
  }
  for (bool again = true; again; attempt = Attempt::kAgain) {
    for (std::size_t b = 0; b < count_; ++b) {
      bodies[b] = organ(b).Body();
      if (attempt == Attempt::kAgain) bodies[b].body->TakeBack();
    }
    BeginLinks(*organs, attempt);
    RelaxTogether(bodies, group_pairs_, &solver_, group_links_);
    again = false;
    for (std::size_t b = 0; b < count_; ++b) again = organ(b).Rejects(bodies[b].result) || again;
  }
  if (!group_pairs_.empty()) {
    PairHold& hold = holds_[hold_count_++];
    hold.Take(solver_);
    for (std::size_t b = 0; b < count_; ++b) {
      hold_on_[static_cast<std::size_t>(group_[b])] = {&hold, static_cast<int>(b)};
    }
  }
  for (std::size_t b = 0; b < count_; ++b) {
    organ(b).EndRelax(bodies[b].result, record);
    if (!group_links_.empty()) organ(b).WakeIfMoved();
  }
  for (std::size_t p = 0; p < group_pairs_.size(); ++p) {
    OrganContact& pair = pairs[pair_of_[p]];
    group_pairs_[p].body = pair.body;
    pair = group_pairs_[p];
  }
}

}  // namespace hpdm
