#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/organ_options.h"
#include "engine/pairs/organ_pair.h"
#include "engine/step/organ_step.h"

namespace hpdm {

/// The contacts between the organs of a scene: finds them in each step (organ_pair.h), adds their
/// rows to both organs and remembers which of them pressed. Deformation thread; a step allocates
/// nothing.
class OrganContacts {
 public:
  /// The pairs are those of OrganOptions::contacts whose organs are both there.
  explicit OrganContacts(const std::vector<OrganModel>& organs);

  /// Leaves out the pair of two organs until Begin() of one of them: a layer joins them. Set-up only.
  void Wait(const std::array<int, 2>& organs);
  void Begin(int organ);

  /// Finds the contacts at the organs' present shapes and places, and adds their rows after those
  /// of the tools. A pair that slept in its last step and has not moved is left out. False if there
  /// was no room for all.
  bool AddRows(std::vector<OrganStep>* organs);
  /// The contacts of the step; OrganContact::body holds the organs' indices.
  std::span<OrganContact> contacts() { return contacts_; }
  std::size_t pairs() const { return pairs_.size(); }
  /// After the relaxation: keeps the contacts that press, for the next step.
  void Remember();

 private:
  struct Pair {
    Pair(const OrganModel& first, const OrganModel& second, std::array<int, 2> indices,
         double coefficient);
    std::array<int, 2> organs;  // indices
    double friction;
    bool waits = false;
    OrganPair search;
    struct Pressed {
      std::uint64_t key = 0;
      double f_n = 0;  // N
      Vector3d f_t_W;  // N
    };
    std::vector<Pressed> pressed;  // the last step's contacts with force, their keys ascending
    Vector3d between_W = Vector3d::Constant(1e9);  // m: second organ's offset less the first's
  };

  bool AddPair(std::size_t pair, std::vector<OrganStep>* organs);
  bool AddContact(const PairContact& found, const Pair& pair, std::vector<OrganStep>* organs);

  std::vector<Pair> pairs_;
  std::vector<OrganContact> contacts_;
  std::vector<std::size_t> pair_of_;  // of each contact
};

}  // namespace hpdm
