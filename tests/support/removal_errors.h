#pragma once

#include <algorithm>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "engine/exercise/duct_judge.h"
#include "engine/exercise/step_queries.h"
#include "tests/support/removal_surgeon.h"

namespace hpdm {

/// A scripted surgeon that errs. The scripts find their places in the anatomy, so they are the same in all
/// of them. Forces and lifts are approached in small steps.
class ErringSurgeon : public RemovalSurgeon {
 public:
  enum Organ { kLiver, kGallbladder, kBileDuct, kHepaticArtery, kLigament };
  using RemovalSurgeon::RemovalSurgeon;

  // --- what an examiner sees ---

  const SolvedContact& Contact(std::size_t hand) {
    session_.Show(&shown_);
    return shown_.contacts[hand];
  }
  double Force(std::size_t hand) { return Contact(hand).force_on_tissue_W.norm(); }
  double LiftOfHeld() { return LiftOf(Contact(kLeft)); }

  // --- places ---

  struct Place {
    Vector3d at_W, outward_W;
  };
  /// The place on an organ that is nearest to a point, of those that face the right hand's port.
  Place SurfaceNear(Organ organ, const Vector3d& p_W) const {
    const Points& vertices = session_.organ(ToSize(organ)).vertices;
    const auto& triangles = session_.model().organs()[ToSize(organ)].rest().triangles;
    Place nearest;
    double least = std::numeric_limits<double>::infinity();
    for (const auto& triangle : triangles.rowwise()) {
      const Vector3d a = vertices.row(triangle[0]), b = vertices.row(triangle[1]),
                     c = vertices.row(triangle[2]);
      const Vector3d middle = (a + b + c) / 3, outward = (b - a).cross(c - a).normalized();
      const Vector3d to_port = (Kinematics(kRight).p_trocar_W() - middle).normalized();
      const double distance = (middle - p_W).norm();
      if (outward.dot(to_port) < 0.5 || distance >= least) continue;
      least = distance;
      nearest = {middle, outward};
    }
    HPDM_CHECK(least < 1);
    return nearest;
  }
  /// The place on a vessel that faces the port and is farthest from all ducts and the other vessel, between
  /// the liver and the fat.
  Place Bare(Organ vessel) const {
    const Points& vertices = session_.organ(ToSize(vessel)).vertices;
    const Organ other = vessel == kBileDuct ? kHepaticArtery : kBileDuct;
    Place best;
    double most = 0;
    for (const auto& p : vertices.rowwise()) {
      if (p.y() < -0.066 || p.y() > -0.030) continue;
      const Place place = SurfaceNear(vessel, p.transpose());
      double distance = (session_.organ(ToSize(other)).vertices.rowwise() - place.at_W.transpose())
                            .rowwise()
                            .norm()
                            .minCoeff();
      for (const Duct duct : {kCysticDuct, kCysticArtery}) {
        for (int i = 0; i < RodOf(duct).nodes(); ++i) {
          distance = std::min(distance, (RodOf(duct).node(i) - place.at_W).norm());
        }
      }
      if (distance <= most) continue;
      most = distance;
      best = place;
    }
    return best;
  }
  /// Brings the right tip to a place, its surface `depth` m below the organ's; above it if negative.
  void GoTo(const Place& place, double depth) {
    BackOff();
    const Vector3d to_W = Centre(place, depth);
    const Vector3d back_W = (Kinematics(kRight).p_trocar_W() - to_W).normalized();
    Move(kRight, to_W + 0.03 * back_W, 0.2);
    Move(kRight, to_W, 0.08);
    Step(2);
  }
  Vector3d Centre(const Place& place, double depth) const {
    const int held = session_.tools().empty() ? 0 : held_;
    const double radius =
        session_.model().scene().instruments[kRight].Held(held).geometry.tip_radius;
    return place.at_W + (radius - depth) * place.outward_W;
  }
  void Change(int tool) {
    held_ = tool;
    Exchange(tool);
  }

  // --- acts ---

  void Press(bool pressed) { session_.Press(kRight, pressed); }
  void Pedal(int steps) {
    session_.Press(kRight, true);
    Step(steps);
    session_.Press(kRight, false);
    Step(3);
  }
  /// The places of three good clips and of a cut on the duct, m. Those that stay in the body come first.
  std::array<double, 3> Clips() const {
    const double last = std::min(RodOf(kCysticDuct).rest_length() - 0.0042, 0.022);
    return {last, last - 0.0033, last - 0.0075};
  }
  double SegmentLength() const { return RodOf(kCysticDuct).rest_length() / kDuctSegments; }
  /// Returns the distance of a point from a duct's surface, m; below 0 inside.
  double GapTo(Duct duct, const Vector3d& p_W) const {
    const Rod& rod = RodOf(duct);
    std::vector<Vector3d> path_W;
    for (int i = 0; i < rod.nodes(); ++i) path_W.push_back(rod.node(i));
    return DistanceTo(path_W, p_W) - session_.model().scene().ducts[duct].radius;
  }
  double LumenHalf() const {
    const DuctOptions& duct = session_.model().scene().ducts[kCysticDuct];
    return std::numbers::pi / 2 * (duct.radius - duct.wall);
  }
  double JawsOfApplier() const {
    return session_.model().scene().instruments[kRight].Held(kClipApplier).geometry.JawsLength();
  }
  void Clip(double arc, double past = 0.004) { CloseOn(kCysticDuct, arc, 0, past); }
  void ClipAtAngle(double arc, double degrees) {
    const double tilt = BestAngle(kCysticDuct, arc);
    const double wanted = degrees * std::numbers::pi / 180;
    CloseOn(kCysticDuct, arc, std::acos(std::min(1.0, std::cos(wanted) / std::cos(tilt))), 0.004);
  }
  void Cut(double arc) { CloseOn(kCysticDuct, arc, 0, 0.004); }
  void ThreeClips() {
    Change(kClipApplier);
    for (const double arc : Clips()) Clip(arc);
  }
  /// Moves a hand along a direction in small steps until a condition holds. Returns false if it never does.
  bool Creep(std::size_t hand, const Vector3d& along_W, double stride, double most,
             const std::function<bool()>& there) {
    for (double way = 0; way < most; way += stride) {
      if (there()) return true;
      Move(hand, tips_W_[hand] + stride * along_W, 30 * stride);
      Step();
    }
    return there();
  }
  const Vector3d& away_W() const { return away_W_; }
  const Vector3d& tip_W(std::size_t hand) const { return tips_W_[hand]; }
  Vector3d port_W() const { return Kinematics(kRight).p_trocar_W(); }
  void Open(std::size_t hand) {
    Jaws(hand, 1);
    Step(5);
  }

 private:
  int held_ = kHook;
  SceneSnapshot shown_ = SizedSnapshot(session_.model().organs(), 2, true);
};

/// Something that a trainee does wrong, and what is nearly as wrong. The wrong act follows the near miss in
/// the same session. Either returns false if it could not be done.
struct RemovalError {
  std::string name;
  std::string rule;  ///< Name of the scene's rule.
  std::function<bool(ErringSurgeon*)> near_miss, wrong;
  /// When the wrong act comes: after the near miss, or instead of it, or before the critical view.
  enum When { kAfter, kInstead, kEarly } when = kAfter;
  std::vector<std::string> others = {};  ///< Rules that the acts break besides.
};

inline std::vector<RemovalError> RemovalErrors() {
  using S = ErringSurgeon;
  const std::string bad_clip = "clip oblique, loose, or too near to a clip or the bile duct";
  const std::string cut_outside = "cut outside the clips", lost = "clip lost";
  const auto clip = [](double past_of_half, std::size_t place) {
    return [=](S* s) {
      s->Change(S::kClipApplier);
      s->Clip(s->Clips()[place], s->LumenHalf() + past_of_half);
      return true;
    };
  };
  const auto close_at = [](int tool, S::Organ vessel, double depth) {
    return [=](S* s) {
      const S::Place place = s->Bare(vessel);
      s->Change(tool);
      s->GoTo(place, depth);
      s->Jaws(S::kRight, 0);
      s->Step(2);
      s->BackOff();
      s->Jaws(S::kRight, 1);
      return true;
    };
  };
  const auto on_vessel = [&](const std::string& name, S::Organ vessel) {
    return RemovalError{"jaws 1 mm above and on the " + name,
                        "clip on the " + name,
                        close_at(S::kClipApplier, vessel, -0.001),
                        close_at(S::kClipApplier, vessel, 0.0005),
                        RemovalError::kAfter,
                        {lost}};
  };
  const auto burn = [](S::Organ organ, const Vector3d& near_W, int steps) {
    return [=](S* s) {
      s->Change(S::kHook);
      const bool rigid = organ == S::kBileDuct;
      s->GoTo(rigid ? s->Bare(organ) : s->SurfaceNear(organ, near_W), rigid ? 0.0003 : 0.001);
      s->Pedal(steps);
      s->BackOff();
      return true;
    };
  };
  // The hook comes to the artery's middle from its port, up to so far from the artery; into it if negative.
  const auto burn_artery = [](double gap) {
    return [=](S* s) {
      s->Change(S::kHook);
      const Vector3d middle_W = s->RodOf(S::kCysticArtery).node(kDuctSegments / 2);
      S::Place place{middle_W, (s->port_W() - middle_W).normalized()};
      const double radius = (s->Centre(place, 0) - place.at_W).norm();  // of the tip
      while (s->GapTo(S::kCysticArtery, place.at_W) < gap + radius) {
        place.at_W += 5e-5 * place.outward_W;
      }
      place.at_W -= radius * place.outward_W;
      s->GoTo(place, 0);
      s->Pedal(11);
      s->BackOff();
      return true;
    };
  };
  const auto burn_near = [](double distance) {
    return [=](S* s) {
      s->Change(S::kHook);
      S::Place place = s->Bare(S::kBileDuct);
      place.at_W += distance * place.outward_W;
      place.at_W -= s->Centre(place, 0) - place.at_W;  // the tip's middle
      s->GoTo(place, 0);
      s->Pedal(6);
      s->BackOff();
      return true;
    };
  };
  const auto pedal = [](int steps) {
    return [=](S* s) {
      s->Change(S::kHook);
      s->Pedal(steps);
      return true;
    };
  };
  const auto drop_at = [](double lift) {
    return [=](S* s) {
      const bool lifted =
          s->Creep(S::kLeft, s->away_W(), 1e-4, 0.03, [=] { return s->LiftOfHeld() > lift; });
      s->Open(S::kLeft);
      return lifted;
    };
  };
  const auto press = [](double force) {
    return [=](S* s) {
      if (force < 4) {
        s->Change(S::kHook);
        s->GoTo(s->SurfaceNear(S::kLigament, Vector3d(0.045, -0.085, -0.05)), 0);
      }
      const Vector3d in_W = -s->SurfaceNear(S::kLigament, Vector3d(0.045, -0.085, -0.05)).outward_W;
      return s->Creep(S::kRight, in_W, 2e-5, 0.02, [=] { return s->Force(S::kRight) > force; });
    };
  };
  const auto clip_at_end = [](double from_end) {
    return [=](S* s) {
      s->Change(S::kClipApplier);
      s->Clip(s->RodOf(S::kCysticDuct).rest_length() - from_end, s->LumenHalf() + 0.0003);
      return true;
    };
  };
  const auto clip_at_back = [](double past_of_end, std::size_t place) {
    return [=](S* s) {
      s->Change(S::kClipApplier);
      s->Clip(s->Clips()[place], s->JawsOfApplier() - s->LumenHalf() + past_of_end);
      return true;
    };
  };
  return {
      {"a clip at 19 and 21 degrees", bad_clip,
       [](S* s) {
         s->Change(S::kClipApplier);
         s->ClipAtAngle(s->Clips()[2], 19);
         return true;
       },
       [](S* s) {
         s->ClipAtAngle(s->Clips()[0], 21);
         return true;
       }},
      {"a gap of 2.1 and 1.9 mm", bad_clip,
       [](S* s) {
         s->Change(S::kClipApplier);
         s->Clip(s->Clips()[2]);
         s->Clip(s->Clips()[2] + 0.0031);
         return true;
       },
       [](S* s) {
         s->Clip(s->Clips()[2] + 0.0060);
         return true;
       }},
      {"a clip 3.3 and 2.7 mm from the bile duct", bad_clip, clip_at_end(0.0038),
       clip_at_end(0.0032), RemovalError::kInstead},
      {"jaws that reach 0.2 mm beyond the lumen, or not across", bad_clip, clip(0.0002, 2),
       clip(-0.0004, 0)},
      {"a lumen 0.3 mm before the back of the jaws, or not between them", bad_clip,
       clip_at_back(-0.0003, 2), clip_at_back(0.0006, 0)},
      {"a clip at the end of the jaws, and beside the duct", lost,
       [](S* s) {
         s->Change(S::kClipApplier);
         s->Clip(s->Clips()[2], s->JawsOfApplier() - s->LumenHalf() - 0.0003);
         return true;
       },
       [](S* s) {
         s->Clip(s->Clips()[0], -0.003);
         return true;
       }},
      on_vessel("bile duct", S::kBileDuct),
      on_vessel("hepatic artery", S::kHepaticArtery),
      {"a clip after and before the critical view", "clip before the critical view", clip(0.001, 0),
       clip(0.001, 0), RemovalError::kEarly},
      {"a cut after and before the critical view",
       "cut before the critical view",
       [](S* s) {
         s->ThreeClips();
         s->Change(S::kScissors);
         s->Cut((s->Clips()[1] + s->Clips()[2]) / 2);
         return true;
       },
       [](S* s) {
         s->ThreeClips();
         s->Change(S::kScissors);
         s->Cut((s->Clips()[1] + s->Clips()[2]) / 2);
         return true;
       },
       RemovalError::kEarly,
       {"clip before the critical view", lost, cut_outside}},
      {"a cut on either side of the organ's clip", cut_outside,
       [](S* s) {
         s->ThreeClips();
         s->Change(S::kScissors);
         s->Cut(s->Clips()[2] + s->SegmentLength());
         return true;
       },
       [](S* s) {
         s->Cut(s->Clips()[2] - s->SegmentLength());
         return true;
       }},
      {"a cut on either side of the second clip", cut_outside,
       [](S* s) {
         s->ThreeClips();
         s->Change(S::kScissors);
         s->Cut(s->Clips()[1] - s->SegmentLength());
         return true;
       },
       [](S* s) {
         s->Cut((s->Clips()[0] + s->Clips()[1]) / 2);
         return true;
       }},
      {"a press of 3.9 and 4.1 N", "more than 4 N on tissue", press(3.9), press(4.1)},
      {"0.27 and 0.37 s energised on the gallbladder",
       "burn of the gallbladder's wall",
       burn(S::kGallbladder, Vector3d(0.03, -0.085, 0.03), 8),
       burn(S::kGallbladder, Vector3d(0.03, -0.085, 0.03), 11),
       RemovalError::kAfter,
       {"perforation of the gallbladder"}},
      {"0.27 and 0.37 s energised on the liver", "burn of the liver",
       burn(S::kLiver, Vector3d(0.045, -0.062, 0.045), 8),
       burn(S::kLiver, Vector3d(0.045, -0.062, 0.045), 11)},
      {"0.07 and 0.2 s energised on the bile duct",
       "burn of the bile duct",
       burn(S::kBileDuct, Vector3d::Zero(), 2),
       burn(S::kBileDuct, Vector3d::Zero(), 6),
       RemovalError::kAfter,
       {"burn within 5 mm of the bile duct"}},
      {"energised 5.3 and 4.7 mm from the bile duct", "burn within 5 mm of the bile duct",
       burn_near(0.0053), burn_near(0.0047)},
      {"scissors that close 1 mm above and on the bile duct", "cut into the bile duct",
       close_at(S::kScissors, S::kBileDuct, -0.001), close_at(S::kScissors, S::kBileDuct, 0.0005)},
      {"energised 1.5 mm from the cystic artery and on it",
       "burn of the cystic artery",
       burn_artery(0.0015),
       burn_artery(-0.0003),
       RemovalError::kAfter,
       {"burn of the gallbladder's wall", "perforation of the gallbladder"}},
      {"0.97 and 1.07 s energised in the air", "hook energised away from tissue", pedal(29),
       pedal(32)},
      {"let go at 11.5 and 12.1 mm of lift", "the gallbladder was dropped", drop_at(0.0115),
       drop_at(0.0121), RemovalError::kInstead},
  };
}

/// How the scripts of one error went.
struct ErrorTrial {
  bool done = false;                         ///< Both acts could be done.
  bool found = false;                        ///< The wrong act was found.
  bool false_alarm = false;                  ///< The near miss was flagged as that error.
  std::string faults = {};                   ///< Of clips that the near miss put on.
  std::vector<std::string> unexpected = {};  ///< Other rules that were broken.
};

/// Tries the errors in one anatomy. Each trial begins from a copy of the state before or after the view.
class RemovalErrorTrials {
 public:
  explicit RemovalErrorTrials(const std::shared_ptr<const SessionModel>& model)
      : session_(model, Devices()), surgeon_(&session_) {
    surgeon_.TakeFundus();
    surgeon_.Lift(0.012);
    surgeon_.Burn(RemovalSurgeon::kLeaf);
    surgeon_.BackOff();
    early_.push_back(session_);
    early_surgeon_.push_back(surgeon_);
    surgeon_.Burn(RemovalSurgeon::kTriangle);
    surgeon_.BackOff();
    surgeon_.Burn(RemovalSurgeon::kLowestThird);
    surgeon_.BackOff();
    surgeon_.Lift(-0.010);
    late_.push_back(session_);
    late_surgeon_.push_back(surgeon_);
  }
  std::size_t done() const { return surgeon_.done(); }
  std::vector<std::string> Errors() const { return surgeon_.Errors(); }

  ErrorTrial Try(const RemovalError& error) {
    ErrorTrial trial;
    session_ = late_[0];
    ErringSurgeon near(late_surgeon_[0]);
    const std::size_t before = near.Errors().size();
    trial.done = error.near_miss(&near);
    const std::size_t flagged = near.Errors().size();
    trial.false_alarm = Judge(error, near.Errors(), before, &trial) > 0;
    for (std::size_t e = before; e < flagged; ++e) {
      trial.faults += FaultText(near.result().errors[e].clip, "", false);
    }
    bool wrong_done = false;
    std::vector<std::string> errors;
    std::size_t earlier = flagged;
    if (error.when != RemovalError::kAfter) {
      const bool early = error.when == RemovalError::kEarly;
      session_ = early ? early_[0] : late_[0];
      ErringSurgeon wrong(early ? early_surgeon_[0] : late_surgeon_[0]);
      earlier = wrong.Errors().size();
      wrong_done = error.wrong(&wrong);
      errors = wrong.Errors();
    } else {
      wrong_done = error.wrong(&near);
      errors = near.Errors();
    }
    trial.done = trial.done && wrong_done;
    trial.found = Judge(error, errors, earlier, &trial) > 0;
    return trial;
  }

 private:
  static std::vector<DeviceChoice> Devices() {
    DeviceChoice command;
    command.type = DeviceChoice::Type::kCommand;
    return {command, command};
  }
  // Returns how often the rule was broken after `earlier` errors, and notes other rules.
  static int Judge(const RemovalError& error, const std::vector<std::string>& flagged,
                   std::size_t earlier, ErrorTrial* trial) {
    int found = 0;
    for (std::size_t e = earlier; e < flagged.size(); ++e) {
      const std::string& name = flagged[e];
      if (name == error.rule) {
        ++found;
      } else if (std::ranges::find(error.others, name) == error.others.end()) {
        trial->unexpected.push_back(name);
      }
    }
    return found;
  }

  LockstepSession session_;
  ErringSurgeon surgeon_;
  std::vector<LockstepSession> early_, late_;
  std::vector<ErringSurgeon> early_surgeon_, late_surgeon_;
};

}  // namespace hpdm
