#include "engine/step/organ_contacts.h"

#include <algorithm>

#include "engine/base/check.h"
#include "engine/step/demanded_move.h"

namespace hpdm {
namespace {

// Fills a pair's row with the weighted mean of its samples on one organ.
template <class PointOf>
void FillRow(const PairContact& contact, PointOf point_of, OrganStep* organ,
             ContactConstraints::Row* row) {
  const OrganModel& model = organ->model();
  OrganState& state = organ->state();
  row->p_rest_W.setZero();
  auto weights = state.contacts.WeightRow(state.contacts.size() - 1);
  for (const PairSample& sample : contact.samples) {
    const SurfacePoint& at = point_of(sample);
    row->p_rest_W += sample.weight * at.Position(model.rest().vertices, model.rest().triangles);
    model.AddToRow(at, sample.weight, state.contacts.refinement, weights);
  }
  row->target_W = row->p_rest_W;
}

PairShape ShapeOf(const OrganState& state) {
  return {state.vertices, state.tree, state.offset_W, LongestDemandedMove(state)};
}

Vector3d Displacement(int row, const OrganState& state) {
  return (state.contacts.Weights().row(row) * state.control_displacements).transpose();
}

}  // namespace

OrganContacts::Pair::Pair(const OrganModel& first, const OrganModel& second,
                          std::array<int, 2> indices, double coefficient)
    : organs(indices), friction(coefficient), search(first, second) {
  pressed.reserve(OrganPair::kMaxPatches);
}

OrganContacts::OrganContacts(const std::vector<OrganModel>& organs) {
  for (std::size_t a = 0; a < organs.size(); ++a) {
    for (const OrganContactOptions& contact : organs[a].options().contacts) {
      for (std::size_t b = 0; b < organs.size(); ++b) {
        if (organs[b].options().name != contact.with) continue;
        HPDM_CHECK(a != b && TakesOrganContacts(organs[a].options()) &&
                   TakesOrganContacts(organs[b].options()));
        pairs_.emplace_back(organs[a], organs[b],
                            std::array{static_cast<int>(a), static_cast<int>(b)}, contact.friction);
      }
    }
  }
  contacts_.reserve(pairs_.size() * OrganPair::kMaxPatches);
  pair_of_.reserve(contacts_.capacity());
}

void OrganContacts::Wait(const std::array<int, 2>& organs) {
  for (Pair& pair : pairs_) {
    if (pair.organs == organs || pair.organs == std::array{organs[1], organs[0]}) pair.waits = true;
  }
}

void OrganContacts::Begin(int organ) {
  for (Pair& pair : pairs_) {
    if (pair.organs[0] == organ || pair.organs[1] == organ) pair.waits = false;
  }
}

bool OrganContacts::AddRows(std::vector<OrganStep>* organs) {
  contacts_.clear();
  pair_of_.clear();
  bool complete = true;
  for (std::size_t p = 0; p < pairs_.size(); ++p) complete = AddPair(p, organs) && complete;
  return complete;
}

bool OrganContacts::AddPair(std::size_t p, std::vector<OrganStep>* organs) {
  Pair& pair = pairs_[p];
  if (pair.waits) return true;
  const OrganState& first = (*organs)[static_cast<std::size_t>(pair.organs[0])].state();
  const OrganState& second = (*organs)[static_cast<std::size_t>(pair.organs[1])].state();
  const Vector3d between_W = second.offset_W - first.offset_W;
  if (!first.awake && !second.awake && between_W == pair.between_W) return true;
  pair.between_W = between_W;
  bool complete = true;
  for (const PairContact& found : pair.search.Update(ShapeOf(first), ShapeOf(second))) {
    complete = complete && AddContact(found, pair, organs);
    if (!complete) break;
    pair_of_.push_back(p);
  }
  return complete && pair.search.complete();
}

bool OrganContacts::AddContact(const PairContact& found, const Pair& pair,
                               std::vector<OrganStep>* organs) {
  OrganStep& first = (*organs)[static_cast<std::size_t>(pair.organs[0])];
  OrganStep& second = (*organs)[static_cast<std::size_t>(pair.organs[1])];
  ContactConstraints::Row* const on_first = first.state().contacts.AddPair();
  if (on_first == nullptr) return false;
  ContactConstraints::Row* const on_second = second.state().contacts.AddPair();
  if (on_second == nullptr) {
    first.state().contacts.DropLast();
    return false;
  }
  FillRow(
      found, [](const PairSample& s) -> const SurfacePoint& { return s.on_a; }, &first, on_first);
  FillRow(
      found, [](const PairSample& s) -> const SurfacePoint& { return s.on_b; }, &second, on_second);
  on_first->normal_W = found.normal_W;
  on_second->normal_W = -found.normal_W;
  OrganContact contact;
  contact.key = found.key;
  contact.body = pair.organs;
  contact.row = {first.state().contacts.size() - 1, second.state().contacts.size() - 1};
  contact.normal_W = found.normal_W;
  contact.friction = pair.friction;
  const Vector3d apart_W =
      Displacement(contact.row[1], second.state()) - Displacement(contact.row[0], first.state());
  contact.gap = found.gap - found.normal_W.dot(apart_W);
  // It sticks where the last step left it, while the organs' places move on.
  const Vector3d moved_W = (second.state().offset_W - second.state().offset_last_W) -
                           (first.state().offset_W - first.state().offset_last_W);
  contact.tie_W = apart_W - moved_W;
  const auto last = std::lower_bound(
      pair.pressed.begin(), pair.pressed.end(), found.key,
      [](const Pair::Pressed& pressed, std::uint64_t key) { return pressed.key < key; });
  if (last != pair.pressed.end() && last->key == found.key) {
    contact.f_n = last->f_n;
    contact.f_t_W = last->f_t_W;
  }
  contacts_.push_back(contact);
  return true;
}

void OrganContacts::Remember() {
  for (Pair& pair : pairs_) pair.pressed.clear();
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const OrganContact& contact = contacts_[c];
    pairs_[pair_of_[c]].search.SetIndentation(contact.key, contact.indentation);
    if (!(contact.f_n > 0)) continue;
    pairs_[pair_of_[c]].pressed.push_back({contact.key, contact.f_n, contact.f_t_W});
  }
}

}  // namespace hpdm
