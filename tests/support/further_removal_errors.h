#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "tests/support/removal_errors.h"

namespace hpdm {

/// Acts and measurements for the scripts of FurtherRemovalErrors().
class FurtherActs {
 public:
  using Duct = RemovalSurgeon::Duct;
  using Place = ErringSurgeon::Place;

  explicit FurtherActs(ErringSurgeon* surgeon) : surgeon_(*surgeon) {}

  int ClipsOn(Duct duct) const {
    const Rod& rod = surgeon_.RodOf(duct);
    int clips = 0;
    for (int i = 0; i + 1 < rod.nodes(); ++i) clips += rod.IsStiffened(i);
    return clips;
  }
  double FromDucts(const Vector3d& p_W) const {
    double least = std::numeric_limits<double>::infinity();
    for (const Duct duct : {RemovalSurgeon::kCysticDuct, RemovalSurgeon::kCysticArtery}) {
      const Rod& rod = surgeon_.RodOf(duct);
      for (int i = 0; i < rod.nodes(); ++i) least = std::min(least, (rod.node(i) - p_W).norm());
    }
    return least;
  }
  /// Clips and cuts a duct. True if as many clips are on it and it is cut.
  bool ClipAndCut(Duct duct, const std::array<double, 3>& clips, double cut, double past) {
    surgeon_.Change(RemovalSurgeon::kClipApplier);
    for (const double arc : clips) surgeon_.CloseOn(duct, arc, 0, past);
    const bool closed = ClipsOn(duct) == 3;
    surgeon_.Change(RemovalSurgeon::kScissors);
    surgeon_.CloseOn(duct, cut, 0, past);
    return closed && surgeon_.RodOf(duct).cuts() == 1;
  }
  /// Three clips on the artery, that of the gallbladder first, and a cut between two of them, at a
  /// share of the way from the first to the third. The clips lie where the artery is most across
  /// the jaws. The gallbladder is lifted until there is a good place, by 12 mm at most.
  bool ClipAndCutArtery(double share) {
    constexpr double kApart = 0.0031, kAcross = 0.28;  // m, rad
    double best = 0, least = 0;
    for (int lift = 0; lift <= 6; ++lift) {
      if (lift > 0) surgeon_.Lift(0.002);
      least = std::numeric_limits<double>::infinity();
      for (double first = 0.0090; first > 0.0060; first -= 0.0005) {
        double most = 0;
        for (int i = 0; i < 3; ++i) {
          most =
              std::max(most, surgeon_.BestAngle(RemovalSurgeon::kCysticArtery, first + i * kApart));
        }
        if (most >= least) continue;
        least = most;
        best = first;
        if (most <= kAcross) break;
      }
      if (least <= kAcross) break;
    }
    return ClipAndCut(RemovalSurgeon::kCysticArtery, {best + 2 * kApart, best + kApart, best},
                      best + share * 2 * kApart, 0.002);
  }
  /// The duct's three clips, the middle one first, and a cut between those of the gallbladder's
  /// side.
  bool ClipAndCutDuct() {
    const double last =
        std::min(surgeon_.RodOf(RemovalSurgeon::kCysticDuct).rest_length() - 0.0043, 0.024);
    return ClipAndCut(RemovalSurgeon::kCysticDuct, {last - 0.0034, last, last - 0.0070},
                      last - 0.0052, 0.004);
  }
  /// Pulls what the right hand holds off the bed until the artery has so many times its length.
  bool PullArteryTo(double stretch) {
    const auto reached = [&] {
      const Rod& rod = surgeon_.RodOf(RemovalSurgeon::kCysticArtery);
      double length = 0;
      for (int i = 0; i + 1 < rod.nodes(); ++i) length += (rod.node(i + 1) - rod.node(i)).norm();
      return length >= stretch * rod.rest_length();
    };
    surgeon_.Creep(RemovalSurgeon::kRight, surgeon_.away_W(), 0.0005, 0.05, reached);
    return reached();
  }
  /// The place on the hepatic artery that faces the port and is nearest to the cystic artery's
  /// origin, with no duct within the reach of the applier's jaws and its tip off the bile duct.
  Place OnHepaticArtery() const {
    const Vector3d origin_W = surgeon_.RodOf(RemovalSurgeon::kCysticArtery).node(0);
    Place best;
    double least = std::numeric_limits<double>::infinity();
    for (double x = -0.02; x <= 0.02; x += 0.004) {
      for (double y = -0.02; y <= 0.02; y += 0.004) {
        const Place place =
            surgeon_.SurfaceNear(ErringSurgeon::kHepaticArtery, origin_W + Vector3d(x, y, 0.002));
        const double distance = (place.at_W - origin_W).norm();
        const Vector3d tip_W = place.at_W + 0.0025 * place.outward_W;
        const Vector3d bile_duct_W = surgeon_.SurfaceNear(ErringSurgeon::kBileDuct, tip_W).at_W;
        if (distance >= least || FromDucts(place.at_W) < 0.008 ||
            FromDucts(place.at_W + 0.006 * place.outward_W) < 0.008 ||
            (bile_duct_W - tip_W).norm() < 0.008) {
          continue;
        }
        least = distance;
        best = place;
      }
    }
    HPDM_CHECK(least < 1);
    return best;
  }

 private:
  ErringSurgeon& surgeon_;
};

/// Errors at other places, in another order and in other ways than RemovalErrors(), with near misses. They
/// were written from the operation's description alone, without the rules' code.
inline std::vector<RemovalError> FurtherRemovalErrors() {
  using S = ErringSurgeon;
  std::vector<RemovalError> errors;

  // Of three clips two stay and one goes, and the cut is between the second and the third. The artery is cut between clips 1 and 2, so that one clip
  // alone stays. The near miss is the cut between clips 2 and 3. Both have three good clips, put on
  // in reverse order. The neck is right behind the artery. Where the bile duct is beside the artery the shaft presses on it (measured: 5
  // N).
  errors.push_back({"the artery cut between clips 2 and 3, and 1 and 2",
                    "cut outside the clips",
                    [](S* s) { return FurtherActs(s).ClipAndCutArtery(0.75); },
                    [](S* s) { return FurtherActs(s).ClipAndCutArtery(0.25); },
                    RemovalError::kInstead,
                    {"more than 4 N on tissue", "perforation of the gallbladder"}});

  // A clip on the wrong tube. The applier closes on the hepatic artery, as near to the cystic
  // artery as no duct is between the jaws. In the near miss it begins to close there, and opens
  // again. In narrow places its shaft catches on the bile duct as it leaves (measured: 4 N).
  errors.push_back({"jaws that close half and fully on the hepatic artery",
                    "clip on the hepatic artery",
                    [](S* s) {
                      s->Change(S::kClipApplier);
                      s->GoTo(FurtherActs(s).OnHepaticArtery(), 0);
                      s->Jaws(S::kRight, 0.4);
                      s->Step(10);
                      s->Open(S::kRight);
                      s->BackOff();
                      return true;
                    },
                    [](S* s) {
                      const FurtherActs eye(s);
                      s->GoTo(eye.OnHepaticArtery(), 0);
                      s->Jaws(S::kRight, 0);
                      s->Step(3);
                      return eye.ClipsOn(S::kCysticArtery) + eye.ClipsOn(S::kCysticDuct) == 0;
                    },
                    RemovalError::kAfter,
                    {"more than 4 N on tissue"}});

  // The foot stays on the pedal while the
  // hook is drawn from the bed back to its port, and for 2 s there. In the near miss it is lifted
  // 0.1 s late.
  const auto draw_back = [](S* s, int late) {
    const Vector3d from_W = s->tip_W(S::kRight);
    s->Move(S::kRight, from_W + 0.005 * (s->port_W() - from_W).normalized(), 0.05);
    s->Press(true);
    s->Step(late);
    if (late <= 3) s->Press(false);
    s->BackOff();
    s->Step(60);
    s->Press(false);
    s->Step();
    return true;
  };
  errors.push_back({"the pedal released 0.1 s late and not at all as the hook is drawn back",
                    "hook energised away from tissue",
                    [=](S* s) {
                      s->Change(S::kHook);
                      s->Burn(S::kLowestThird);
                      return draw_back(s, 3);
                    },
                    [=](S* s) {
                      s->Burn(S::kTriangle);
                      return draw_back(s, 4);
                    }});

  // The critical view needs the triangle cleared and the lowest third of the bed freed. The triangle is clear and the duct has three good clips, but the bed is whole
  // when it is cut. The near miss is the same after the third is freed.
  errors.push_back({"the duct cut after the view and after half of it",
                    "cut before the critical view",
                    [](S* s) { return FurtherActs(s).ClipAndCutDuct(); },
                    [](S* s) {
                      s->Burn(S::kTriangle);
                      s->BackOff();
                      s->Lift(-0.010);
                      return FurtherActs(s).ClipAndCutDuct();
                    },
                    RemovalError::kEarly,
                    {"clip before the critical view"}});
  // The left hand opens under a lift of 12 mm. The near miss: it
  // lowers the gallbladder first, and takes it again.
  errors.push_back({"the fundus let go when lowered and when lifted", "the gallbladder was dropped",
                    [](S* s) {
                      s->Lift(-0.002);
                      s->Open(S::kLeft);
                      s->Step(15);
                      s->TakeFundus();
                      return true;
                    },
                    [](S* s) {
                      s->Lift(0.010);
                      s->Open(S::kLeft);
                      s->Step(15);
                      return true;
                    },
                    RemovalError::kInstead});
  // Scissors close on the gallbladder's free wall, and 3 mm above it.
  const auto on_wall = [](S* s) {
    return s->SurfaceNear(S::kGallbladder,
                          s->RodOf(S::kCysticArtery).node(40) + Vector3d(0.01, -0.02, 0.01));
  };
  errors.push_back({"scissors that close 3 mm above the gallbladder and on it",
                    "perforation of the gallbladder",
                    [=](S* s) {
                      s->Change(S::kScissors);
                      s->GoTo(on_wall(s), -0.003);
                      s->Jaws(S::kRight, 0);
                      s->Open(S::kRight);
                      return true;
                    },
                    [=](S* s) {
                      s->GoTo(on_wall(s), 0.0005);
                      const bool touches = s->Contact(S::kRight).organ == S::kGallbladder;
                      s->Jaws(S::kRight, 0);
                      s->Step(30);
                      return touches;
                    }});
  // A cold hook rubs the bile duct for 0.7 s, and is then energised
  // on it for 0.1 s.
  errors.push_back({"a cold rub and a tap with energy on the bile duct",
                    "burn of the bile duct",
                    [](S* s) {
                      s->Change(S::kHook);
                      s->GoTo(s->Bare(S::kBileDuct), 0.0002);
                      s->Creep(S::kRight, Vector3d(0, 1, 0), 0.00003, 0.0006, [] { return false; });
                      s->BackOff();
                      return true;
                    },
                    [](S* s) {
                      s->GoTo(s->Bare(S::kBileDuct), 0.0002);
                      s->Pedal(3);
                      return true;
                    },
                    RemovalError::kAfter,
                    {"burn within 5 mm of the bile duct"}});
  // The right grasper holds the pouch, lifted by 15 mm, and lets go of it while the
  // left hand keeps the fundus: nothing is dropped. Then the left hand lets go under a lift.
  errors.push_back({"the pouch let go while the left hand holds the fundus, and the fundus",
                    "the gallbladder was dropped",
                    [on_wall](S* s) {
                      s->Change(S::kGrasper);
                      s->GoTo(on_wall(s), 0.0005);
                      s->Jaws(S::kRight, 0);
                      s->Step(10);
                      s->Creep(S::kRight, s->away_W(), 0.0005, 0.015, [] { return false; });
                      const bool holds = s->Contact(S::kRight).kind == ContactKind::kGrasp &&
                                         s->Contact(S::kLeft).kind == ContactKind::kGrasp;
                      s->Open(S::kRight);
                      s->Step(15);
                      const bool keeps = s->Contact(S::kLeft).kind == ContactKind::kGrasp;
                      s->BackOff();
                      return holds && keeps;
                    },
                    [](S* s) {
                      s->Lift(0.010);
                      s->Open(S::kLeft);
                      s->Step(15);
                      return true;
                    }});
  // A grasper takes the artery in the middle and pulls it to 1.3 times its length, then on to 1.7.
  errors.push_back({"the artery pulled to 1.3 and 1.7 times its length",
                    "the artery was pulled too far",
                    [](S* s) {
                      s->Change(S::kGrasper);
                      s->Hold(S::kCysticArtery, s->RodOf(S::kCysticArtery).rest_length() / 2);
                      return FurtherActs(s).PullArteryTo(1.3);
                    },
                    [](S* s) { return FurtherActs(s).PullArteryTo(1.7); },
                    RemovalError::kAfter,
                    {"more than 4 N on tissue", "a layer was torn", "tissue overstretched"}});
  return errors;
}

}  // namespace hpdm
