#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "engine/base/check.h"
#include "tests/support/scripted_hands.h"

namespace hpdm {

/// A scripted surgeon for scenes/gallbladder_removal.toml. Every method runs the session's steps. It sees
/// what an examiner sees: where tissue, samples and ducts are.
class RemovalSurgeon : public ScriptedHands {
 public:
  enum Tool { kHook, kClipApplier, kScissors, kGrasper };
  enum Duct { kCysticDuct, kCysticArtery };
  enum Layer { kTriangle, kLowestThird, kRest, kLeaf };

  /// `bed`: the attachment that the gallbladder is lifted off.
  explicit RemovalSurgeon(LockstepSession* session, std::size_t bed = kRest)
      : ScriptedHands(session, Vector3d(0.008, -0.110, 0.026), bed) {}

  /// Pulls the right hand back along its shaft and gives it another instrument.
  void Exchange(int tool) {
    session_.Press(kRight, false);
    BackOff();
    session_.Exchange(kRight, tool);
    jaws_[kRight] = 1;
    Step(3);
  }
  /// Pulls the right hand's instrument back along its shaft to 50 mm from its port, slowly at first.
  void BackOff() {
    const Vector3d trocar_W = Kinematics(kRight).p_trocar_W();
    const Vector3d way_W = tips_W_[kRight] - trocar_W, out_W = -way_W.normalized();
    if (way_W.norm() > 0.1) Move(kRight, tips_W_[kRight] + 0.04 * out_W, 0.08);
    if (way_W.norm() > 0.05) Move(kRight, trocar_W - 0.05 * out_W, 0.2);
  }

  /// Takes the fundus where it is now.
  void TakeFundus() { Take(session_.organ(1).vertices.row(fundus_), 0.1); }
  /// Lifts it and waits until the tissue is at rest.
  void Lift(double length) {
    ScriptedHands::Lift(length);
    Step(20);
  }
  /// Burns a layer until a step of the exercise is done, from its border, and leaves it the way it came. On
  /// a straight way the hook would push the gallbladder and tear the layer. The leaf and the lowest third are
  /// burnt whole: a strip that is left would tear later.
  void Burn(Layer layer) {
    const std::size_t before = done();
    const bool is_whole = layer == kLeaf || layer == kLowestThird;
    std::vector<Vector3d> way_W;
    for (int i = 0; i < 3000 && !result().ended && (is_whole || done() == before); ++i) {
      const Vector3d to_W = NextSample(layer);
      if (to_W.x() == kNoSample) break;
      if (way_W.empty()) Approach(to_W);
      Extend(&way_W, to_W);
      if ((to_W - tips_W_[kRight]).norm() > 0.0012) {
        session_.Press(kRight, false);
        Move(kRight, to_W, 0.06);
      }
      session_.Press(kRight, true);
      Step();
    }
    session_.Press(kRight, false);
    Step();
    if (layer == kTriangle) return;
    for (; !way_W.empty(); way_W.pop_back()) Move(kRight, way_W.back(), 0.06);
  }

  /// Closes the right hand's instrument on a duct at an arc length (m), with its jaws turned by an angle
  /// (rad) off the best roll, `past` (m) beyond the middle of the tube. Returns the place of its tip.
  Vector3d Hold(Duct duct, double arc, double turned = 0, double past = 0.005) {
    Vector3d tip_W = Aim(duct, arc, turned, past);
    Approach(tip_W);
    // The instrument may have moved the duct.
    for (int look = 0; look < 3; ++look) {
      tip_W = Aim(duct, arc, turned, past);
      Move(kRight, tip_W, 0.03);
      Step(2);
    }
    Jaws(kRight, 0);
    Step(2);
    return tip_W;
  }
  /// The same, and then draws it back and opens it again.
  void CloseOn(Duct duct, double arc, double turned = 0, double past = 0.005) {
    const Vector3d tip_W = Hold(duct, arc, turned, past);
    const Vector3d back_W = (Kinematics(kRight).p_trocar_W() - tip_W).normalized();
    Move(kRight, tip_W + 0.03 * back_W, 0.08);
    Jaws(kRight, 1);
    rolls_[kRight] = 0;
  }
  /// Returns the angle between the jaws' plane and the duct's normal plane at the best roll, rad.
  double BestAngle(Duct duct, double arc) const {
    const Rod& rod = RodOf(duct);
    const int i = SegmentAt(rod, arc);
    const Vector3d tangent_W = (rod.node(i + 1) - rod.node(i)).normalized();
    const Vector3d back_W = (Kinematics(kRight).p_trocar_W() - rod.node(i)).normalized();
    return std::asin(std::min(1.0, std::abs(tangent_W.dot(back_W))));
  }
  const Rod& RodOf(Duct duct) const {
    const Rod* rod = nullptr;
    for (const AttachmentLink& link : session_.links()) {
      for (const DuctState& state : link.state().ducts()) {
        if (state.model().index == duct) rod = &state.rod();
      }
    }
    HPDM_CHECK(rod != nullptr);
    return *rod;
  }

  /// Takes the gallbladder to the left hand's port, by a new hold if the old one is lost.
  void TakeOut() {
    if (session_.tools()[kLeft].kind != static_cast<int>(ContactKind::kGrasp)) {
      Jaws(kLeft, 1);
      Step(15);
      TakeFundus();
    }
    const Vector3d trocar_W = Kinematics(kLeft).p_trocar_W();
    Move(kLeft, trocar_W + 0.028 * (tips_W_[kLeft] - trocar_W).normalized(), 0.05);
    Step(30);
  }

  /// The whole operation, up to a step that fails. Returns the number of steps done.
  std::size_t Operate() {
    TakeFundus();
    Lift(0.012);
    for (const Layer layer : {kLeaf, kTriangle, kLowestThird}) {  // up to the critical view
      BackOff();
      Burn(layer);
    }
    if (done() < 5) return done();
    BackOff();
    Lift(-0.010);  // Without traction duct and artery lie across the clips.
    for (const Duct duct : {kCysticDuct, kCysticArtery}) {
      const std::size_t before = done();
      Exchange(kClipApplier);
      // The artery is narrower, and the neck is right behind it.
      const double past = duct == kCysticArtery ? 0.002 : 0.004;
      for (const double arc : ClipsOf(duct)) CloseOn(duct, arc, 0, past);
      Exchange(kScissors);
      CloseOn(duct, CutOf(duct), 0, past);
      if (done() < before + 2) return done();
    }
    Exchange(kHook);
    Lift(0.004);
    Burn(kRest);
    BackOff();
    TakeOut();
    return done();
  }
  /// Returns the places of the clips (m), those that stay in the body first.
  std::array<double, 3> ClipsOf(Duct duct) const {
    const double length = RodOf(duct).rest_length();
    if (duct == kCysticArtery) return {0.0085, 0.0116, 0.0147};
    return {length - 0.007, length - 0.0105, length - 0.017};
  }
  double CutOf(Duct duct) const {
    const auto clips = ClipsOf(duct);
    return (clips[1] + clips[2]) / 2;
  }

 private:
  static constexpr double kNoSample = 1, kOffLiver = 0.0015;  // m
  // Weight of a sample's distance from the hook beside that from the port, in the order of burning.
  static constexpr double kNearness = 0.3;

  // Adds a place to a way if it is not near its end. A way that comes back to itself loses the loop.
  static void Extend(std::vector<Vector3d>* way_W, const Vector3d& to_W) {
    constexpr double kNear = 0.004;  // m
    const auto near = [&](const Vector3d& p_W) { return (p_W - to_W).norm() < kNear; };
    const auto known = std::ranges::find_if(*way_W, near);
    if (known == way_W->end()) {
      way_W->push_back(to_W);
    } else {
      way_W->erase(known + 1, way_W->end());
    }
  }
  static int SegmentAt(const Rod& rod, double arc) {
    int i = 0;
    while (i + 2 < rod.nodes() && rod.ArcLength(i + 1) <= arc) ++i;
    return i;
  }
  // Returns the tip's place, and turns the jaws' axis along the duct.
  Vector3d Aim(Duct duct, double arc, double turned, double past) {
    const Rod& rod = RodOf(duct);
    const int i = SegmentAt(rod, arc);
    const double share = (arc - rod.ArcLength(i)) / (rod.ArcLength(i + 1) - rod.ArcLength(i));
    const Vector3d at_W = rod.node(i) + share * (rod.node(i + 1) - rod.node(i));
    const Vector3d tangent_W = (rod.node(i + 1) - rod.node(i)).normalized();
    const Vector3d back_W = (Kinematics(kRight).p_trocar_W() - at_W).normalized();
    const Vector3d tip_W = at_W - past * back_W;
    const Matrix3d R_W0 =
        Kinematics(kRight).Forward(Kinematics(kRight).Inverse(tip_W, 0, 1).joints).linear();
    rolls_[kRight] = std::atan2(-tangent_W.dot(R_W0.col(0)), tangent_W.dot(R_W0.col(1))) + turned;
    return tip_W;
  }
  // Comes along the shaft.
  void Approach(const Vector3d& to_W) {
    const Vector3d back_W = (Kinematics(kRight).p_trocar_W() - to_W).normalized();
    Move(kRight, to_W + 0.03 * back_W, 0.2);
    Move(kRight, to_W, 0.08);
  }
  // Returns the place of the sample left that is nearest to the hook and its port; in the triangle that
  // which is farthest from the port, so that the hook is on its way out.
  Vector3d NextSample(Layer wanted) const {
    Vector3d next_W = Vector3d::Constant(kNoSample);
    double least = std::numeric_limits<double>::infinity();
    for (const AttachmentLink& link : session_.links()) {
      const AttachmentJoint& joint = link.joint();
      for (std::size_t l = 0; l < joint.layers().size(); ++l) {
        const AttachmentJoint::Layer& layer = joint.layers()[l];
        if (layer.bed.index != wanted) continue;
        for (int i = 0; i < layer.bed.size(); ++i) {
          if (link.state().Left(l, i) == 0) continue;
          // The fibres from the gallbladder to the liver. The tip stays by the liver, off the thin wall;
          // a leaf is burnt in its middle.
          std::array<Vector3d, 2> ends_W;
          for (std::size_t side = 0; side < 2; ++side) {
            const auto o = ToSize(joint.members()[ToSize(layer.members[side])].organ);
            ends_W[side] = layer.bed.surface_points[side][ToSize(i)].Position(
                session_.organ(o).vertices, session_.model().organs()[o].rest().triangles);
          }
          const Vector3d fibre_W = ends_W[0] - ends_W[1];
          const double off_liver = layer.bed.law.leaf ? 0.5 : kOffLiver / fibre_W.norm();
          const Vector3d place_W = ends_W[1] + std::min(0.5, off_liver) * fibre_W;
          const double way = (place_W - Kinematics(kRight).p_trocar_W()).norm();
          const double from_tip = (place_W - tips_W_[kRight]).norm();
          const double rank = wanted == kTriangle ? -way : way + kNearness * from_tip;
          if (rank >= least) continue;
          least = rank;
          next_W = place_W;
        }
      }
    }
    return next_W;
  }
};

}  // namespace hpdm
