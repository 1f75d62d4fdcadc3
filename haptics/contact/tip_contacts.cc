#include "haptics/contact/tip_contacts.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <span>

namespace hpdm {
namespace {

// Rounds over all contacts on the organs that shafts touch, and the last change of a force over the
// largest. Each round solves every contact with the others' last forces (block Gauss-Seidel).
constexpr int kMaxContactRounds = 12;
constexpr double kSettledChange = 1e-9;

// Largest coupling of two contacts over the root of their own compliances. It is below 1 in tissue. A
// contact that has moved since the step keeps the step's coupling while its own compliance follows it.
// The coupling can then be too large, and the rounds would diverge.
constexpr double kClosest = 0.95;

// The rounds diverge if one changes the forces by this factor more than the first round did, and by
// more than this share of the largest force. They start again with halved couplings, twice; the last
// time without any.
constexpr double kDivergedFactor = 10, kDivergedShare = 0.1;
constexpr int kMaxWeakened = 3;

}  // namespace

TipContacts::TipContacts(double period) {
  places_.fill(HapticContact(period));
  std::fill(places_.begin() + kMaxPlaces, places_.end(),
            HapticContact(period, HapticContact::Part::kShaft));
}

void TipContacts::SetPatches(const ToolPatches& patches) noexcept {
  static_assert(kShaftPlaces == 2);
  const HapticContact &one = places_[kMaxPlaces], &other = places_[kMaxPlaces + 1];
  const ToolPatch &first = patches.places[kMaxPlaces], &second = patches.places[kMaxPlaces + 1];
  const double straight = one.DistanceTo(first) + other.DistanceTo(second);
  const double crossed = one.DistanceTo(second) + other.DistanceTo(first);
  if (straight != crossed) shafts_crossed_ = crossed < straight;
  for (std::size_t p = 0; p < places_.size(); ++p) places_[p].SetPatch(patches.places[Slot(p)]);
}

// Returns the step's number of a place.
std::size_t TipContacts::Slot(std::size_t place) const {
  const bool crossed = shafts_crossed_ && place >= kMaxPlaces;
  return crossed ? 2 * kMaxPlaces + 1 - place : place;
}

void TipContacts::Rebind(const ToolPatches& patches) noexcept {
  for (std::size_t p = 0; p < places_.size(); ++p) places_[p].Rebind(patches.places[Slot(p)]);
}

void TipContacts::ClearPatches() noexcept {
  for (HapticContact& place : places_) place.ClearPatch();
}

void TipContacts::StandOnMoved(std::span<TipContacts* const> tools) noexcept {
  for (TipContacts* const tool : tools) {
    for (HapticContact& place : tool->places_) {
      place.ForgetOtherTools();
      for (const TipContacts* const other : tools) {
        if (other != tool) place.StandOnMoved(other->places_);
      }
    }
  }
}

void TipContacts::Locate(const TipPose& tip) noexcept {
  TipPose shaft = tip;
  for (int p = 0; p < kMaxPlaces; ++p) {
    shaft.tip_part = std::max(shaft.tip_part, tip.tip_part + result(p).depth);
  }
  for (HapticContact& place : Tips()) {
    place.StandBeside(Tips());
    place.Locate(tip);
  }
  JoinTips();
  static_assert(kShaftPlaces == 2);
  HapticContact &one = places_[kMaxPlaces], &other = places_[kMaxPlaces + 1];
  one.KeepApartFrom(other);
  one.Locate(shaft);
  other.KeepApartFrom(one);
  other.Locate(shaft);
}

// Contacts of the tip that have come together on one organ go on as one.
void TipContacts::JoinTips() {
  for (HapticContact& one : Tips()) {
    for (HapticContact& other : Tips()) {
      if (&one == &other || one.organ() < 0 || one.organ() != other.organ()) continue;
      if (one.began_beside()) other.FadeChange();
      if (!one.IsOneWith(other)) continue;
      const bool less = one.found_W().squaredNorm() < other.found_W().squaredNorm();
      (less ? one : other).GiveUp();
      (less ? other : one).FadeChange();
    }
  }
}

void TipContacts::Solve(std::span<TipContacts* const> tools) noexcept {
  FindForces(tools);
  const auto visit = [&](const auto& act) {
    for (TipContacts* const tool : tools) std::ranges::for_each(tool->places_, act);
  };
  visit([&](const HapticContact& jaws) {
    if (jaws.result().kind != ContactKind::kGrasp) return;
    visit([&](HapticContact& place) { place.HoldBack(jaws); });
  });
  for (TipContacts* const tool : tools) tool->Finish();
}

namespace {

// The contacts of all tools that have a force to be found. Those on one organ displace each other.
class CoupledContacts {
 public:
  void Add(HapticContact* contact, bool is_shaft) { members_[count_++] = {contact, is_shaft}; }

  void FindForces() {
    const bool in_blocks = Pair();
    for (std::size_t i = 0; i < count_; ++i) start_W_[i] = members_[i].contact->found_W();
    if (in_blocks) FillCouplings();
    for (int weakened = 1; !Iterate(in_blocks) && weakened <= kMaxWeakened; ++weakened) {
      const double kept = weakened < kMaxWeakened ? 0.5 : 0;
      for (std::size_t i = 0; i < count_; ++i) {
        for (std::size_t j = 0; j < count_; ++j) coupling_W_[i][j] *= kept;
      }
    }
  }

 private:
  static constexpr std::size_t kMost = kMaxInstruments * kToolPlaces;
  static constexpr std::size_t kNone = kMost;
  struct Member {
    HapticContact* contact = nullptr;
    bool is_shaft = false;
    std::size_t partner = kNone;  // the only other tip on the organ: solved with it
  };

  // False if the rounds diverge.
  bool Iterate(bool in_blocks) {
    last_W_ = start_W_;
    double first = 0;
    for (int round = 0; round < kMaxContactRounds; ++round) {
      double change = 0, largest = 0;
      for (std::size_t i = 0; i < count_; ++i) {
        const std::size_t partner = members_[i].partner;
        if (partner < i) continue;
        if (in_blocks) Push(i);
        if (partner == kNone) {
          members_[i].contact->FindForce();
        } else {
          if (in_blocks) Push(partner);
          HapticContact::FindForces(members_[i].contact, members_[partner].contact);
          Take(partner, &change, &largest);
        }
        Take(i, &change, &largest);
      }
      if (!in_blocks || change <= kSettledChange * largest) return true;
      if (round == 0) first = change;
      const double grown = round + 1 < kMaxContactRounds ? kDivergedFactor : 1;
      if (!(change <= grown * first || change <= kDivergedShare * largest)) return false;
    }
    return true;
  }

  // Finds the partners. True if more than partners share an organ.
  bool Pair() {
    bool in_blocks = false;
    for (std::size_t i = 0; i < count_; ++i) {
      std::size_t tips = 0;
      in_blocks = in_blocks || members_[i].is_shaft;
      for (std::size_t j = 0; j < count_ && !members_[i].is_shaft; ++j) {
        const bool other_organ = members_[j].contact->organ() != members_[i].contact->organ();
        if (j == i || other_organ || members_[j].is_shaft) continue;
        members_[i].partner = j;
        ++tips;
      }
      if (tips < 2) continue;
      members_[i].partner = kNone;
      in_blocks = true;
    }
    return in_blocks;
  }
  void FillCouplings() {
    std::array<Matrix3d, kMost> root_W;  // L of L L^T = own compliance
    for (std::size_t i = 0; i < count_; ++i) {
      root_W[i] = members_[i].contact->OwnCompliance().llt().matrixL();
      coupling_W_[i][i].setZero();
      for (std::size_t j = 0; j < i; ++j) {
        Matrix3d& coupling_W = coupling_W_[i][j];
        coupling_W = members_[i].partner == j
                         ? Matrix3d::Zero()
                         : members_[i].contact->CouplingTo(*members_[j].contact);
        if (!coupling_W.isZero(0)) {
          coupling_W *= std::min(1.0, kClosest / Closeness(root_W[i], coupling_W, root_W[j]));
        }
        coupling_W_[j][i] = coupling_W.transpose();
      }
    }
  }
  // Returns the norm of L_i^-1 C_ij L_j^-T: below 1 the two contacts' joint compliance is positive.
  static double Closeness(const Matrix3d& root_i, const Matrix3d& coupling,
                          const Matrix3d& root_j) {
    const auto half = root_i.triangularView<Eigen::Lower>().solve(coupling).eval();
    const Matrix3d share = root_j.triangularView<Eigen::Lower>().solve(half.transpose()).eval();
    Eigen::SelfAdjointEigenSolver<Matrix3d> squares;
    squares.computeDirect(share * share.transpose(), Eigen::EigenvaluesOnly);
    return std::sqrt(std::max(squares.eigenvalues()[2], 0.0));
  }
  void Push(std::size_t i) {
    Vector3d moved_W = Vector3d::Zero();
    for (std::size_t j = 0; j < count_; ++j) {
      if (j != i) moved_W += coupling_W_[i][j] * last_W_[j];
    }
    members_[i].contact->PushTo(moved_W);
  }
  void Take(std::size_t i, double* change, double* largest) {
    const Vector3d& found_W = members_[i].contact->found_W();
    *change = std::max(*change, (found_W - last_W_[i]).norm());
    *largest = std::max(*largest, found_W.norm());
    last_W_[i] = found_W;
  }

  std::size_t count_ = 0;
  std::array<Member, kMost> members_;
  std::array<Vector3d, kMost> start_W_, last_W_;
  std::array<std::array<Matrix3d, kMost>, kMost> coupling_W_;
};

}  // namespace

// Finds the forces of all contacts: of two tips on one organ together, of more and of shafts in rounds.
void TipContacts::FindForces(std::span<TipContacts* const> tools) {
  CoupledContacts coupled;
  for (const bool shafts : {false, true}) {
    for (TipContacts* const tool : tools) {
      for (std::size_t p = 0; p < tool->places_.size(); ++p) {
        HapticContact& contact = tool->places_[p];
        if ((p >= kMaxPlaces) != shafts) continue;
        if (contact.InLattice()) {
          coupled.Add(&contact, shafts);
        } else {
          contact.FindForce();
        }
      }
    }
  }
  coupled.FindForces();
}

void TipContacts::Finish() {
  for (HapticContact& place : places_) place.Apply();
  const auto weight = [](const HapticContact& place) {
    const HapticForce& force = place.result();
    if (force.kind == ContactKind::kGrasp) return 1e300;
    // A contact that has ended and fades out does not hide one that presses.
    return force.kind == ContactKind::kNone ? -1 : force.reaction_W.squaredNorm();
  };
  const auto main =
      std::max_element(places_.begin(), places_.end(),
                       [&](const auto& a, const auto& c) { return weight(a) < weight(c); });
  result_ = main->result();
  double most_stored = result_.stored;
  for (const HapticContact& place : places_) {
    if (&place == &*main) continue;
    const HapticForce& force = place.result();
    if (force.reaction_W.squaredNorm() != 0) result_.reaction_W += force.reaction_W;
    result_.wall_W += force.wall_W;
    result_.stored += force.stored;
    result_.tissue_stored += force.tissue_stored;
    if (force.stored <= most_stored) continue;
    most_stored = force.stored;
    result_.p_tip_organ_W = force.p_tip_organ_W;
  }
}

bool TipContacts::IsFree() const noexcept {
  return std::all_of(places_.begin(), places_.end(),
                     [](const HapticContact& place) { return place.IsFree(); });
}

std::array<TickContactPoint, kToolPlaces> TipContacts::contact_points() const noexcept {
  std::array<TickContactPoint, kToolPlaces> points;
  for (std::size_t p = 0; p < places_.size(); ++p) points[Slot(p)] = places_[p].contact_point();
  return points;
}

}  // namespace hpdm
