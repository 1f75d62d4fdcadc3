#include "engine/step/joint_relaxation.h"

#include <algorithm>

#include "engine/solver/contact_body.h"

namespace hpdm {

JointRelaxation::JointRelaxation(std::size_t pairs)
    : holds_(std::min(pairs, std::size_t{kMaxOrgans / 2})) {
  group_pairs_.reserve(kMaxContacts);
  pair_of_.reserve(kMaxContacts);
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
    if (awake) RelaxGroup(dt, pairs, organs, record);
  }
}

// The root of a group is its first organ.
void JointRelaxation::FindGroups(std::span<const OrganContact> pairs, std::size_t organs) {
  for (std::size_t o = 0; o < organs; ++o) parent_[o] = static_cast<int>(o);
  for (const OrganContact& pair : pairs) {
    const int a = GroupOf(static_cast<std::size_t>(pair.body[0]));
    const int b = GroupOf(static_cast<std::size_t>(pair.body[1]));
    parent_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
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
  for (bool again = true; again;) {
    for (std::size_t b = 0; b < count_; ++b) bodies[b] = organ(b).Body();
    RelaxTogether(bodies, group_pairs_, &solver_);
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
  for (std::size_t b = 0; b < count_; ++b) organ(b).EndRelax(bodies[b].result, record);
  for (std::size_t p = 0; p < group_pairs_.size(); ++p) {
    OrganContact& pair = pairs[pair_of_[p]];
    group_pairs_[p].body = pair.body;
    pair = group_pairs_[p];
  }
}

}  // namespace hpdm
